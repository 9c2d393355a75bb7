"""Blocked starts name the deepest pair of links and bodies, and how deep it is."""

from __future__ import annotations

import copy
import json
import re
from pathlib import Path

import numpy as np
import pytest

from gcm_learn import solve
from gcm_learn.errors import ArenaError
from gcm_learn.execution import Pool
from gcm_learn.motion import Failure, why_blocked
from gcm_learn.planners import Plan, plan_to_json
from gcm_learn.scene import pack
from gcm_learn.situation import situation_from_json
from tests.chains import MODELS
from tests.geometry import arm_of, poses, segment_gaps, segments_apart
from tests.worlds import SHAPES, ball, body, law, still

SELF_TOUCH = json.loads((Path(__file__).parent / "self-touch.json").read_text("utf-8"))
SELF_WORDS = "link 0 and link 2 overlap by 0.08 at t = 0"
STRAIGHT = {"hand": [2.0, 0.0], "max_hand_speed": 3.0, "thickness": 0.1}
"""A planar arm along x, its elbow at (1, 0)."""
NAO = {
    "kind": "spatial", "upper_arm": [0.105, 0.015, 0], "forearm": [0.1137, 0, -0.01231],
    "joint_range": [[-2, 2], [-0.3, 1.3], [-2, 2], [-1.5, -0.03]], "thickness": 0.02,
    "max_joint_speed": [8, 7, 8, 7], "grasp": 0.015, "joints": [0.0] * 4,
}  # fmt: skip


def sentence(situation):
    """The reason of a situation as JSON, which is blocked at the start."""
    given = situation_from_json(situation)
    return str(why_blocked(given, pack(given)))


def flat(name, shape, at):
    """A planar obstacle at rest."""
    zero = [0.0, 0.0]
    motion = {"kind": "quadratic", "position": at, "velocity": zero, "acceleration": zero}
    return body("obstacle", name, shape, motion)


def planar(*bodies):
    goal = flat("goal", {"kind": "disc", "radius": 0.5}, [2.0, 0.0]) | {"role": "target"}
    return {
        "format": "gcm-learn/situation@1", "name": "s", "horizon": 1.0, "arm": STRAIGHT,
        "bodies": [goal, *bodies],
    }  # fmt: skip


DISC = {"kind": "disc", "radius": 0.1}
SQUARE = {"kind": "polygon", "vertices": [[-0.2, -0.2], [0.2, -0.2], [0.2, 0.2], [-0.2, 0.2]]}
HOOK = {
    "kind": "polygon",
    "vertices": [[0, -0.3], [0.6, -0.3], [0.6, 0.3], [0.5, 0.3], [0.5, -0.25], [0, -0.25]],
}


@pytest.mark.parametrize(
    ("bodies", "expected"),
    [
        ([flat("post", DISC, [1.5, 0.15])], "forearm and 'post' overlap by 0.05"),
        ([flat("a\nb", DISC, [0.2, -0.18])], r"upper arm and 'a\nb' overlap by 0.02"),
        ([flat("box", SQUARE, [0.5, 0.0])], "upper arm and 'box' overlap by 0.3"),
        ([flat("hook", HOOK, [1.2, 0.0])], "forearm and 'hook' overlap by 0.15"),
        (
            [flat("post", DISC, [1.5, 0.15]), flat("box", SQUARE, [0.5, 0.25])],
            "upper arm and 'box' overlap by 0.05",
        ),
        ([flat("post", DISC, [2.1, 0.0])], "forearm and 'post' overlap by 0.1"),
    ],
)  # fmt: skip
def test_a_planar_arm(bodies, expected):
    situation = planar(*bodies)
    assert sentence(situation) == f"{expected} at t = 0"
    plan = solve(situation_from_json(situation))
    assert plan.status == "start_blocked" and plan.message == sentence(situation)


def test_a_planar_arm_among_solids():
    """The box is thinnest across the plane: there the bone is 0.05 deep."""
    goal = body("target", "goal", ball(0.5), still([2, 0, 0]))
    box = body(
        "obstacle", "plate", {"kind": "box", "half_extents": [0.3, 0.3, 0.05]}, still([0.5, 0, 0])
    )
    plane = {"origin": [0, 0, 0], "x": [1, 0, 0], "y": [0, 1, 0]}
    situation = planar() | {"plane": plane, "bodies": [goal, box]}
    assert sentence(situation) == "upper arm and 'plate' overlap by 0.15 at t = 0"


