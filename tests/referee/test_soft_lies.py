"""Planted lies of version 4: tiny changes of true answers, which are accepted without them."""

import json
import math
import re

import pytest

from gcm_learn.referee import Unreadable, examine, judge
from gcm_learn.referee.__main__ import main
from tests.referee.answers import planar
from tests.referee.belt import AHEAD, belt, edited, flight, pieces, zigzag
from tests.worlds import ball, body, still

PAIR = belt()
SITUATION, SOLUTION = ("situation",), ("solution",)
BODIES, ARM = (*SITUATION, "bodies"), (*SITUATION, "arm")
BOX, WALL, BULLET = ((*BODIES, k) for k in (0, 2, 3))
MOTION, HOLD, PLACE = ((*BOX, name) for name in ("motion", "hold", "place"))
FINGER = (*ARM, "model", "joints", 3)
PATH, CATCHES = (*SOLUTION, "trajectory"), (*SOLUTION, "catches")
ENTRY = (*CATCHES, 0)
REACH = 0.7 - 0.25 - 0.2 * math.cos(0.25) - 0.02
"""Least distance of links and wall, from 0.75 s on."""
WHOLE = (*BOX, "ignore_for")
UNPLACED = {PLACE: None, (*BOX, "ignore"): None, WHOLE: None}
KEPT = UNPLACED | {(*ENTRY, "placed"): None}
"""Edits by which the box is held and not carried."""
HIT = KEPT | {(*HOLD, "seconds"): 0, (*ENTRY, "held_until"): 0.25}


def also(name, time, place, radius, **more):
    """Edits by which another target is caught, which does not move unless it is held."""
    held = {"held_until": time + more["hold"]["seconds"]} if "hold" in more else {}
    motion = {"kind": "quadratic", **flight(None, AHEAD, AHEAD)} if held else still(place)
    other = body("target", name, ball(radius), motion, **more)
    return {
        BODIES: lambda rows: rows.append(other), (*SITUATION, "catch"): "all",
        CATCHES: lambda rows: rows.append({"body": name, "time": time, **held}),
        (*SOLUTION, "catch_time"): time, (*SOLUTION, "catch_body"): name,
    }  # fmt: skip


def sample(at, joints, rates, time):
    """An edit by which the trajectory has another sample."""

    def insert(path):
        for name, row in (("time", time), ("joints", joints), ("rates", rates)):
            path[name].insert(at, row)

    return {PATH: insert}


def cruise(after):
    x = 0.0625 + 0.5 * after
    return sample(3, [x, 0.0, x], [0.5, 0.0, 0.5], 0.25 + after)


def waits(until):
    return sample(11, [0.25, 0.5, 0.25], [0.0] * 3, until)


def law(motion):
    return {MOTION: motion}


def wiggle(speed=0.0, spin=0.0):
    """The box moves and turns to and fro between two samples of its hold."""
    parts = [(0.25, 0.5 + speed, 0.5 + spin), (0.3125, 0.5 - speed, 0.5 - spin), (0.375, 0.5, 0.5)]
    return law(pieces(*parts)) | {(*HOLD, "relative_speed"): 0.5}


def turned(spin):
    motion = {"kind": "quadratic", **flight(None, AHEAD, AHEAD, spin=spin)}
    return law(motion) | {(*BOX, "shape"): ball(0.15), (*BOX, "approach"): None, WHOLE: None}


def tilted(angle):
    return {(*BOX, "approach", 1, "axis"): [math.sin(angle), 0.0, math.cos(angle)]}


def both(*path):
    """A function that makes two edits of one place."""
    return lambda true, lie: ({path: true}, {path: lie})


def tray(margin):
    """An obstacle 0.2 below the hand, with a margin."""
    box, kept = {"kind": "box", "half_extents": [1, 1, 0.02]}, {"now": margin, "rate": 0}
    made = body("obstacle", "tray", box, still([0, 0, -0.22]), margin=kept)
    return {BODIES: lambda rows: rows.append(made)}


def peg(off):
    at = [0.25 + 0.175 * math.cos(0.25) - 0.235 * math.sin(0.25)]
    at += [0.175 * math.sin(0.25) + 0.235 * math.cos(0.25) + off, 0.6]
    return {BODIES: lambda rows: rows.append(body("obstacle", "peg", ball(0.02), still(at)))}


def flies(z):
    late = {(*BULLET, "motion", "position"): [0.12, 21.25, z]}
    return late | {(*SITUATION, "horizon"): 0.3}


def grows(rate):
    return {(*WALL, "margin"): {"now": 0.05, "rate": rate}}


