"""The scenes of the paper's Figs. 1 to 8 as situations.

The paper draws its scenes without giving their dimensions. The numbers below that it does not give
are chosen: the scene resembles the figure, and the wave meets the target near the instant of the
caption. Constants say which is which. Lengths are in forearms, times in seconds.
"""

from __future__ import annotations

import math
from collections.abc import Callable

from gcm_learn.arms import Arm, SpatialArm
from gcm_learn.situation import (
    Body,
    Box,
    Capsule,
    Cylinder,
    Disc,
    Pendulum,
    PlanarQuadratic,
    Plane,
    Polygon,
    Situation,
    SolidQuadratic,
    Sphere,
)

KAPPA = 1 / 400  # [s per tau] real over mental time, Sect. 2.3 (adapted to the robot)
LATTICE_SPACING = 0.05  # [forearms] 80 cells over twice the reach of an arm with rho = 1
FRONT_SPEED = 0.1708  # [cells per tau] fastest circular front of Eq. 10 at d = 0.2
HAND_SPEED = FRONT_SPEED * LATTICE_SPACING / KAPPA  # [forearms/s] the hand rides the front

POINT = 0.02  # [forearms] radius standing in for the paper's points

FOREARM = 0.135  # [m] half of the robot's 27 cm arm: the paper gives no rho, here rho = 1
EARTH = 9.81  # [m/s^2]
EARTH_GRAVITY = EARTH / FOREARM  # [forearms/s^2] at the robot's scale

# Fig. 5 cannot be at the robot's scale: in 220 tau = 0.55 s a ball released at rest would fall
# 11 forearms. This value lets it fall 1.3, as drawn; it is Earth's for a forearm of 1.15 m.
FIG5_GRAVITY = 8.5  # [forearms/s^2]

# [tau] instants of the panels that show the wave; the last one is the contact with the target.
# Fig. 5 gives only the contact, the earlier instants are chosen.
CAPTION_INSTANTS = {
    "fig4": (30, 100, 180),
    "fig5": (80, 150, 220),
    "fig6": (20, 60, 100, 160),
    "fig8": (0, 120, 280),
}

UPRIGHT = ((1.0, 0.0, 0.0), (0.0, 0.0, 1.0))  # axes of a vertical arm plane, z is up


def fig1() -> Situation:
    """A static point obstacle between the hand and a static target (Fig. 1).

    The straight way to the target would push the forearm into the point: the arm has to bend
    first. All coordinates are chosen; the paper gives none.
    """
    return _planar(
        "fig1",
        hand=(0.7, 1.25),
        bodies=(
            _still("target", "goal", Disc(0.05), (1.55, 0.35)),
            _still("obstacle", "point", Disc(POINT), (1.12, 0.62)),
        ),
    )


def fig2() -> Situation:
    """A static disc and a static square whose extended obstacles overlap (Fig. 2A)."""
    return _planar(
        "fig2",
        hand=(1.85, 0.1),
        bodies=(
            _still("target", "goal", Disc(0.08), (-0.55, 1.6)),
            _still("obstacle", "disc", Disc(0.16), (0.83, 0.99)),
            _still("obstacle", "square", _square(0.16), (1.07, 0.62), angle=0.2),
        ),
    )


def fig3() -> Situation:
    """Two movers whose extended obstacles change their shape on the way (Fig. 3).

    The figure lacks a target. A situation has one; it rests aside.
    """
    return _planar(
        "fig3",
        hand=(1.0, 1.3),
        bodies=(
            _still("target", "goal", Disc(0.08), (1.2, -1.0)),
            _moving("obstacle", "disc", Disc(0.14), (-1.5, 0.7), (2.8, 0.6)),
            _moving("obstacle", "square", _square(0.14), (1.8, 0.3), (-1.6, -0.5), spin=2.0),
        ),
    )


def fig4() -> Situation:
    """One moving point-like obstacle and a static target, contact at about 180 tau (Fig. 4)."""
    return _planar(
        "fig4",
        hand=(0.7, 1.25),
        bodies=(
            _still("target", "goal", Disc(0.08), (1.5, 0.4)),
            _moving("obstacle", "point", Disc(POINT), (1.3, 0.45), (-0.8, 0.9)),
        ),
    )


