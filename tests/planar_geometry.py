"""The referee's geometry in the plane of an arm, for records of the package."""

from dataclasses import asdict
from functools import lru_cache

import numpy as np

from gcm_learn.referee import arm_of, bodies_of
from gcm_learn.referee.planar_arm import joint_rates
from gcm_learn.referee.shapes import point_gaps, ready, segment_gaps
from gcm_learn.situation import Body, Disc, PlanarQuadratic, Situation, situation_to_json

REST = (0.0, 0.0)
NOWHERE = Body("target", "", Disc(1.0), PlanarQuadratic(REST, REST, REST))
LOWS, CLOSER = 3, 3
"""Local minima of a distance that are examined more closely, and how often."""


@lru_cache(maxsize=256)
def _read(situation):
    """Arm and bodies as the referee reads them."""
    given = situation_to_json(situation)
    return arm_of(given, {}), bodies_of(given["bodies"], situation.horizon)


def _arm(arm):
    return _read(Situation("", 1.0, arm, (NOWHERE,)))[0]


def elbow_of(arm, hand):
    """Elbows (n, 2) of hands (n, 2)."""
    return _arm(arm).elbows(np.asarray(hand, dtype=float))


def rates(arm, path):
    """Largest rates (n - 1, 2) of both joints while the hand moves straight."""
    return joint_rates(_arm(arm), path.time, path.hand)


def by_hand(arm, path, t):
    """Hand and elbow (k, 2) at times t (k,)."""
    hand = np.stack([np.interp(t, path.time, x) for x in path.hand.T], axis=1)
    return hand, elbow_of(arm, hand)


def place(situation, body, t):
    """Centres (n, 3) and rotations (n, 3, 3) of a body in arm-plane coordinates at times t."""
    arm, bodies = _read(situation)
    k = [id(b) for b in situation.bodies].index(id(body))
    centre, turn = bodies[k].poses(np.asarray(t, dtype=float))
    frame = np.stack([*arm.plane.axes, np.cross(*arm.plane.axes)])
    return (centre - arm.plane.origin) @ frame.T, frame @ turn


def depths(shape, points):
    """Signed distances (n,) of points (n, 3) in the body's frame."""
    return point_gaps(members(shape), points)


def members(shape):
    """A shape as the referee takes it."""
    return ready(asdict(shape) | {"kind": shape.kind})


def segment_distances(shape, pose, a, b):
    """Distances (n,) of plane segments a-b to a shape at poses; 0 where they meet."""
    return np.maximum(segment_gaps(members(shape), _into(pose, a), _into(pose, b)), 0.0)


def point_distances(shape, pose, points):
    """Distances (n,) of plane points (n, 2) to a shape at one pose; 0 inside."""
    n = len(points)
    many = np.broadcast_to(pose[0], (n, 3)), np.broadcast_to(pose[1], (n, 3, 3))
    return np.maximum(depths(shape, _into(many, points)), 0.0)


def _into(pose, points):
    """Plane points (n, 2) in the frames of poses."""
    spatial = np.concatenate([points, np.zeros((len(points), 1))], axis=1) - pose[0]
    return np.einsum("nij,ni->nj", pose[1], spatial)


def limb_distances(situation, body, limb, t):
    """Distances (n,) of a body to the whole limb at times t."""
    hand, elbow = limb
    pose = place(situation, body, t)
    upper = segment_distances(body.shape, pose, np.zeros_like(elbow), elbow)
    return np.minimum(upper, segment_distances(body.shape, pose, elbow, hand))


def nearest(situation, limb, t):
    """Smallest distance of the limb to any obstacle; `limb` gives hands and elbows at times."""
    distances = (
        _lowest(lambda t, b=body: limb_distances(situation, b, limb(t), t), t)
        for body in situation.obstacles
    )
    return min(distances, default=np.inf)


def _lowest(distance, t):
    """Minimum of a distance: sampled at t, then ever more closely around its lowest lows."""
    d = distance(t)
    best = d.min()
    if len(t) == 1:
        return best
    padded = np.concatenate([[np.inf], d, [np.inf]])
    lows = np.flatnonzero((padded[1:-1] <= padded[:-2]) & (padded[1:-1] <= padded[2:]))
    lows = lows[np.argsort(d[lows])][:LOWS]
    a, b = t[np.maximum(lows - 1, 0)], t[np.minimum(lows + 1, len(t) - 1)]
    for _ in range(CLOSER):
        fine = np.linspace(a, b, 17)
        values = distance(fine.ravel()).reshape(fine.shape)
        best = min(best, values.min())
        m, each = values.argmin(axis=0), np.arange(len(lows))
        a, b = fine[np.maximum(m - 1, 0), each], fine[np.minimum(m + 1, 16), each]
    return best