SLOW, FULL, REST = "does not move with box", "while the hand is full", "where the arm should rest"
LIES = {  # edits of the true answer, further ones that are a lie, and a part of the complaint
    "held a sample too short": ({}, {(*ENTRY, "held_until"): 0.375}, "not held as long"),
    "held until no sample": (
        {}, {(*ENTRY, "held_until"): 0.45, (*HOLD, "seconds"): 0.2}, "samples",
    ),
    "held on while it stops": (
        {}, {(*ENTRY, "held_until"): 0.625, (*HOLD, "seconds"): 0.375}, SLOW,
    ),
    "too fast throughout": (
        law(pieces((0.25, 0.599, 0.5))), law(pieces((0.25, 0.6001, 0.5))), SLOW,
    ),
    "too fast from a jump on": (
        law(pieces((0.375, 0.5995, 0.5))), law(pieces((0.375, 0.6001, 0.5))), SLOW,
    ),
    "too fast for an instant": (
        wiggle(0.249), wiggle(0.251) | {(*HOLD, "relative_speed"): 0.25}, SLOW,
    ),
    "bounces in the hold": (law(pieces((0.5, -0.5, 0.5))), law(pieces((0.4375, -0.5, 0.5))), SLOW),
    "samples jump": (law(zigzag(0.003)), law(zigzag(0.0032)), SLOW),
    "rests after its samples": (law(zigzag(0.0)), law(zigzag(0.0, 0.4375)), SLOW),
    "balls spin": (turned(0.05), turned(-0.01), SLOW),
    "hit at neither side": (
        HIT | law(pieces((0.25, -0.5, 0.5))), law(pieces((0.2, 0.7, 0.5), (0.25, -0.5, 0.5))), SLOW,
    ),
    "lost between samples": (wiggle(-0.15), wiggle(-0.17), "misses box"),
    "turns away between samples": (
        wiggle(spin=1.5), wiggle(spin=1.7), "approaches box at an angle",
    ),
    "second approach": (tilted(0.04999), tilted(0.05001), "approaches box at an angle of 0.05001"),
    "rounded approaches": (
        {(*BOX, "approach", 0, "within"): 0, (*BOX, "approach", 1, "within"): 0},
        {(*BOX, "approach", 1, "axis"): [0.000003, 0, 1]}, "approaches box at an angle of 3",
    ),
    "hand of an approach": (
        {}, {(*BOX, "approach", 1, "hand"): [math.sin(0.051), 0.0, math.cos(0.051)]}, "approaches",
    ),
    "jerk": (*both(*ARM, "max_jerk")([32, 130, 33], [31.99, 130, 33]), "joint 0 jerks too much"),
    "jerk of a follower": (*both(*FINGER, "max_jerk")(16, 15.99), "joint 3 jerks too much"),
    "acceleration of a follower": (
        *both(*FINGER, "max_acceleration")(2, 1.9999), "joint 3 accelerates too much",
    ),
    "speed of a follower": (*both(*FINGER, "max_speed")(0.25, 0.2499), "joint 3 moves too fast"),
    "range of a follower": (*both(*FINGER, "range")([0, 0.135], [0, 0.1349]), "joint 3 leaves"),
    "branch touches": (peg(0.04), peg(0.02), "link 2 and peg touch"),
    "jump of acceleration": (
        *both(*PATH, "rates", 3, 0)(0.5 + 7e-6, 0.5 + 9e-6), "joint 0 jumps in its acceleration",
    ),
    "short piece": (cruise(1.1e-5), cruise(0.9e-5), "a piece lasts 9e-06 s"),
    "accelerations at the start": (
        *both(*ARM, "accelerations")([4e-4, 0, 0], [6e-4, 0, 0]), "jumps",
    ),
    "turns at the end": (
        *both(*PATH, "rates", 10, 0)(5.9e-7, 6.1e-7), f"coordinate 0 moves {REST}",
    ),
    "accelerates at the end": (
        *both(*PATH, "joints", 10, 0)(0.25 + 1e-6, 0.25 + 2e-6), f"coordinate 0 accelerates {REST}",
    ),
    "ends too late": (*both(*SITUATION, "end_by")(1.25, 1.2499), "goes on after 1.2499 s"),
    "ends long after the horizon": (waits(601.2), waits(601.4), "goes on after 601.3 s"),
    "goes on after all is done": (
        {(*SITUATION, "end"): "free"}, KEPT, "is not the end of the trajectory",
    ),
    "caught after the horizon": (*both(*SITUATION, "horizon")(0.25, 0.2499), "after the horizon"),
    "no word of the hold": ({}, {(*ENTRY, "held_until"): None}, "an entry that is not body"),
    "no word of the place": ({}, {(*ENTRY, "placed"): None}, "an entry that is not body"),
    "placed without a place": (KEPT, {(*ENTRY, "placed"): 1.25}, "an entry that is not body"),
    "placed before the hold ends": ({}, {(*ENTRY, "placed"): 0.375}, "before their hold has ended"),
    "placed at no sample": ({}, {(*ENTRY, "placed"): 1.25 + 2e-9}, "are not all at samples"),
    "placed in motion": (
        {(*PLACE, "within"): 0.3}, {(*ENTRY, "placed"): 1.125}, f"coordinate 1 moves {REST}",
    ),
    "placed elsewhere": (*both(*PLACE, "position", 0)(0.27999, 0.28001), "box is placed 0.03001"),
    "touches what is not ignored": ({}, {(*BOX, "ignore"): ["wall"]}, "box and shelf touch"),
    "touches for too long": (*both(*WHOLE)(0.338, 0.336), "box and shelf touch"),
    "carried into a bullet": (flies(0.46), flies(0.43), "box and bullet touch"),
    "margin broken late": (
        grows((REACH - 0.05) / 1.25 - 1e-5), grows((REACH - 0.05) / 1.25 + 1e-5),
        "link 1 and wall are nearer than the margin",
    ),
    "margin broken by what is carried": (
        tray(0.1359), tray(0.1361), "box and tray are nearer than the margin",
    ),
    "caught with a full hand": (
        also("mote", 1.25, [0.45, 0, 0.4], 0.3), also("mote", 1.0, [0.45, 0, 0.4], 0.3), FULL,
    ),
    "caught in the hold": (
        also("mote", 0.25, [0.3, 0, 0], 0.4), also("mote", 0.375, [0.3, 0, 0], 0.4), FULL,
    ),
    "held at once with another": (
        also("mote", 0.25, None, 0.2, hold={"seconds": 0, "relative_speed": 0.1}),
        also("mote", 0.25, None, 0.2, hold={"seconds": 0.125, "relative_speed": 0.1}), FULL,
    ),
}  # fmt: skip