def fig5(gravity: float = FIG5_GRAVITY) -> Situation:
    """A ball falling past a fixed horizontal bar, contact at about 220 tau (Fig. 5).

    Parameters
    ----------
    gravity : float
        Acceleration of the ball [forearms/s^2]. At the robot's scale (`EARTH_GRAVITY`) the
        paper's fall from rest is impossible, therefore scale is a parameter of the scene.
    """
    down = (0.0, 0.0, -gravity)
    quarter_turn = (math.sqrt(0.5), math.sqrt(0.5), 0.0, 0.0)  # z axis to the plane's normal
    bar = SolidQuadratic((1.1, 0.0, 0.45), (0, 0, 0), (0, 0, 0), quarter_turn)
    ball = SolidQuadratic((1.6, 0.0, 1.3), (0, 0, 0), down)
    return _solid(
        "fig5",
        hand=(0.62, 1.08),
        plane=Plane((0.0, 0.0, 0.0), *UPRIGHT),
        bodies=(
            Body("target", "ball", Sphere(0.15), ball),
            Body("obstacle", "bar", Cylinder(0.12, 1.2), bar),
        ),
    )


def fig6() -> Situation:
    """A spinning bar to catch and a spinning disk to avoid, contact at about 160 tau (Fig. 6).

    Both fly along the normal of the arm plane, in opposite directions and without gravity.
    Nothing cuts the plane at 20 tau; both do at 60 and at 100.
    """
    bar = SolidQuadratic(
        (0.85, 0.75, 0.55), (0.0, -1.9, 0.0), (0, 0, 0), _turn((1, 0, 0), 0.5), (2.2, 0.0, 1.0)
    )
    disk = SolidQuadratic(
        (1.1, -0.75, 0.15), (0.0, 3.4, 0.0), (0, 0, 0), _turn((0, 0, 1), 0.4), (4.0, 2.0, 0.0)
    )
    return _solid(
        "fig6",
        hand=(1.1, -0.35),
        plane=Plane((0.0, 0.0, 0.0), *UPRIGHT),
        bodies=(
            Body("target", "bar", Box((0.09, 0.09, 0.75)), bar),
            Body("obstacle", "disk", Cylinder(0.4, 0.03), disk),
        ),
    )


# The pendulum experiment, Sect. 3.3. Given: the box, the height of the cord's end, the arm.
BOX_SIZE = (0.38, 0.60, 0.26)  # [m] width, length, height (w, l, h of the paper)
CORD_HEIGHT = 1.50  # [m] above the floor
BALL_DIAMETER = 0.067  # [m] of a tennis ball, not in the paper
CORD_LENGTH = 1.10  # [m] chosen: the paper adjusts it to the robot and does not tell it
CORD_RADIUS = 0.002  # [m] chosen
SHOULDER_HEIGHT = 0.36  # [m] chosen: the robot (57 cm tall) on the floor with bent knees
BALL_START = math.radians(30)  # chosen: released at rest from this angle
SWING_HEADING = math.radians(50)  # chosen: turned from the arm plane's normal
CROSSING_DISTANCE = 0.20  # [m] chosen: of the ball in front of the shoulder at t = 0.69 s
CROSSING_DEFLECTION = 0.245  # [m] chosen: of the ball from below the pivot then
BOX_DISTANCE = 0.10  # [m] chosen: of the box in front of the shoulder


def fig8() -> Situation:
    """The pendulum experiment at the robot's scale, contact at about 280 tau (Figs. 7 and 8).

    The arm moves in a vertical plane (x forward, y up). A ball on a cord swings across it and
    passes at about 0.70 s = 280 tau; until then only the box is in the plane.
    """
    swing = pendulum_of(FOREARM, SHOULDER_HEIGHT)
    length = CORD_LENGTH / FOREARM
    depth, width, height = (size / FOREARM for size in BOX_SIZE)
    floor = -SHOULDER_HEIGHT / FOREARM
    middle = (BOX_DISTANCE / FOREARM + depth / 2, 0.0, floor + height / 2)
    return _solid(
        "fig8",
        hand=(0.27, -1.5),
        plane=Plane((0.0, 0.0, 0.0), *UPRIGHT),
        bodies=(
            Body("target", "ball", Sphere(BALL_DIAMETER / 2 / FOREARM), swing(length)),
            Body("obstacle", "cord", Capsule(CORD_RADIUS / FOREARM, length / 2), swing(length / 2)),
            Body(
                "obstacle",
                "box",
                Box((depth / 2, width / 2, height / 2)),
                SolidQuadratic(middle, (0, 0, 0), (0, 0, 0)),
            ),
        ),
    )


def pendulum_of(unit: float, shoulder: float) -> Callable[[float], Pendulum]:
    """Return a function that gives a body's swing from its centre's distance to the pivot.

    Parameters
    ----------
    unit : float
        In which lengths count [m].
    shoulder : float
        Its height above the floor [m].
    """
    c, s = math.cos(SWING_HEADING), math.sin(SWING_HEADING)
    heading = (-s, c)  # from the robot's right to its left, and towards it
    back = CROSSING_DEFLECTION / unit
    pivot = (
        CROSSING_DISTANCE / unit - back * heading[0],
        -back * heading[1],
        (CORD_HEIGHT - shoulder) / unit,
    )

    def swing(hang: float) -> Pendulum:
        return Pendulum(
            pivot=pivot,
            axis=(c, s, 0.0),
            down=(0.0, 0.0, -1.0),
            length=CORD_LENGTH / unit,
            gravity=EARTH / unit,
            angle=-BALL_START,
            rate=0.0,
            hang=hang,
        )

    return swing


