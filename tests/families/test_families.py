"""Families: the same for the same seed, valid, within their ranges, as JSON and back."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest

from gcm_learn import seeding
from gcm_learn.errors import FamilyError, FileFormatError, UnknownNameError
from gcm_learn.families import (
    draw,
    family_from_dict,
    family_names,
    family_to_dict,
    get_family,
    random_planar,
    read_family,
)
from gcm_learn.motion import opening
from gcm_learn.motion.rules import start_clearance
from gcm_learn.planners import get_planner
from gcm_learn.scene.packing import pack
from gcm_learn.situation import situation_from_json, situation_to_json
from tests.refusals import refusal

NAMES = family_names("planar")
SPACE = [*family_names("spatial"), "sequence-space"]
CHAINS = [*family_names("chain"), "sequence-chain"]
EVERY = pytest.mark.parametrize("name", [*NAMES, *SPACE, *CHAINS])
AIMED = [name for name in NAMES if hasattr(get_family(name), "aimed")]
BALLS = [name for name in NAMES if hasattr(get_family(name), "sizes") and "spinning" not in name]


def some(family, count=12, seed=3):
    return [draw(family, seed, k) for k in range(count)]


def text(situation):
    return json.dumps(situation_to_json(situation))


@EVERY
def test_an_item_depends_on_seed_and_index_alone(name):
    count = 12 if name in NAMES else 6
    forward = some(name, count)
    assert forward == [draw(name, 3, k) for k in reversed(range(count))][::-1]
    nameless = [text(replace(s, name="")) for s in forward + some(name, count, seed=4)]
    assert len(set(nameless)) == 2 * count


@EVERY
def test_situations_survive_json_and_start_free(name):
    count = 30 if name in NAMES else 40 if name in SPACE else 8
    hopeful = 0
    for k, situation in enumerate(some(name, count)):
        assert situation.name == f"{name}-{k:07d}"
        assert situation_from_json(json.loads(text(situation))) == situation
        assert situation.is_solid == (name == "pendulum" or name.endswith("-solid"))
        assert situation.is_spatial == (name in SPACE)
        assert situation.catch == "any" or (len(situation.targets) > 1 and name not in NAMES)
        assert 0.5 <= situation.horizon <= 2.0 or name in NAMES
        known = opening(pack(situation))
        assert known.clearance > 0.0
        hopeful += known.hopeful
    assert hopeful >= 0.97 * count or name in NAMES


@pytest.mark.parametrize("name", NAMES)
def test_another_arm_is_one_replace(name):
    family = get_family(name)
    arm = replace(
        family.arm, upper_arm=(0.5, 0.6), right=1.0, thickness=(0.05,), hand_speed=(9.0, 10.0),
        horizon=(2.0, 2.1), grasp=(0.01, 0.02), inner_margin=0.2, outer_margin=0.3,
    )  # fmt: skip
    for situation in some(replace(family, arm=arm)):
        one = situation.arm
        assert 0.5 <= one.upper_arm <= 0.6 and one.elbow == "right" and one.thickness == 0.05
        assert 9.0 <= one.max_hand_speed <= 10.0 and 2.0 <= situation.horizon <= 2.1
        assert 0.01 <= one.grasp <= 0.02
        assert one.inner_reach + 0.2 <= math.hypot(*one.hand) <= one.reach - 0.3


@pytest.mark.parametrize("name", NAMES)
def test_number_of_obstacles_keeps_its_range(name):
    usual = {len(s.obstacles) for s in some(name, 40)}
    low, high = get_family(name).obstacles
    assert usual == set(range(low, high + 1))
    assert {len(s.obstacles) for s in some(replace(get_family(name), obstacles=(6, 6)), 4)} == {6}


@pytest.mark.parametrize("name", BALLS)
def test_sizes_keep_their_ranges(name):
    family = get_family(name)
    sizes = replace(family.sizes, target=(0.2, 0.21))
    for situation in some(replace(family, sizes=sizes)):
        assert 0.2 <= situation.targets[0].shape.radius <= 0.21


SPEEDS = {
    "moving-point": ("speed", "point"),
    "crossing-swarm": ("speed", "member"),
    "behind-mover": ("others", "obstacle"),
    "random-planar": ("speed", "obstacle"),
}


@pytest.mark.parametrize("name", SPEEDS)
def test_faster_is_one_replace(name):
    field, prefix = SPEEDS[name]
    family = get_family(name)
    if hasattr(family, "still"):
        family = replace(family, still=0.0)
    fast = replace(family, **{field: (2.0, 2.5)}, obstacles=(4, 4))
    for situation in some(fast):
        moving = [b.motion for b in situation.obstacles if b.name.startswith(prefix)]
        speeds = [math.hypot(*m.velocity) / situation.arm.max_hand_speed for m in moving]
        assert len(speeds) >= 3 and 2.0 - 1e-9 <= min(speeds) <= max(speeds) <= 2.5 + 1e-9


@pytest.mark.parametrize("name", AIMED)
def test_aimed_obstacles_matter_more_than_others(name):
    straight, family = get_planner("straight"), get_family(name)
    caught = []
    for share in (0.0, 1.0):
        changed = replace(family, aimed=share, obstacles=(2, 2))
        caught.append(sum(straight.plan(s).caught for s in some(changed, 40)))
    if name == "behind-mover":
        assert sum(caught) <= 4  # the cover is enough
    else:
        assert caught[0] >= caught[1] + 8


@EVERY
def test_configurations_survive_json(name):
    family = get_family(name)
    values = family_to_dict(family)
    assert next(iter(values)) == "family" and family_from_dict(values) == family
    changes = {"upper_arm": (1.0, 1.0)} if name in NAMES else {"moving": 0.25}
    changed = replace(family, arm=replace(family.arm, **changes))
    again = family_from_dict(json.loads(json.dumps(family_to_dict(changed))))
    assert again == changed != family and type(again) is type(family)
    assert some(again, 3) == some(changed, 3)


def test_what_is_left_out_keeps_its_default():
    given = {"family": "gate", "opening": [0.5, 0.8], "arm": {"right": 1.0}}
    gate = get_family("gate")
    expected = replace(gate, opening=(0.5, 0.8), arm=replace(gate.arm, right=1.0))
    assert family_from_dict(given) == expected


BAD = [
    ({"family": "gate", "colour": 1}, "gate.colour: is not a known field"),
    ({"family": "gate", "arm": {"legs": 2}}, "gate.arm.legs: is not a known field"),
    ({"family": "gate", "arm": 3}, "gate.arm: must be an object (got 3)"),
    ({"family": "gate", "opening": [0.8, 0.3]}, "gate.opening: low 0.8 is above high 0.3"),
    ({"family": "gate", "opening": [0.2, 1.5]}, "gate.opening: must be at most 0.95 (got 1.5)"),
    ({"family": "gate", "opening": 0.2}, "gate.opening: must be a range [low, high] (got 0.2)"),
    ({"family": "gate", "opening": [0.2, "x"]}, 'gate.opening: must be a number (got "x")'),
    ({"family": "gate", "opening": [0.2, math.nan]}, "gate.opening: must be finite (got nan)"),
    ({"family": "gate", "opening": [0.2, True]}, "gate.opening: must be a number (got true)"),
    ({"family": "gate", "obstacles": [1, 4]}, "gate.obstacles: must be at least 2 (got 1)"),
    ({"family": "gate", "obstacles": [2, 10**9]}, "gate.obstacles: must be at most 1000"),
    ({"family": "gate", "obstacles": [2, 4.5]}, "gate.obstacles: must be whole numbers (got 4.5)"),
    ({"family": "gate", "arm": {"upper_arm": [0, 1]}}, "gate.arm.upper_arm: must be at least"),
    ({"family": "gate", "arm": {"thickness": []}}, "gate.arm.thickness: must be a list of"),
    ({"family": "gate", "arm": {"inner_margin": 1, "outer_margin": 1}}, "gate.arm.inner_margin:"),
    ({"family": "falling", "sizes": {"radius": [0, 1]}}, "falling.sizes.radius: must be at least"),
    ({"opening": [0, 1]}, "family: is missing (known: static-clutter"),
    ([], "family: must be an object (got a list of 0)"),
    *(
        ({"family": "throw-chain", **given}, f"throw-chain.{message}")
        for given, message in (
            ({"arm": {"model": "pandas"}}, 'arm.model: "pandas" is not the name of an arm (known:'),
            ({"arm": {"model": "nobody.json"}}, "arm.model: nobody.json: cannot be read"),
            ({"arm": {"model": 3}}, "arm.model: must be str"),
            ({"arm": {"accelerations": [1.0, 2.0]}}, "arm.accelerations: must have 7 limits"),
            ({"arm": {"accelerations": [0.0] * 7}}, "arm.accelerations[0]: must be at least 1e-09"),
            ({"arm": {"jerks": [1.0, 2.0]}}, "arm.jerks: must have 7 limits"),
            ({"holds": {"seconds": [-0.1, 0.2]}}, "holds.seconds: must be at least 0 (got -0.1)"),
            ({"arm": {"accelerations": 3}}, "arm.accelerations: must be a list of numbers"),
            ({"arm": {"colour": 1}}, "arm.colour: is not a known field"),
            ({"takes": [0.5, 0.2]}, "takes: low 0.5 is above high 0.2"),
            ({"directed": 2.0}, "directed: must be at most 1"),
        )
    ),
]


@pytest.mark.parametrize(("values", "message"), BAD)
def test_bad_configurations_are_refused_in_one_line(values, message):
    assert refusal(FamilyError, family_from_dict, values).startswith(message)


def test_records_check_themselves():
    gate = get_family("gate")
    for change, words in (
        ({"bolts": 1.5}, "bolts: must be at most 1"),
        ({"arm": {"right": 1.0}}, "arm: must be ArmRanges"),
        ({"arm": gate.sizes}, "arm: must be ArmRanges"),
    ):
        assert words in refusal(FamilyError, replace, gate, **change)


def test_unknown_names_list_the_known_ones():
    for ask in (get_family, lambda n: draw(n, 0, 0), lambda n: family_from_dict({"family": n})):
        with pytest.raises(UnknownNameError, match="family: 'hoop' is not one of static-clutter"):
            ask("hoop")


FILES = [
    ('{"family": "gate",\n "arm": {\n  "right": 7}}', ":3: gate.arm.right: must be at most 1"),
    ('{"family": "gate",\n "colour": 7}', ":2: gate.colour: is not a known field"),
    ('{"family": "gate", "bolts": 0, "bolts": 1}', ":1: gate.bolts: is given twice"),
    ('{"arm": {},\n "family": "hoop"}', ":2: family: 'hoop' is not one of"),
    ('{"family":\n', "not valid JSON"),
    ("[]", ":1: family: must be an object"),
]


@pytest.mark.parametrize(("text", "message"), FILES)
def test_files_are_refused_with_file_and_line(text, message, tmp_path):
    path = tmp_path / "ranges.json"
    path.write_text(text)
    said = refusal(FileFormatError, read_family, path)
    assert said.startswith(str(path)) and message in said


def test_files_hold_what_was_written(tmp_path):
    path = tmp_path / "ranges.json"
    path.write_text(json.dumps(family_to_dict(get_family("pendulum"))))
    assert read_family(path) == get_family("pendulum")
    with pytest.raises(FileFormatError, match="cannot be read"):
        read_family(tmp_path / "none.json")


def test_a_range_without_width_takes_nothing_from_the_generator():
    gate = get_family("gate")
    fixed = replace(gate, arm=replace(gate.arm, grasp=(0.07, 0.07)))
    one, other = draw(gate, 0, 5), draw(fixed, 0, 5)
    assert other.arm == replace(one.arm, grasp=0.07) and other.bodies[:2] == one.bodies[:2]


def test_where_there_is_no_room_the_last_draw_is_given():
    family = get_family("static-clutter")
    huge = replace(family, sizes=replace(family.sizes, radius=(3.0, 3.0), bars=0.0))
    situation = draw(huge, 0, 0)
    assert start_clearance(pack(situation)) <= 0.0


def test_hands_start_in_every_direction():
    hands = np.array([s.arm.hand for s in some("static-clutter", 200)])
    angles = np.arctan2(hands[:, 1], hands[:, 0])
    assert np.histogram(angles, bins=4, range=(-math.pi, math.pi))[0].min() > 25


def test_random_planar_is_the_family_without_redrawing():
    family = get_family("random-planar")
    for k in range(20):
        once = random_planar(seeding.rng(5, k), name="x")
        assert once == family.sketch(seeding.rng(5, k), "x")
        if start_clearance(pack(once)) > 0.0:
            assert once == family.draw(seeding.rng(5, k), "x")
