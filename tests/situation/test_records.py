"""Arms, planes, shapes, motions, bodies and situations check themselves and each other."""

import dataclasses
import math
import re

import numpy as np
import pytest
from hypothesis import given

from gcm_learn import situation as records
from gcm_learn.arms import Arm, SpatialArm
from gcm_learn.errors import ArmKindError, GcmError, SituationError
from gcm_learn.situation import Body, Disc, Situation, Sphere, situation_from_json
from tests import strategies
from tests.refusals import refusal
from tests.situation.scenes import NAO

REST = records.PlanarQuadratic((0, 1), (0, 0), (0, 0))
SOLID_REST = records.SolidQuadratic((0, 1, 0), (0, 0, 0), (0, 0, 0))
BALL = Body("target", "ball", Disc(0.1), REST)
POST, OTHER = (Body("obstacle", name, Disc(1), REST) for name in ("post", "ball"))
SOLID_BALL = Body("target", "ball", Sphere(0.1), SOLID_REST)
PLANE = records.Plane((0, 0, 1), (1, 0, 0), (0, 0, 1))
GOOD = {
    Arm: {"hand": (1.1, -0.4), "max_hand_speed": 3.1},
    SpatialArm: {
        "upper_arm": (1, 0, 0), "forearm": (1, 0, 0), "joints": (0,) * 4,
        "joint_range": ((-1, 1),) * 4, "max_joint_speed": (1,) * 4, "grasp": 0.1,
    },
    Disc: {"radius": 1.0},
    Sphere: {"radius": 1.0},
    records.Capsule: {"radius": 1.0, "half_length": 1.0},
    records.Cylinder: {"radius": 1.0, "half_length": 1.0},
    records.Box: {"half_extents": (1.0, 1.0, 1.0)},
    records.Plane: {"origin": (0, 0, 0), "x": (1, 0, 0), "y": (0, 1, 0)},
    records.PlanarQuadratic: {"position": (1, 2), "velocity": (0, 0), "acceleration": (0, -1)},
    records.SolidQuadratic: {
        "position": (1, 2, 3), "velocity": (0, 0, 0), "acceleration": (0, -1, 0),
    },
    records.Pendulum: {
        "pivot": (0, 0, 5), "axis": (0, 1, 0), "down": (0, 0, -1), "length": 5, "gravity": 70,
        "angle": 0.5, "rate": 0,
    },
    Body: {"role": "target", "name": "a", "shape": Disc(1), "motion": REST},
    Situation: {"name": "s", "horizon": 1.0, "arm": Arm((1.1, -0.4), 3.1), "bodies": [BALL]},
}  # fmt: skip
REFUSED = {
    Arm: [
        ("hand", (2.4, 0), ": (2.4, 0.0) is out of reach (max 2.0)"),
        ("hand", (1, 0, 0), ": must be a list of 2 numbers (got 3)"),
        ("max_hand_speed", 0, ": must be positive (got 0.0)"),
        ("upper_arm", -1, ": must be positive (got -1.0)"),
        ("elbow", "up", ': must be "left" or "right" (got "up")'),
        ("elbow", 1, ': must be "left" or "right" (got 1)'),
        ("max_joint_speed", 3, ": must be a list of 2 numbers (got 3)"),
        ("max_joint_speed", (1, 0), "[1]: must be positive (got 0.0)"),
        ("thickness", -0.1, ": must not be negative (got -0.1)"),
        ("grasp", -0.1, ": must not be negative (got -0.1)"),
        ("grasp", math.nan, ": must be finite (got nan)"),
    ],
    SpatialArm: [("base", (0, 0, 0), ": must be a base (got a list of 3)")],
    records.Box: [
        ("half_extents", (1.0, 2.0), ": must be a list of 3 numbers (got 2)"),
        ("half_extents", (1.0, 2.0, 0.0), "[2]: must be positive (got 0.0)"),
        ("half_extents", (1.0, "a", 1.0), '[1]: must be a number (got "a")'),
        ("half_extents", 1.0, ": must be a list of 3 numbers (got 1.0)"),
        ("half_extents", "123", ': must be a list of 3 numbers (got "123")'),
    ],
    records.Plane: [
        ("x", (2, 0, 0), ": must have length 1 (got 2)"),
        ("y", (0, 0.5, 0), ": must have length 1 (got 0.5)"),
        ("y", (0.6, 0.8, 0), ": must be orthogonal to x (dot product 0.6)"),
        ("y", (1, 0, 0), ": must be orthogonal to x (dot product 1)"),
        ("x", (1, 0), ": must be a list of 3 numbers (got 2)"),
    ],
    records.PlanarQuadratic: [
        ("position", (1, 2, 3), ": must be a list of 2 numbers (got 3)"),
        ("velocity", (1, True), "[1]: must be a number (got true)"),
        ("acceleration", None, ": must be a list of 2 numbers (got null)"),
        ("angle", math.inf, ": must be finite (got inf)"),
        ("spin", (0, 0, 1), ": must be a number (got a list of 3)"),
    ],
    records.SolidQuadratic: [
        ("position", (1, 2), ": must be a list of 3 numbers (got 2)"),
        ("spin", 2.0, ": must be a list of 3 numbers (got 2.0)"),
        ("orientation", (1, 0, 0), ": must be a list of 4 numbers (got 3)"),
        ("orientation", (1, 0, 0, 0.1), ": must have length 1 (got 1.00498756)"),
        ("orientation", (0, 0, 0, 0), ": must have length 1 (got 0)"),
    ],
    records.Pendulum: [
        ("axis", (0, 2, 0), ": must have length 1 (got 2)"),
        ("down", (0, 0, 0), ": must have length 1 (got 0)"),
        ("down", (0, 0.6, 0.8), ": must be orthogonal to axis (dot product 0.6)"),
        ("length", 0, ": must be positive (got 0.0)"),
        ("gravity", -1, ": must not be negative (got -1.0)"),
        ("rate", "fast", ': must be a number (got "fast")'),
        ("damping", -0.1, ": must not be negative (got -0.1)"),
        ("hang", -2, ": must not be negative (got -2.0)"),
        ("hang", False, ": must be a number (got false)"),
    ],
    Body: [
        ("role", "goal", ': must be "target" or "obstacle" (got "goal")'),
        ("name", 7, ": must be a string (got 7)"),
        ("name", "\ud800", ': is not valid Unicode (lone surrogate in "\\ud800")'),
        ("shape", 0.1, ": must be a shape (got 0.1)"),
        ("motion", None, ": must be a motion (got null)"),
        ("motion", SOLID_REST, ': planar shape "disc" needs a planar motion (got SolidQuadratic)'),
    ],
    Situation: [
        ("name", 3, ": must be a string (got 3)"),
        ("horizon", 0, ": must be positive (got 0.0)"),
        ("arm", None, ": must be an arm (got null)"),
        ("bodies", BALL, ": must be a list of bodies (got a value of type Body)"),
        ("bodies", ["ball"], '[0]: must be a body (got "ball")'),
        ("bodies", [], ": no target among 0 bodies"),
        ("bodies", [POST], ": no target among 1 bodies"),
        ("bodies", [BALL, OTHER], '[1].name: "ball" is already the name of bodies[0]'),
        ("bodies", [SOLID_BALL], '[0].shape.kind: "sphere" is 3D, but the situation has no plane'),
        ("plane", 0, ": must be a plane (got 0)"),
    ],
}
"""Records with one field changed, and what is said after the field's name."""
SIZES = [
    (0, "must be positive (got 0.0)"),
    (-0.5, "must be positive (got -0.5)"),
    (math.nan, "must be finite (got nan)"),
    (-math.inf, "must be finite (got -inf)"),
    (1e51, "is too large (1e+51, max 1e+50)"),
    (10**400, "is too large (an integer of 1329 bits, max 1e+50)"),
    (10**5000, "is too large (an integer of 16610 bits, max 1e+50)"),
    (True, "must be a number (got true)"),
    (None, "must be a number (got null)"),
    ("1", 'must be a number (got "1")'),
    ([1.0], "must be a number (got a list of 1)"),
    ({}, "must be a number (got an object)"),
    (1j, "must be a number (got a value of type complex)"),
]


