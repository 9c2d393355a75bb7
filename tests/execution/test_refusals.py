"""Refusals of arenas, bodies and loops: one line that names the field and the reason."""

import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from gcm_learn import execution, families
from gcm_learn.errors import ArenaError, ArmKindError, BodyError, PhysicsError
from gcm_learn.execution import PhysicalPlant, Pool, SpatialSettings, body_for, read_body
from gcm_learn.planners import InTube, Tube, get_planner
from gcm_learn.situation import Motor, situation_from_json
from tests.chains import drawn
from tests.execution.body.test_mechanics import (
    CRANE_BODY,
    NAO,
    PANDA,
    TREE,
    TREE_BODY,
    longer_panda,
)
from tests.refusals import refusal
from tests.worlds import among

FLAT = families.draw("random-planar", 3, 0)
PLANAR, SPATIAL = "the arena does not take planar arms", "the arena does not take spatial arms"
SIZES = "arm: 'panda' has 7 joints and 9 links, that of situation 'planar-2-0' 2 joints"


def too_fast(situation):
    """A situation whose arm cannot stop at the ends of its ranges."""
    arm, ends = situation.arm, tuple(high for _, high in situation.arm.joint_range)
    limits = {"max_joint_acceleration": (1.0,) * 4, "joint_rates": arm.max_joint_speed}
    return replace(situation, arm=replace(arm, joints=ends, **limits), bodies=situation.targets)


def test_arenas_refuse_arms_that_they_do_not_take(arms, chains):
    small, slow, plant = situation_from_json(drawn("planar-2", 0)), too_fast(arms[0]), arena
    for error, call, words in (
        (ArmKindError, lambda: execution.pool_for(SpatialSettings(), [FLAT]), PLANAR),
        (ArmKindError, lambda: execution.pool_of("gate", 2, 0, SpatialSettings()), PLANAR),
        (ArmKindError, lambda: Pool.of([arms[0], FLAT]), PLANAR),
        (ArmKindError, lambda: plant(FLAT, SpatialSettings()), PLANAR),
        (ArmKindError, lambda: execution.pool_for(execution.Settings(), [arms[0]]), SPATIAL),
        (ArenaError, lambda: Pool.of([]), "there is none"),
        (ArenaError, lambda: plant(slow, SpatialSettings()), "cannot stop in steps of 0.02 s"),
        (
            ArenaError,
            lambda: Pool.of([chains[0], small]),
            "its arm has 2 joints and 2 links, that of 'panda-0'",
        ),
        (ArenaError, lambda: plant(small, execution.ChainSettings()), SIZES),
    ):
        assert words in refusal(error, call)


def arena(situation, settings):
    return execution.KinematicPlant(Pool.of([situation]), 1, settings)


SETTINGS = [
    (execution.ChainSettings, {"arm": "pandy"}, 'arm: "pandy" is not the name of an arm'),
    (execution.ChainSettings, {"arm": "no.json"}, "arm: no.json: cannot be read"),
    (execution.ChainSettings, {"fan": True}, "fan: chains have none"),
    (execution.PhysicalSettings, {"control": "hand"}, "control: 'hand' is not one of joint, torq"),
    (execution.PhysicalSettings, {"dt": 0.021}, "dt: must be whole steps of physics, of 0.002 s"),
    (execution.Perception, {"place": -0.1}, "place: must be from 0 to 1e6 (got -0.1)"),
    (execution.Perception, {"place": math.nan}, "place: must be from 0 to 1e6 (got nan)"),
    (execution.Perception, {"faster": "much"}, "faster: must be a number (got 'much')"),
    (execution.Perception, {"dropouts": 51.0}, "dropouts: must be at most 50 a second (got 51)"),
    (execution.Perception, {"delay": 1.5}, "delay: must be an integer (got 1.5)"),
    (execution.Perception, {"delay": True}, "delay: must be an integer (got True)"),
    (execution.Perception, {"period": 0.0}, "period: must be positive (got 0)"),
    (execution.Loop, {"looks": 0}, "looks: must be an integer from 1 on (got 0)"),
    (execution.Loop, {"thinking": -1.0}, "thinking: must be from 0 on (got -1.0)"),
    (execution.Planning, {"habit": "never"}, "habit: must be one of once, always, broken (got"),
]
FIRST = {
    execution.Loop: {"perception": execution.Perception(), "looks": 2},
    execution.Planning: {"planner": None},
}


@pytest.mark.parametrize(("made", "change", "words"), SETTINGS)
def test_settings_are_checked(made, change, words):
    assert refusal(ArenaError, made, **FIRST.get(made, {}) | change).startswith(words)


def test_what_cannot_be_seen_or_believed_is_refused():
    eyes, drifting = execution.Perception(0.01), SimpleNamespace(kind="drifting")
    said = refusal(ArenaError, eyes._blurred, drifting, 1.0, np.random.default_rng(0))
    assert said == "perception: does not see drifting motions"
    said = refusal(ArenaError, execution.Belief, among(NAO), eyes, acceleration=-1.0)
    assert said.startswith("acceleration: must be from 0 on")


WEAK = replace(read_body("nao"), joints=(Motor(0.05), *read_body("nao").joints[1:]))
LIMP = replace(read_body("panda"), joints=(Motor(0.0, 0.1, 1.0),) * 7)
WIDE = replace(read_body("human"), metres=1.0)
LONG = replace(NAO, forearm=(0.2, 0.0, 0.0))
STRONG = replace(TREE_BODY, joints=(*TREE_BODY.joints[:4], Motor(1.0)))
BODIES = [
    (lambda: body_for(LONG), "none that is shipped fits"),
    (lambda: body_for(longer_panda()), "panda: joints: differ from the shipped arm's"),
    (lambda: body_for(PANDA, CRANE_BODY), "does not fit: joints: the arm has 7"),
    (lambda: body_for(TREE, STRONG), "joints[4].torque: must be 0, as the joint follows"),
    (lambda: body_for(PANDA, "nao"), "body nao: does not fit: is of format"),
]
PHYSICS = [
    (lambda: execution.motor_accelerations(NAO, WEAK), "joints[0].torque of 0.05 N m leaves noth"),
    (lambda: execution.motor_accelerations(PANDA, LIMP), "joints[0].torque of 0 N m leaves nothi"),
    (lambda: PhysicalPlant(among(NAO), WIDE), "does not fit: upper_arm: is 0.1061 m long"),
    (lambda: execution.Controller(feedforward="pid"), "feedforward"),
    (lambda: execution.Controller(bandwidth=0.0), "bandwidth"),
    (lambda: execution.Controller(bandwidth=math.nan), "bandwidth"),
    (lambda: PhysicalPlant(among(NAO), body_for(NAO)).push(np.full(4, np.nan), 0.1), "not finite"),
    (
        lambda: execution.pool_for(execution.PhysicalSettings(), [among(LONG, name="odd")]),
        "situation 'odd'",
    ),
]
TUBES = [
    (ValueError, lambda: Tube(still=-1.0), "still"),
    (ValueError, lambda: Tube(per_speed=math.nan), "per_speed"),
    (ArmKindError, lambda: InTube(get_planner("search"), Tube()).plan(FLAT), "tube"),
]


@pytest.mark.parametrize(
    ("error", "call", "words"),
    [*((BodyError, *row) for row in BODIES), *((PhysicsError, *row) for row in PHYSICS), *TUBES],
)
def test_what_physics_cannot_do_is_refused(error, call, words):
    assert words in refusal(error, call)
