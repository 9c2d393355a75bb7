"""Families for chains: free at both ends of a way, and what only they promise."""

import json
from dataclasses import fields, replace

import numpy as np
import pytest

from gcm_learn import families, seeding
from gcm_learn.arms import Chain
from gcm_learn.errors import UnknownNameError
from gcm_learn.planners import solve
from gcm_learn.scene import pose
from gcm_learn.situation import arm_to_json, shipped_arm
from tests.families.test_families import CHAINS as NAMES

ARMS = ("panda", "ur5", "nao", "planar-2")
LIMITS = [15.0, 7.5, 10.0, 12.5, 15.0, 20.0, 20.0]


def of_arm(name, model="panda", **given):
    """Return a family with another arm."""
    return families.family_from_dict({"family": name, "arm": {"model": model, **given}})


def told(family, seed, index):
    """Return the way that a draw has been made of, with its situation."""
    seen = []

    def story(self, rng, stage):
        seen.append((stage, type(self).__mro__[1].story(self, rng, stage)))
        return seen[-1][1]

    watched = type("Watched", (type(family),), {"story": story})
    changed = watched(**{f.name: getattr(family, f.name) for f in fields(family)})
    situation = changed.sketch(seeding.rng(seed, index), "watched")
    return situation, *seen[-1]


@pytest.mark.parametrize("limits", [[], LIMITS])
@pytest.mark.parametrize("name", NAMES)
def test_a_posture_meets_the_target_in_time_and_is_free_there(name, limits):
    family = of_arm(name, accelerations=limits)
    for k in range(4):
        situation, stage, story = told(family, 5, k)
        way = story.way
        arm = situation.arm
        assert arm.joints == tuple(way.start) and 0.0 < way.when <= situation.horizon
        quick, real = stage.takes(way.start, way.end)
        assert quick <= real <= way.when
        middle, turn = pose(situation, 0, way.when)
        np.testing.assert_allclose(middle, way.meet, atol=1e-4 * arm.reach)
        there = replace(situation, arm=replace(arm, joints=tuple(way.end), joint_rates=None))
        rooms = stage.rooms(situation.obstacles, way.end[None], [way.when], there.arm)
        assert rooms[0] > 0.0
        for approach in situation.targets[0].approach:
            assert turn @ approach.axis @ way.axis == pytest.approx(1.0, abs=1e-9)


@pytest.mark.parametrize("name", NAMES)
def test_a_few_situations_are_caught(name):
    situations = (families.draw(name, 6, k) for k in range(5))
    assert any(solve(situation).caught for situation in situations)


@pytest.mark.slow
@pytest.mark.parametrize("model", ARMS)
@pytest.mark.parametrize("name", NAMES)
def test_no_family_is_hopeless_for_arms_of_all_sizes(name, model):
    family = of_arm(name, model)
    assert sum(solve(families.draw(family, 7, k)).caught for k in range(12)) >= 3


@pytest.mark.parametrize("model", ARMS)
def test_sizes_are_those_of_the_arm(model):
    for name in NAMES:
        arm = families.draw(of_arm(name, model), 8, 0).arm
        assert arm.model == shipped_arm(model)
        assert arm.grasp == pytest.approx(0.028 * arm.reach)


def test_floors_are_for_arms_that_stand_on_them():
    floors = {
        model: [b.name for b in families.draw(of_arm("swarm-chain", model), 1, 0).bodies].count(
            "floor"
        )
        for model in ARMS
    }
    assert floors == {"panda": 1, "ur5": 0, "nao": 0, "planar-2": 0}
    standing = families.draw(of_arm("swarm-chain", "iiwa14"), 1, 0)
    assert standing.arm.ignore == ((0, "floor"),)
    low = families.draw(of_arm("swarm-chain", "ur5", floor_height=[-0.6, -0.6]), 1, 0)
    assert low.bodies[-1].name == "floor"


def test_an_arm_may_come_from_a_file(tmp_path):
    path = tmp_path / "mine.json"
    path.write_text(json.dumps(arm_to_json(shipped_arm("xarm6"))), "utf-8")
    family = of_arm("throw-chain", str(path))
    assert families.draw(family, 0, 0) == families.draw(of_arm("throw-chain", "xarm6"), 0, 0)


def test_limits_of_acceleration_are_those_that_are_given():
    arm = families.draw(of_arm("gate-chain", accelerations=LIMITS, moving=0.5), 2, 0).arm
    assert isinstance(arm, Chain) and arm.max_joint_acceleration == tuple(LIMITS)
    shares = np.abs(arm.joint_rates) / arm.max_joint_speed
    assert 0.0 < shares.max() <= 0.5
    assert families.draw("gate-chain", 2, 0).arm.max_joint_acceleration is None


def test_laws_of_motion_and_several_catches_occur():
    laws, catches = set(), set()
    for name in NAMES:
        for k in range(6):
            situation = families.draw(name, 9, k)
            laws |= {body.motion.kind for body in situation.bodies}
            catches.add(situation.catch)
    assert laws == {"quadratic", "piecewise", "sampled", "pendulum"}
    assert catches == {"any", "all", "most"}


def test_a_bounced_ball_turns_round_on_the_table():
    for k in range(6):
        situation = families.draw("falling-chain", 9, k)
        ball, table = situation.bodies[0], situation.bodies[1]
        start = ball.motion.pieces[1].start
        low, _ = pose(situation, 0, start)
        top = pose(situation, 1, 0.0)[0][2] + table.shape.half_extents[2]
        assert low[2] - ball.shape.radius == pytest.approx(top)
        for t in (start - 0.05, start + 0.05):
            assert pose(situation, 0, t)[0][2] > low[2]


def test_parts_on_a_turntable_keep_their_distances():
    situation = families.draw("turntable-chain", 9, 1)
    names = [body.name for body in situation.bodies]
    carried = [k for k, n in enumerate(names) if n == "target" or n.startswith("peg")]
    times = (0.0, 0.4 * situation.horizon, situation.horizon)
    places = [np.array([pose(situation, k, t)[0] for k in carried]) for t in times]
    gaps = [np.linalg.norm(p[:, None] - p, axis=2) for p in places]
    assert len(carried) >= 3 and np.linalg.norm(places[2][0] - places[0][0]) > 0.01
    np.testing.assert_allclose(gaps[1], gaps[0], atol=0.005 * situation.arm.reach)


@pytest.mark.parametrize("name", families.PRESETS)
def test_presets_draw_their_families_in_turns(name):
    members = families.preset_families(name)
    drawn = [families.draw(name, 7, k) for k in range(7)]

    for k, situation in enumerate(drawn):
        family = members[k % len(members)]
        assert situation.name == f"{name}-{k:07d}-{family.name}"
        own = family.draw(seeding.rng(7, k), situation.name)
        assert own == situation
        robot, _, _ = name.partition("-")
        assert robot == "space" or situation.arm.model == shipped_arm(robot)
        directed = all(target.approach for target in situation.targets)
        assert directed == (family.kind == "chain" and family.directed == 1.0)
        assert situation.catch == ("most" if name.endswith("sequences") else "any")
        held = [target.hold is not None for target in situation.targets]
        assert held == [family.holds.share == 1.0] * len(held)
    limited = drawn[0].arm.max_joint_acceleration is not None
    assert limited == (family.holds.share == 1.0 or name.endswith(("accelerated", "sequences")))
    with pytest.raises(UnknownNameError, match="preset"):
        families.preset_families("panda-hard")