@pytest.mark.parametrize("record", REFUSED)
def test_a_record_refuses_what_makes_no_sense(record):
    for field, value, reason in REFUSED[record]:
        said = refusal(SituationError, record, **GOOD[record] | {field: value})
        assert said == field + reason


@pytest.mark.parametrize("record", [Disc, Sphere, records.Capsule, records.Cylinder])
def test_sizes_are_positive_numbers(record):
    for field in GOOD[record]:
        for value, reason in SIZES:
            said = refusal(SituationError, record, **GOOD[record] | {field: value})
            assert said == f"{field}: {reason}"


def test_fields_that_do_not_go_together_are_refused():
    for upper_arm in (0.5, 1.5):
        said = refusal(SituationError, Arm, (0.2, 0.0), 3.1, upper_arm=upper_arm)
        assert said == "hand: (0.2, 0.0) is out of reach (min 0.5)"
    said = refusal(SituationError, Body, "target", "a", Sphere(1), REST)
    assert said == 'motion: 3D shape "sphere" needs a 3D motion (got PlanarQuadratic)'
    said = refusal(SituationError, Situation, "s", 1.0, Arm((1, 0), 3), [SOLID_BALL, POST], PLANE)
    assert said == 'bodies[1].shape.kind: "disc" is planar, but the situation has a plane'
    spatial = situation_from_json(NAO).arm
    said = refusal(SituationError, Situation, "s", 1.0, spatial, (SOLID_BALL,), PLANE)
    assert said == "plane: is for planar arms (the arm is spatial)"


