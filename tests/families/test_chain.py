"""Families for chains: valid, free at both ends of a way, the same for the same seed."""

from __future__ import annotations

import json
from dataclasses import fields, replace

import numpy as np
import pytest

from gcm_learn import seeding
from gcm_learn.arms import Chain
from gcm_learn.errors import FamilyError, UnknownNameError
from gcm_learn.families import (
    PRESETS,
    draw,
    family_from_dict,
    family_names,
    family_to_dict,
    get_family,
    preset_families,
)
from gcm_learn.families.chain.family import ChainFamily
from gcm_learn.motion import opening
from gcm_learn.planners import solve
from gcm_learn.scene import pack, pose
from gcm_learn.situation import (
    arm_to_json,
    shipped_arm,
    situation_from_json,
    situation_to_json,
)

NAMES = [*family_names("chain"), "sequence-chain"]
ARMS = ("panda", "ur5", "nao", "planar-2")
LIMITS = [15.0, 7.5, 10.0, 12.5, 15.0, 20.0, 20.0]


def of_arm(name, model="panda", **given):
    """Return a family with another arm."""
    return family_from_dict({"family": name, "arm": {"model": model, **given}})


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


def text(situation):
    return json.dumps(situation_to_json(situation))


def test_there_are_thirteen_families_for_chains():
    assert len(NAMES) == 13 and all(name.endswith("-chain") for name in NAMES)
    assert all(isinstance(get_family(name), ChainFamily) for name in NAMES)


@pytest.mark.parametrize("name", NAMES)
def test_situations_are_read_back_as_they_are_and_start_free(name):
    for k in range(8):
        situation = draw(name, 4, k)
        assert situation_from_json(json.loads(text(situation))) == situation
        known = opening(pack(situation))
        assert known.clearance > 0.0 and known.hopeful
        assert situation.catch == "any" or len(situation.targets) > 1
        assert 1.0 <= situation.horizon <= 2.0 and situation.arm.kind == "chain"


@pytest.mark.parametrize("name", NAMES)
def test_the_same_seed_gives_the_same_bytes_in_any_order(name):
    forward = [text(draw(name, 3, k)) for k in range(5)]
    assert forward == [text(draw(name, 3, k)) for k in reversed(range(5))][::-1]
    assert len(set(forward)) == 5 and text(draw(name, 4, 0)) != forward[0]


@pytest.mark.parametrize("limits", [[], LIMITS])
@pytest.mark.parametrize("name", NAMES)
def test_a_posture_meets_the_target_in_time_and_is_free_there(name, limits):
    family = of_arm(name, accelerations=limits)
    for k in range(4):
        situation, stage, (way, _, _) = told(family, 5, k)
        arm = situation.arm
        assert arm.joints == tuple(way.start) and 0.0 < way.when <= situation.horizon
        quick, real = stage.takes(way.start, way.end)
        assert quick <= real <= way.when
        middle, turn = pose(situation, 0, way.when)
        np.testing.assert_allclose(middle, way.meet, atol=1e-4 * arm.reach)
        there = replace(situation, arm=replace(arm, joints=tuple(way.end), joint_rates=None))
        rooms = stage.rooms(situation.obstacles, way.end[None], [way.when], there.arm)
        assert rooms[0] > 0.0
        approach = situation.targets[0].approach
        if approach is not None:
            assert turn @ approach.axis @ way.axis == pytest.approx(1.0, abs=1e-9)


@pytest.mark.parametrize("name", NAMES)
def test_a_few_situations_are_caught(name):
    situations = (draw(name, 6, k) for k in range(5))
    assert any(solve(situation).caught for situation in situations)


@pytest.mark.slow
@pytest.mark.parametrize("model", ARMS)
@pytest.mark.parametrize("name", NAMES)
def test_no_family_is_hopeless_for_arms_of_all_sizes(name, model):
    family = of_arm(name, model)
    assert sum(solve(draw(family, 7, k)).caught for k in range(12)) >= 3


@pytest.mark.parametrize("model", ARMS)
def test_sizes_are_those_of_the_arm(model):
    for name in NAMES:
        arm = draw(of_arm(name, model), 8, 0).arm
        assert arm.model == shipped_arm(model)
        assert arm.grasp == pytest.approx(0.028 * arm.reach)


def test_floors_are_for_arms_that_stand_on_them():
    floors = {
        model: [b.name for b in draw(of_arm("swarm-chain", model), 1, 0).bodies].count("floor")
        for model in ARMS
    }
    assert floors == {"panda": 1, "ur5": 0, "nao": 0, "planar-2": 0}
    standing = draw(of_arm("swarm-chain", "iiwa14"), 1, 0)
    assert standing.arm.ignore == ((0, "floor"),)
    low = draw(of_arm("swarm-chain", "ur5", floor_height=[-0.6, -0.6]), 1, 0)
    assert low.bodies[-1].name == "floor"


