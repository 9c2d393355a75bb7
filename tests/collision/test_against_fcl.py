"""Distances of limbs in space beside those of python-fcl, which shares nothing with ours.

Fcl's distance is that of two points which it found, so it is never below the true one but for
rounding. Of spheres and capsules it is exact. Of boxes and cylinders it is mostly right to 1e-6;
now and then its search stops early, and it is up to some 1e-3 too far. Where only a bone's skin is
inside a solid it tells how deep, to 1e-6.
"""

import fcl
import numpy as np
import pytest

from gcm_learn import seeding
from gcm_learn.collision.postures import desk_of, distance_at
from gcm_learn.scene import pack
from gcm_learn.situation import situation_from_json
from tests.geometry import arm_of, hand_of, least_at, links_of, poses
from tests.referee.answers import SPATIAL_ARM as ARM
from tests.worlds import SHAPES, ball, body, law, still

SKIN = 0.05  # radius of the capsules that stand for bones
ROUNDING = 1e-6
OFTEN = 0.95  # share of fcl's answers that are right to 1e-5, and the others are
EARLY = 5e-3  # too far by at most this


def solid_of(shape):
    """A shape of the exchange format as fcl's."""
    if shape["kind"] == "sphere":
        return fcl.Sphere(shape["radius"])
    if shape["kind"] == "box":
        return fcl.Box(*(2.0 * half for half in shape["half_extents"]))
    kind = fcl.Capsule if shape["kind"] == "capsule" else fcl.Cylinder
    return kind(shape["radius"], 2.0 * shape["half_length"])


def bone(a, b):
    """A capsule from a to b."""
    z = (b - a) / np.linalg.norm(b - a)
    x = np.cross(z, np.eye(3)[np.argmin(np.abs(z))])
    x /= np.linalg.norm(x)
    turn = fcl.Transform(np.stack([x, np.cross(z, x), z], axis=1), 0.5 * (a + b))
    return fcl.CollisionObject(fcl.Capsule(SKIN, np.linalg.norm(b - a)), turn)


def apart(first, second):
    """Signed distance; fcl is more exact outside where it is not asked for the sign."""
    for signed in (False, True):
        request = fcl.DistanceRequest(enable_signed_distance=signed)
        found = fcl.distance(first, second, request, fcl.DistanceResult())
        if found > 0.0:
            break
    return found


def asked(shape, kind, count=800):
    """Distances of limb and obstacle at random postures and times: fcl's, ours, the referee's."""
    rng, rows = seeding.rng(5, SHAPES.index(shape)), []
    shoulder, arm = np.array(ARM["base"]["origin"]), arm_of(ARM | {"thickness": 0.0})
    goal = body("target", "goal", ball(0.1), still([9.0, 0.0, 0.0]))
    while len(rows) < count:
        motion = law(rng, kind)
        place = "pivot" if kind == "pendulum" else "position"
        motion[place] = np.add(shoulder, np.multiply(0.5, motion[place])).tolist()
        post = body("obstacle", "post", shape, motion)
        made = {"format": "gcm-learn/situation@2", "name": "", "horizon": 1.0}
        scene = pack(situation_from_json(made | {"arm": ARM, "bodies": [goal, post]}))
        desk = desk_of(scene)
        for t in rng.random(25):
            q = rng.uniform(*np.transpose(ARM["joint_range"]))
            hand, elbow = hand_of(arm, q[None])[0][0], links_of(arm, q[None])[0][0, 1, 0]
            (centre,), (turn,) = poses(post, [t])
            lies = fcl.Transform(turn, centre)
            solid = fcl.CollisionObject(solid_of(shape), lies)
            limb = (bone(shoulder, elbow), bone(elbow, hand))
            theirs = min(apart(part, solid) for part in limb)
            found = least_at({"bodies": [post]}, arm, np.array([t]), q[None])[0]
            rows.append((theirs + SKIN, distance_at(scene, q, t, desk), found))
    return np.array(rows).T


@pytest.mark.parametrize("kind", ["quadratic", pytest.param("pendulum", marks=pytest.mark.slow)])
@pytest.mark.parametrize("shape", SHAPES, ids=lambda shape: shape["kind"])
def test_limbs_are_as_far_from_solids_as_fcl_says(shape, kind):
    theirs, ours, referee = asked(shape, kind)
    ours = np.maximum(ours, 0.0)  # depths are not judged
    assert ours == pytest.approx(np.maximum(referee, 0.0), abs=1e-8)
    outside, inside = ours > SKIN, (ours > 1e-3) & (ours < SKIN)
    off = theirs - ours
    assert outside.sum() > 50 and inside.any()
    assert off[outside | inside].min() > -ROUNDING
    assert (off[outside] < 1e-5).mean() > OFTEN and off[outside].max() < EARLY
    assert off[inside].max() < 2.0 * ROUNDING
    assert (theirs[ours == 0.0] < ROUNDING).all()  # where a bone itself goes through