def crowded(rng, arm, count, share):
    """A situation of an arm in joints whose obstacles are about its links; names of its links."""
    key = "posture" if arm["kind"] == "chain" else "joints"
    given = arm_of(arm)
    arm = arm | {key: rng.uniform(given.limits.low, given.limits.high).tolist()}
    given = arm_of(arm)
    ends = given.geometry.ends(given.posture[None])[0]
    bodies = [body("target", "goal", ball(0.3), still(ends[-1, 1]))]
    for k in range(count):
        shape = copy.deepcopy(SHAPES[int(rng.integers(len(SHAPES)))])
        for name in set(shape) - {"kind"}:
            shape[name] = (share * given.size * np.array(shape[name])).tolist()
        i = int(rng.integers(len(ends)))
        motion = law(rng, "quadratic")
        motion["position"] = (ends[i].mean(axis=0) + 0.1 * given.size * rng.normal(size=3)).tolist()
        bodies.append(body("obstacle", f"body {k}", shape, motion))
    kept = {"format": "gcm-learn/situation@3", "name": "s", "horizon": 1.0}
    return kept | {"arm": arm, "bodies": bodies}


def depths(situation, names):
    """Depth of every pair, by the referee's geometry."""
    arm, found = arm_of(situation["arm"]), {}
    ends, radii = arm.geometry.ends(arm.posture[None])[0], arm.geometry.radii
    for thing in situation["bodies"]:
        centre, turn = (part[0] for part in poses(thing, [0.0]))
        for i in range(len(radii)):
            if thing["role"] == "obstacle" and (i, thing["name"]) not in arm.ignored:
                axis = (ends[i] - centre) @ turn
                gap = segment_gaps(thing["shape"], axis[:1], axis[1:])[0]
                found[names[i], repr(thing["name"])] = radii[i] - gap
    for i, j in arm.geometry.pairs:
        apart = segments_apart(*(ends[k, e][None] for k in (i, j) for e in (0, 1)))[0]
        found[names[i], names[j]] = radii[i] + radii[j] - apart
    return found


def chain_with_names():
    """A thick Panda, some of whose links have names, and on which some pairs are ignored."""
    model = copy.deepcopy(MODELS["panda"]) | {"format": "gcm-learn/arm@2"}
    names = [f"part {k}" if k % 2 else f"link {k}" for k in range(len(model["links"]))]
    for k, link in enumerate(model["links"]):
        link |= {"radius": 1.6 * link["radius"]} | ({"name": names[k]} if k % 2 else {})
    model["self_collision"] = [[i, j] for j in range(len(names)) for i in range(j - 3)]
    ignore = [["part 1", "body 0"], [2, "body 1"]]
    arm = {"kind": "chain", "model": model, "grasp": 0.03, "ignore": ignore}
    return arm | {"posture": [0.0] * 7}, names


@pytest.mark.parametrize("kind", ["spatial", "chain"])
def test_the_deepest_pair_is_that_of_the_referee(kind):
    rng, itself, blocked = np.random.default_rng(5), 0, 0
    for _ in range(40):
        arm, names = (NAO, ["upper arm", "forearm"]) if kind == "spatial" else chain_with_names()
        situation = crowded(rng, arm, int(rng.integers(2, 4)), 0.1)
        found = depths(situation, names)
        plan = solve(situation_from_json(situation), "straight")
        assert (plan.status == "start_blocked") == (max(found.values()) >= 0.0)
        if plan.status == "start_blocked":
            said = re.fullmatch("(.+) and (.+) overlap by ([0-9.e-]+) at t = 0", plan.message)
            depth = found[said[1], said[2]]
            assert depth == pytest.approx(max(found.values()), rel=1e-6, abs=1e-9)
            assert float(said[3]) == pytest.approx(depth, rel=0.006, abs=1e-9)
            blocked, itself = blocked + 1, itself + (said[2] in names)
    assert blocked >= 10 and (itself > 2) == (kind == "chain")


class Blind:
    """A planner from outside that tells of a reason of its own, whatever it is asked."""

    def takes(self, kind):
        return True

    def plan(self, situation):
        return Plan(situation.name, "blind", "unreachable", "I see nothing", 0.0)


@pytest.mark.parametrize("planner", ["search", "straight", "straight-wait", "marching", Blind()])
def test_every_planner_says_what_touches_what(planner):
    situation = situation_from_json(SELF_TOUCH)
    plan = solve(situation, planner)
    assert (plan.status, plan.message) == ("start_blocked", SELF_WORDS)
    assert plan_to_json(plan, situation)["message"] == SELF_WORDS


def test_the_arena_refuses_with_the_same_words():
    with pytest.raises(ArenaError, match=f"'self-touch': {SELF_WORDS}"):
        Pool.of([situation_from_json(SELF_TOUCH)])


def test_sentences_of_records_tell_the_reason():
    for words in (SELF_WORDS, "the limb touches an obstacle at t = 0"):
        assert Failure.of(words) is Failure.START_BLOCKED
