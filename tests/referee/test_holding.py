"""The referee's holds by other means: the contract's numbers, differences, dense samples."""

import numpy as np
import pytest

from gcm_learn.referee.carrying import capsule_of
from gcm_learn.referee.holding import Grip
from tests import chains, geometry
from tests.worlds import SHAPES, ball, body, law, still

TINY = 1e-5
LEVERS = {"kind": "chain", "model": chains.LEVERS, "posture": [0.4, 0.25, -0.7], "grasp": 0.0}
PATH = {
    "time": [0.0, 0.3, 0.7],
    "joints": [[0.4, 0.25, -0.7], [0.9, 0.4, 0.1], [1.1, 0.2, 0.5]],
    "rates": [[1.0, -0.2, 0.5], [1.0, 0.3, 1.5], [0.0, -0.5, 0.3]],
}


def test_boxes_are_carried_as_the_contract_says():
    for half, axis, radius in (
        ([0.03, 0.1, 0.04], [0, 0.1, 0], 0.05),
        ([0.05, 0.05, 0.02], [0.05, 0, 0], 0.053852),
    ):
        found = capsule_of({"kind": "box", "half_extents": half})
        assert found[0] == pytest.approx(axis) and found[1] == pytest.approx(radius, abs=6e-7)


@pytest.mark.parametrize(("spin", "speed"), [(1.0, 0.0), (0.0, 0.891619)])
def test_the_relative_speed_is_the_contracts(spin, speed):
    arm = geometry.arm_of({"kind": "chain", "model": "planar-2", "posture": [0, 0], "grasp": 0})
    path = {"time": [0, 1], "joints": [[0.3, -0.5]] * 2, "rates": [[1.0, 0.0]] * 2}
    found = grip(arm, path, {"motion": still([0, 0, 0], spin=[0, 0, spin])})
    assert found._measured(np.zeros(1), np.zeros(1))[0][0, 0] == pytest.approx(speed, abs=6e-7)


def grip(arm, path, given, **asked):
    hold = {"seconds": 0, "relative_speed": 1.0} | asked
    target = body("target", "t", ball(0.1), None, hold=hold) | given
    curve = geometry.curve_in(path)
    return Grip(arm.geometry, curve, arm.points["hand"], arm.axis, geometry.body_in(target))


def sampled(rng):
    turns = rng.normal(size=(8, 4))
    turns /= np.linalg.norm(turns, axis=1, keepdims=True)
    times, places = np.linspace(0.0, 0.6, 8), rng.normal(size=(8, 3))
    motion = {"kind": "sampled", "times": times, "positions": places, "orientations": turns}
    return {name: np.array(v).tolist() if name != "kind" else v for name, v in motion.items()}


def seen(arm, given, times):
    """Relative speed, distance and difference of directions, by differences of poses."""
    curve = geometry.curve_in(PATH)
    hands = [geometry.hand_of(arm, curve.joints(times + dt)) for dt in (-TINY, 0.0, TINY)]
    poses = [geometry.poses(given, times + dt) for dt in (-TINY, 0.0, TINY)]
    own = (hands[2][0] - hands[0][0]) / (2.0 * TINY)
    inner = np.einsum("kji,kj->ki", poses[1][1], hands[1][0] - poses[1][0])
    moved = [centre + np.einsum("kij,kj->ki", turn, inner) for centre, turn in poses]
    speed = np.linalg.norm(own - (moved[2] - moved[0]) / (2.0 * TINY), axis=1)
    gaps = geometry.point_gaps(given["shape"], inner)
    wanted = poses[1][1] @ given["approach"]["axis"]
    return speed, gaps, np.arccos(np.clip((wanted * hands[1][1]).sum(axis=1), -1.0, 1.0))


@pytest.mark.parametrize("kind", ["quadratic", "sampled", "pendulum"])
@pytest.mark.parametrize("seed", range(4))
def test_holds_are_proven_to_a_hair(kind, seed):
    """The largest values of dense samples are kept, and a little less is a complaint."""
    rng = np.random.default_rng(seed)
    arm, motion = geometry.arm_of(LEVERS), sampled(rng) if kind == "sampled" else law(rng, kind)
    given = {"shape": SHAPES[seed], "motion": motion, "approach": {"axis": [0, 0, 1], "within": 1}}
    first, last = 0.05, 0.65
    times = np.linspace(first, last, 20_001)
    breaks = np.array([*PATH["time"], *motion.get("times", [])])
    times = times[np.abs(times[:, None] - breaks).min(axis=1) > 2.0 * TINY]
    most = [found.max() for found in seen(arm, given, times)]
    for k, words in enumerate(["does not move with", "misses", "approaches"]):
        for sign in (1.0, -1.0):
            speed, grasp, angle = (
                x * (1.001 if j != k else 1.0 + sign * 1e-3) for j, x in enumerate(most)
            )
            given["approach"]["within"] = min(angle, np.pi)
            found = grip(arm, PATH, given, relative_speed=speed)
            complaints = found.complaints(grasp, 1e-6, 1e-6, first, last)
            assert [words in c.what for c in complaints] == ([] if sign > 0.0 else [True])