def test_an_arm_may_come_from_a_file(tmp_path):
    path = tmp_path / "mine.json"
    path.write_text(json.dumps(arm_to_json(shipped_arm("xarm6"))), "utf-8")
    family = of_arm("throw-chain", str(path))
    assert draw(family, 0, 0) == draw(of_arm("throw-chain", "xarm6"), 0, 0)


def test_limits_of_acceleration_are_those_that_are_given():
    arm = draw(of_arm("gate-chain", accelerations=LIMITS, moving=0.5), 2, 0).arm
    assert isinstance(arm, Chain) and arm.max_joint_acceleration == tuple(LIMITS)
    shares = np.abs(arm.joint_rates) / arm.max_joint_speed
    assert 0.0 < shares.max() <= 0.5
    assert draw("gate-chain", 2, 0).arm.max_joint_acceleration is None


def test_laws_of_motion_and_several_catches_occur():
    laws, catches = set(), set()
    for name in NAMES:
        for k in range(6):
            situation = draw(name, 9, k)
            laws |= {body.motion.kind for body in situation.bodies}
            catches.add(situation.catch)
    assert laws == {"quadratic", "piecewise", "sampled", "pendulum"}
    assert catches == {"any", "all", "most"}


def test_a_bounced_ball_turns_round_on_the_table():
    for k in range(6):
        situation = draw("falling-chain", 9, k)
        ball, table = situation.bodies[0], situation.bodies[1]
        start = ball.motion.pieces[1].start
        low, _ = pose(situation, 0, start)
        top = pose(situation, 1, 0.0)[0][2] + table.shape.half_extents[2]
        assert low[2] - ball.shape.radius == pytest.approx(top)
        for t in (start - 0.05, start + 0.05):
            assert pose(situation, 0, t)[0][2] > low[2]


def test_parts_on_a_turntable_keep_their_distances():
    situation = draw("turntable-chain", 9, 1)
    carried = [
        k
        for k, body in enumerate(situation.bodies)
        if body.name == "target" or body.name.startswith("peg")
    ]
    places = [
        np.array([pose(situation, k, t)[0] for k in carried])
        for t in (0.0, 0.4 * situation.horizon, situation.horizon)
    ]
    gaps = [np.linalg.norm(p[:, None] - p, axis=2) for p in places]
    assert len(carried) >= 3 and np.linalg.norm(places[2][0] - places[0][0]) > 0.01
    np.testing.assert_allclose(gaps[1], gaps[0], atol=0.005 * situation.arm.reach)


@pytest.mark.parametrize("name", NAMES)
def test_configurations_survive_json(name):
    family = of_arm(name, accelerations=LIMITS)
    assert family_from_dict(json.loads(json.dumps(family_to_dict(family)))) == family


BAD = [
    ({"arm": {"model": "pandas"}}, 'arm.model: "pandas" is not the name of an arm (known: '),
    ({"arm": {"model": "nobody.json"}}, "arm.model: nobody.json: cannot be read"),
    ({"arm": {"model": 3}}, "arm.model: must be str"),
    ({"arm": {"accelerations": [1.0, 2.0]}}, "arm.accelerations: must have 7 limits"),
    ({"arm": {"accelerations": [0.0] * 7}}, "arm.accelerations[0]: must be at least 1e-09"),
    ({"arm": {"accelerations": 3}}, "arm.accelerations: must be a list of numbers"),
    ({"arm": {"colour": 1}}, "arm.colour: is not a known field"),
    ({"takes": [0.5, 0.2]}, "takes: low 0.5 is above high 0.2"),
    ({"directed": 2.0}, "directed: must be at most 1"),
]


@pytest.mark.parametrize(("given", "reason"), BAD)
def test_bad_ranges_are_refused_by_name(given, reason):
    with pytest.raises(FamilyError) as error:
        family_from_dict({"family": "throw-chain", **given})
    assert str(error.value).startswith(f"throw-chain.{reason}")


@pytest.mark.parametrize("name", PRESETS)
def test_presets_draw_their_families_in_turns(name):
    members = preset_families(name)
    drawn = [draw(name, 7, k) for k in range(7)]

    for k, situation in enumerate(drawn):
        family = members[k % len(members)]
        assert situation.name == f"{name}-{k:07d}-{family.name}"
        own = family.draw(seeding.rng(7, k), situation.name)
        assert own == situation
        assert name.startswith("space") or situation.arm.model == shipped_arm("panda")
        directed = all(target.approach is not None for target in situation.targets)
        assert directed == name.startswith("panda-crowded")
        assert situation.catch == ("most" if name.endswith("sequences") else "any")
    limited = drawn[0].arm.max_joint_acceleration is not None
    assert limited == name.endswith(("accelerated", "sequences"))
    with pytest.raises(UnknownNameError, match="preset"):
        preset_families("panda-hard")