def words(pair, **more):
    return " | ".join(map(str, judge(pair["situation"], pair["solution"], **more)))


@pytest.mark.parametrize("name", LIES)
def test_a_lie_is_found_and_the_truth_is_not(name):
    true, lie, word = LIES[name]
    assert words(edited(PAIR, true)) == ""
    assert word in words(edited(PAIR, true | lie))


@pytest.mark.parametrize(("now", "blocked"), [(0.4799, False), (0.4801, True)])
def test_a_margin_blocks_a_start(now, blocked):
    """Links are 0.48 from the wall at t = 0."""
    pair = edited(PAIR, {PATH: None, CATCHES: [], (*WALL, "margin"): {"now": now, "rate": 0}})
    pair["solution"] |= dict.fromkeys(("catch_time", "catch_body", "clearance"))
    pair["solution"]["message"] = "blocked"
    for status in ("unreachable", "start_blocked"):
        pair["solution"]["status"] = status
        assert ("status: is" in words(pair)) == (blocked != (status == "start_blocked"))


def test_clearance_counts_what_is_carried():
    pair = edited(PAIR, {BODIES: lambda rows: rows.__delitem__(slice(2, 4))})
    carried = examine(pair["situation"], pair["solution"]).clearance
    assert carried < 0.09  # links stay 0.13 above the shelf