PAPER_SCENES: dict[str, Callable[[], Situation]] = {
    "fig1": fig1,
    "fig2": fig2,
    "fig3": fig3,
    "fig4": fig4,
    "fig5": fig5,
    "fig6": fig6,
    "fig8": fig8,
}


def _planar(name: str, hand: tuple[float, float], bodies: tuple[Body, ...]) -> Situation:
    return Situation(name, 1.2, Arm(hand, HAND_SPEED), bodies)


def _solid(
    name: str, hand: tuple[float, float], plane: Plane, bodies: tuple[Body, ...]
) -> Situation:
    return Situation(name, 1.2, Arm(hand, HAND_SPEED), bodies, plane)


def _still(
    role: str, name: str, shape: Disc | Polygon, at: tuple[float, float], angle: float = 0.0
) -> Body:
    return Body(role, name, shape, PlanarQuadratic(at, (0.0, 0.0), (0.0, 0.0), angle))


def _moving(
    role: str,
    name: str,
    shape: Disc | Polygon,
    at: tuple[float, float],
    velocity: tuple[float, float],
    spin: float = 0.0,
) -> Body:
    return Body(role, name, shape, PlanarQuadratic(at, velocity, (0.0, 0.0), 0.0, spin))


def _square(half_side: float) -> Polygon:
    s = half_side
    return Polygon(((-s, -s), (s, -s), (s, s), (-s, s)))


def _turn(axis: tuple[float, float, float], angle: float) -> tuple[float, float, float, float]:
    """Return the unit quaternion that turns by `angle` [rad] about a unit axis."""
    s = math.sin(angle / 2)
    return (math.cos(angle / 2), axis[0] * s, axis[1] * s, axis[2] * s)


GATE = (1.6, 0.05)  # half length and half width [forearms]
GATE_SPEED = 3.3  # [forearms/s] about the hand's
GATE_LEAN = 0.15  # [rad] from the direction in which it slides
SOON = 1.1  # [s] too soon for a way round the gate


def gate_scene() -> Situation:
    """A gate that opens: a long bar slides off from between the hand and a ball.

    Until about 0.7 s no way leads through, and a front that comes to the bar before freezes there
    for good. The rest of the front goes round the bar's upper end, which takes longer than the
    situation lasts. A hand that waits beside the bar until its end has passed catches the ball.
    All numbers are chosen.
    """
    length, width = GATE
    bar = Polygon(((-length, -width), (length, -width), (length, width), (-length, width)))
    slide = PlanarQuadratic(
        (1.0, 0.8), (0.0, -GATE_SPEED), (0.0, 0.0), 0.5 * math.pi + GATE_LEAN
    )  # fmt: skip
    flight = PlanarQuadratic((1.7, -0.6), (-0.1, 0.5), (0.0, 0.0))
    return Situation(
        "gate",
        SOON,
        Arm((0.1, -1.3), HAND_SPEED),
        (Body("target", "ball", Disc(0.08), flight), Body("obstacle", "gate", bar, slide)),
    )


def thrown_scene() -> Situation[SpatialArm]:
    """A ball is thrown to an arm in space, and a post comes between.

    The arm is like a human's, its shoulder at the origin and z upwards. On the straight
    line in the joints the forearm would run into the post. All numbers are chosen.
    """
    arm = SpatialArm(
        upper_arm=(1.0, 0.0, 0.0),
        forearm=(1.0, 0.0, 0.0),
        joints=(1.0, -0.3, 0.2, -0.5),
        joint_range=((-2.8, 2.0), (-0.6, 2.2), (-2.4, 2.4), (-2.6, 0.0)),
        max_joint_speed=(5.0, 5.0, 7.0, 7.0),
        max_hand_speed=5.0,
        thickness=0.09,
        grasp=0.1,
    )
    still = (0.0, 0.0, 0.0)
    flight = SolidQuadratic((1.6, 2.1, 0.3), (-0.7, -0.7, 1.7), (0.0, 0.0, -3.0))
    post = SolidQuadratic((1.1, -0.1, -0.4), (-0.8, 0.8, 0.0), still)
    return Situation(
        "thrown-ball",
        1.0,
        arm,
        (
            Body("target", "ball", Sphere(0.12), flight),
            Body("obstacle", "post", Capsule(0.13, 0.75), post),
        ),
    )