def test_errors_are_ours_and_value_errors():
    with pytest.raises(GcmError) as caught:
        Disc(-1)
    assert isinstance(caught.value, ValueError)
    assert (caught.value.field, caught.value.reason) == ("radius", "must be positive (got -1.0)")


def test_who_takes_planar_arms_only_says_so():
    said = refusal(ArmKindError, records.planar, situation_from_json(NAO), "planner 'gcm'")
    assert said == "planner 'gcm' does not take spatial arms (situation \"nao\")"
    situation = Situation(**GOOD[Situation])
    assert records.planar(situation, "anybody") is situation


def test_what_is_left_out_of_an_arm_and_its_reach():
    arm = Arm(**GOOD[Arm])
    assert dataclasses.asdict(arm) == GOOD[Arm] | {
        "upper_arm": 1.0, "elbow": "right", "max_joint_speed": None, "thickness": 0.0,
        "grasp": 0.05,
    }  # fmt: skip
    assert (arm.reach, arm.inner_reach) == (2.0, 0.0)
    short = Arm((1, 0), 1, upper_arm=0.25)
    assert (short.reach, short.inner_reach) == (1.25, 0.75)


def test_what_is_left_out_of_a_motion():
    planar = records.PlanarQuadratic(**GOOD[records.PlanarQuadratic])
    assert (planar.angle, planar.spin) == (0.0, 0.0)
    solid = records.SolidQuadratic(**GOOD[records.SolidQuadratic])
    assert (solid.orientation, solid.spin) == ((1.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    pendulum = records.Pendulum(**GOOD[records.Pendulum])
    assert (pendulum.damping, pendulum.hang, pendulum.hang_distance) == (0.0, None, 5.0)
    assert dataclasses.replace(pendulum, hang=2).hang_distance == 2.0


def test_unit_vectors_may_be_off_by_rounding():
    third = round(1 / math.sqrt(3), 7)
    rounded = {"axis": (third,) * 3, "down": (0.70710678, -0.70710678, 0)}
    records.Pendulum(**GOOD[records.Pendulum] | rounded)


@pytest.mark.parametrize("angle", [0.1 * k for k in range(63)])
def test_hand_on_the_rim_is_within_reach_up_to_rounding(angle):
    direction = np.array((math.cos(angle), math.sin(angle)))
    for radius in (0.5, 2.5):
        assert Arm(radius * direction, 1.0, upper_arm=1.5).hand == tuple(radius * direction)
    far = refusal(SituationError, Arm, 2.5001 * direction, 1.0, upper_arm=1.5)
    assert "out of reach (max 2.5)" in far


@given(strategies.planes())
def test_plane_normal_is_the_cross_product(plane):
    assert np.cross(plane.x, plane.y) == pytest.approx(np.array(plane.normal))


def test_numbers_are_stored_as_plain_floats_and_tuples():
    box = records.Box(np.array([1, 2, 3]))
    assert box.half_extents == (1.0, 2.0, 3.0)
    assert [type(x) for x in box.half_extents] == [float] * 3
    polygon = records.Polygon([[0, 0], [np.float32(1), 0], (0, np.int64(1))])
    assert polygon.vertices == ((0.0, 0.0), (1.0, 0.0), (0.0, 1.0))
    assert {type(x) for corner in polygon.vertices for x in corner} == {float}
    assert hash(box) == hash(records.Box((1.0, 2.0, 3.0)))


@pytest.mark.parametrize(
    ("shape", "radius"),
    [
        (Disc(0.3), 0.3),
        (records.Polygon(((-3, -4), (1, 0), (0, 1))), 5.0),
        (Sphere(0.2), 0.2),
        (records.Box((2, 3, 6)), 7.0),
        (records.Capsule(0.5, 2.0), 2.5),
        (records.Cylinder(3.0, 4.0), 5.0),
    ],
)
def test_bounding_radius(shape, radius):
    assert shape.bounding_radius == pytest.approx(radius, rel=1e-15)


@given(strategies.situations())
def test_targets_and_obstacles_share_out_the_bodies(situation):
    names = [body.name for body in situation.targets + situation.obstacles]
    assert sorted(names) == sorted(body.name for body in situation.bodies)
    assert situation.bodies[0] in situation.targets
    assert situation.is_solid == all(body.is_solid for body in situation.bodies)


def test_a_horizon_of_too_many_swings_is_refused_by_name():
    swing = records.Pendulum((0, 0, 1), (1, 0, 0), (0, 0, -1), 1.0, 9.81, 0.5, 0.0)
    ball = Body("target", "ball", Sphere(0.1), swing)
    period = 2.0 * math.pi / math.sqrt(9.81)
    arm = Arm(**GOOD[Arm])
    assert Situation("s", 999.0 * period, arm, [ball], PLANE).horizon > 0.0
    refused = refusal(SituationError, Situation, "s", 1001.0 * period, arm, [ball], PLANE)
    assert re.fullmatch(
        r"horizon: [\d.]+ s is over 1000 periods of bodies\[0\] \(at most .+\)", refused
    )