CORNER = {"kind": "mesh", "vertices": [[0, 0, 0]]}
REFUSED = [
    ((*BOX, "shape"), {"kind": "cloud"}, "bodies[0].shape.kind: cloud is not a kind of shape here"),
    ((*WALL, "shape"), {"kind": "cloud", "radius": 1}, "bodies[2].shape.points: is missing"),
    ((*WALL, "shape"), CORNER | {"triangles": []}, "bodies[2].shape.triangles: [] is not allowed"),
    ((*WALL, "shape"), CORNER | {"triangles": [[0, 0, 1]]}, "triangles: there are 1 vertices"),
    ((*WALL, "shape"), {"kind": "mesh", "file": "a.stl"}, "bodies[2].shape.vertices: is missing"),
    (HOLD, {"seconds": 1}, "bodies[0].hold.relative_speed: is missing"),
    ((*HOLD, "relative_speed"), 0, "bodies[0].hold.relative_speed"),
    ((*HOLD, "seconds"), -0.1, "bodies[0].hold.seconds"),
    (HOLD, None, "bodies[0].place: is without hold"),
    (PLACE, None, "bodies[0].ignore: is without place"),
    ((*PLACE, "within"), 0, "bodies[0].place.within"),
    ((*BOX, "ignore"), None, "bodies[0].ignore_for: is without ignore"),
    ((*BOX, "ignore"), ["box"], "bodies[0].ignore: box is not an obstacle"),
    (WHOLE, 0, "bodies[0].ignore_for"),
    ((*BOX, "margin"), {"now": 1, "rate": 0}, "bodies[0].margin: is for obstacles"),
    ((*WALL, "margin"), {"now": 1}, "bodies[2].margin.rate: is missing"),
    ((*WALL, "margin"), {"now": 1, "rate": -1}, "bodies[2].margin.rate"),
    ((*WALL, "hold"), {"seconds": 0, "relative_speed": 1}, "bodies[2].hold: is for targets"),
    ((*BOX, "approach"), [], "bodies[0].approach"),
    ((*BOX, "approach", 1, "hand"), [0, 0, 2], "bodies[0].approach[1].hand"),
    ((*BOX, "approach", 1, "axis"), [1, 0, 0], "bodies[0].approach: no hand can keep both"),
    ((*SITUATION, "end"), "hold", "end: "),
    ((*SITUATION, "end_by"), -1, "end_by: "),
    ((*ARM, "max_acceleration"), [1, 1], "arm.max_acceleration: has 2 numbers"),
    ((*ARM, "max_jerk"), [1, 1], "arm.max_jerk: has 2 numbers"),
    ((*ARM, "accelerations"), [1, 1], "arm.accelerations: has 2 numbers"),
    ((*ARM, "accelerations"), [0, 0, 5.1], "arm.accelerations: are beyond"),
    ((*ARM, "ignore"), [["claw", "wall"]], "arm.ignore[0]: claw is not a link"),
    ((*FINGER, "parent"), 4, "arm.model.joints[3].parent"),
    ((*FINGER, "follows", "joint"), 4, "arm.model.joints[3].follows.joint"),
    ((*ARM, "model", "format"), "gcm-learn/arm@1", "arm.model.joints[0].max_jerk: is unknown"),
    ((*ARM, "model", "joints", 0, "max_jerk"), None, "arm.model.joints: some have a max_jerk"),
    ((*SITUATION, "format"), "gcm-learn/situation@3", "end: is unknown"),
]


@pytest.mark.parametrize(("path", "to", "message"), REFUSED)
def test_a_wrong_situation_is_refused(path, to, message):
    pair = edited({"situation": PAIR["situation"], "solution": {}}, {path: to})
    with pytest.raises(Unreadable, match=re.escape(message)):
        judge(pair["situation"], PAIR["solution"])


FREE = UNPLACED | {(*SITUATION, "end"): "free", (*ARM, "max_acceleration"): None, PATH: None}
TOUCHED = UNPLACED | {HOLD: None, (*SITUATION, "end"): None, (*BOX, "approach"): None}
"""Edits by which the arm has no limits, and by which the box is only touched."""


@pytest.mark.parametrize(
    ("edits", "message"),
    [
        ({HOLD: None, (*SITUATION, "end"): "rest"}, "end: rest needs limits of acceleration"),
        ({}, "bodies[0].hold: needs limits of acceleration"),
        ({(*ARM, "max_jerk"): [1, 1, 1]}, "arm.max_jerk: needs limits of acceleration"),
        ({(*ARM, "accelerations"): [0, 0, 0]}, "arm.accelerations: needs limits of jerk"),
    ],
)
def test_what_needs_limits_is_refused_without(edits, message):
    situation = edited(PAIR, FREE | edits)["situation"]
    with pytest.raises(Unreadable, match=re.escape(message)):
        judge(situation, PAIR["solution"])


def test_an_older_situation_may_be_asked_to_end_at_rest(tmp_path):
    touch = {CATCHES: [{"body": "box", "time": 0.25}]}
    pair = edited(PAIR, TOUCHED | touch | {(*SITUATION, "format"): "gcm-learn/situation@3"})
    assert words(pair, end="rest") == "" and "format: is not" in words(pair)
    files = [tmp_path / f"{name}.json" for name in pair]
    for path, given in zip(files, pair.values(), strict=True):
        path.write_text(json.dumps(given))
    assert main([*map(str, files), "--end", "rest"]) == 0 and main([*map(str, files)]) == 1
    pair["solution"]["trajectory"]["rates"][10][0] = 6.1e-7
    assert REST in words(pair, end="rest")
    with pytest.raises(Unreadable, match="planar arms"):
        judge(*planar(), end="rest")
