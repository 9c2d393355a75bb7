"""The referee's geometry, for tests that hold kernels against it: arms and bodies as JSON."""

import numpy as np

from gcm_learn.referee import bodies_of, nearest_obstacle, overlap
from gcm_learn.referee.chain import ChainMotion
from gcm_learn.referee.curves import curve_of
from gcm_learn.referee.joint_arms import read_chain, read_spatial
from gcm_learn.referee.segments import segments_apart
from gcm_learn.referee.shapes import point_gaps, segment_gaps

LONG = 3.0
"""Until when bodies may be asked for [s]."""


def arm_of(given):
    """The field `arm` of a situation, as the referee reads it: a spatial arm, too, is a chain."""
    return read_chain(given, {}) if given["kind"] == "chain" else read_spatial(3, given)


def hand_of(arm, joints):
    """Hands (k, 3) and the axes (k, 3) along which they reach, of joints (k, n)."""
    joint, point = arm.points["hand"]
    return (
        arm.geometry.point(joints, joint, point),
        arm.geometry.direction(joints, joint, arm.axis),
    )


def links_of(arm, joints):
    """Ends (links, 2, k, 3) and radii (links,) of an arm's capsules along joints (k, n)."""
    return arm.geometry.ends(joints).transpose(1, 2, 0, 3), arm.geometry.radii


def body_in(given):
    """A body with a motion, as the referee reads it; a motion alone will do."""
    return bodies_of([{"role": "", "name": "", "shape": POINT} | given], LONG)[0]


POINT = {"kind": "sphere", "radius": 0.0}


def poses(given, times):
    """Centres (k, 3) and rotations (k, 3, 3), body to world, at times (k,)."""
    return body_in(given).poses(np.asarray(times, dtype=float))


def signed_distance(given, time, points):
    """Signed distances of points (k, 3) or (3,) to a body at a time."""
    found = body_in(given).gaps(time, np.atleast_2d(points))
    return found if np.ndim(points) == 2 else found[0]


def least_at(situation, arm, times, joints):
    """Least distances to obstacles, and of pairs of links, over postures (k, n) at times (k,)."""
    ends, radii, outside, itself = arm.geometry.ends(joints), arm.geometry.radii, [], []
    for body in bodies_of(situation["bodies"], LONG):
        links = [i for i in range(len(radii)) if (i, body.name) not in arm.ignored]
        if body.role == "obstacle":
            outside += [_gaps(body, times, ends[:, i]) - radii[i] for i in links]
    for i, j in arm.geometry.pairs:
        apart = segments_apart(ends[:, i, 0], ends[:, i, 1], ends[:, j, 0], ends[:, j, 1])
        itself.append(apart - radii[i] - radii[j])
    return tuple(float(np.min(gaps, initial=np.inf)) for gaps in (outside, itself))


def _gaps(body, times, axes):
    """Signed distances (k,) of segments (k, 2, 3) to a body."""
    centre, turn = body.poses(times)
    return segment_gaps(body.shape, *(_into(centre, turn, axes[:, e]) for e in (0, 1)))


def _into(centre, turn, points):
    return np.einsum("kij,ki->kj", turn, points - centre)


def curve_in(path):
    """The joints of a solution's trajectory, between samples too."""
    columns = {name: np.array(column, dtype=float) for name, column in path.items()}
    return curve_of(columns["time"], columns["joints"], columns.get("rates"))


def motion_of(arm, path):
    """The links of an arm along the trajectory of a solution."""
    return ChainMotion(arm.geometry, curve_in(path), arm.size)


def lowest_gap(situation, path, close=1e-7):
    """Least signed distance of links and obstacles along a trajectory, with its error."""
    arm = arm_of(situation["arm"])
    bodies = bodies_of(situation["bodies"], path["time"][-1])
    return nearest_obstacle(motion_of(arm, path), bodies, arm.ignored, -1.0, close).gap


__all__ = [
    "arm_of",
    "body_in",
    "curve_in",
    "hand_of",
    "least_at",
    "links_of",
    "lowest_gap",
    "motion_of",
    "overlap",
    "point_gaps",
    "poses",
    "segment_gaps",
    "segments_apart",
    "signed_distance",
]
