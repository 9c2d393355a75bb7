"""Balls and bars of a family: the same plan of a scene becomes planar bodies or solids.

A family says where in the arm's plane its pieces are, when, and how they move. In a planar scene
a ball is a disc and a bar a polygon. In space a ball becomes a sphere or a post, a bar a box, a
capsule or a cylinder. They may lean. Movers come through the plane, and are in its middle when
the family wants them there.
"""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from gcm_learn.families.ranges import Range, Ranges, pick, pick_angle, pick_sign, span
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
    SolidQuadratic,
    SolidShape,
    Sphere,
)

Vector = tuple[float, float]
Quaternion = tuple[float, float, float, float]  # w, x, y, z

UPRIGHT = Plane((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 0.0, 1.0))  # vertical, z of the world is up
_UNTURNED: Quaternion = (1.0, 0.0, 0.0, 0.0)
_STAND: Quaternion = (math.sqrt(0.5), math.sqrt(0.5), 0.0, 0.0)  # arm plane to world
_LIE: Quaternion = (math.sqrt(0.5), 0.0, math.sqrt(0.5), 0.0)  # a body's z axis to its x axis


class PlanarPiece(NamedTuple):
    """A ball or a bar in the arm's plane."""

    role: str
    name: str
    size: tuple[float, ...]
    """Radius of a ball; half the length and half the width of a bar [forearms]."""
    place: Vector
    """Its origin at `when` [forearms]."""
    when: float = 0.0
    """[s]"""
    velocity: Vector = (0.0, 0.0)
    """At t = 0 [forearms/s]."""
    acceleration: Vector = (0.0, 0.0)
    """[forearms/s^2]"""
    angle: float = 0.0
    """Direction of a bar at `when` [rad]."""
    spin: float = 0.0
    """[rad/s]"""
    offset: float = 0.0
    """From the origin to a bar's middle, along the bar: half its length makes it a hinge."""
    leaves: float | None = None
    """In space: when a bar that starts from rest has left the plane along its normal [s]."""

    @property
    def rests(self) -> bool:
        """True if the piece does not move at all."""
        return self.velocity == self.acceleration == (0.0, 0.0) and self.spin == 0.0

    def at(self, t: float) -> Vector:
        """Return the piece's origin at time t."""
        late, half = t - self.when, 0.5 * (t * t - self.when * self.when)
        (x, y), (vx, vy), (ax, ay) = self.place, self.velocity, self.acceleration
        return x + vx * late + ax * half, y + vy * late + ay * half


@dataclass(frozen=True)
class SpaceRanges(Ranges):
    """Ranges for solids only: speed, lean and extent out of the arm's plane."""

    crossing: Range = span(0.0, 0.4)
    """Speeds at which movers come through the arm's plane [hand speeds]."""
    lean: Range = span(0.0, 0.5, most=math.pi / 2)
    """Angles by which bodies lean out of the plane, or posts out of its normal [rad]."""
    depth: Range = span(0.1, 0.4, 1e-3)
    """Half the extents along the normal [forearms]."""


def planar_body(piece: PlanarPiece) -> Body:
    """A piece as a disc or a rectangle."""
    shape: Disc | Polygon
    if len(piece.size) == 1:
        shape = Disc(piece.size[0])
    else:
        long, wide = piece.size
        a, b = piece.offset - long, piece.offset + long
        shape = Polygon(((a, -wide), (b, -wide), (b, wide), (a, wide)))
    angle = piece.angle - piece.spin * piece.when
    motion = PlanarQuadratic(piece.at(0.0), piece.velocity, piece.acceleration, angle, piece.spin)
    return Body(piece.role, piece.name, shape, motion)


def solid_body(
    rng: np.random.Generator,
    piece: PlanarPiece,
    space: SpaceRanges,
    speed: float,
    *,
    firm: bool = False,
) -> Body:
    """Return a piece as a solid that is in the arm's plane at the piece's time.

    Parameters
    ----------
    rng : numpy.random.Generator
    piece : PlanarPiece
    space : SpaceRanges
    speed : float
        Of the hand [forearms/s].
    firm : bool
        Neither let it lean nor come through the plane.
    """
    depth = pick(rng, space.depth)
    tilt = _UNTURNED if firm else _lean(rng, pick(rng, space.lean))
    if piece.leaves is not None:
        return _leaving(rng, piece, tilt, depth)
    shape, own = _solid_shape(rng, piece, depth)
    if piece.offset and piece.spin:
        motion: Pendulum | SolidQuadratic = _hinge(piece, tilt)
    else:
        through = 0.0 if firm or piece.rests else pick_sign(rng) * pick(rng, space.crossing) * speed
        motion = _flight(piece, tilt, own, through)
    return Body(piece.role, piece.name, shape, motion)


def ball_through(piece: PlanarPiece, through: float, middle: float) -> Body:
    """A ball as a sphere that comes through the plane.

    Parameters
    ----------
    piece : PlanarPiece
    through : float
        Speed along the normal [forearms/s].
    middle : float
        When its centre is in the plane [s].
    """
    motion = SolidQuadratic(
        in_world(*piece.at(0.0), -through * middle),
        in_world(*piece.velocity, through),
        in_world(*piece.acceleration, 0.0),
    )
    return Body(piece.role, piece.name, Sphere(piece.size[0]), motion)


def _solid_shape(
    rng: np.random.Generator, piece: PlanarPiece, depth: float
) -> tuple[SolidShape, Quaternion]:
    """Draw a solid of a piece's size, and the turn that aligns its z axis with the piece."""
    if len(piece.size) == 1:
        (radius,) = piece.size
        kind = 0 if piece.role == "target" else int(rng.integers(3))
        return (Sphere(radius), Capsule(radius, depth), Cylinder(radius, depth))[kind], _UNTURNED
    long, wide = piece.size
    if piece.offset and piece.spin:  # on a pendulum's cord, which is the body's z axis
        return Capsule(wide, long), _UNTURNED
    kind = int(rng.integers(3))
    if kind == 0:
        return Box((long, wide, depth)), _UNTURNED
    return (Capsule(wide, long) if kind == 1 else Cylinder(wide, long)), _LIE


def _flight(
    piece: PlanarPiece, tilt: Quaternion, own: Quaternion, through: float
) -> SolidQuadratic:
    """Return a motion: accelerated in the plane, at speed `through` it, spinning about tilted z."""
    frame = product(_STAND, tilt)
    angle = piece.angle - piece.spin * piece.when
    x, y = piece.at(0.0)
    shift = turned(frame, (piece.offset * math.cos(angle), piece.offset * math.sin(angle), 0.0))
    px, py, pz = in_world(x, y, -through * piece.when)
    axis = turned(frame, (0.0, 0.0, 1.0))
    return SolidQuadratic(
        (px + shift[0], py + shift[1], pz + shift[2]),
        in_world(*piece.velocity, through),
        in_world(*piece.acceleration, 0.0),
        product(product(frame, about_z(angle)), own),
        (piece.spin * axis[0], piece.spin * axis[1], piece.spin * axis[2]),
    )


def _leaving(rng: np.random.Generator, piece: PlanarPiece, tilt: Quaternion, depth: float) -> Body:
    """A box that is pulled out of the plane from rest."""
    long, wide = piece.size
    assert piece.leaves is not None
    rest = _flight(piece, tilt, _UNTURNED, 0.0)
    pull = pick_sign(rng) * 2.0 * depth / piece.leaves**2
    motion = dataclasses.replace(rest, acceleration=in_world(0.0, 0.0, pull))
    return Body(piece.role, piece.name, Box((long, wide, depth)), motion)


def _hinge(piece: PlanarPiece, tilt: Quaternion) -> Pendulum:
    """Return a bar's steady turn about its end, as a pendulum without gravity."""
    frame = product(_STAND, tilt)
    angle = piece.angle - piece.spin * piece.when
    return Pendulum(
        pivot=in_world(*piece.place, 0.0),
        axis=turned(frame, (0.0, 0.0, 1.0)),
        down=turned(frame, (math.cos(angle), math.sin(angle), 0.0)),
        length=piece.offset,
        gravity=0.0,
        angle=0.0,
        rate=piece.spin,
    )


def _lean(rng: np.random.Generator, angle: float) -> Quaternion:
    """A turn by an angle about a random axis in the plane."""
    axis = pick_angle(rng)
    half = math.sin(0.5 * angle)
    return math.cos(0.5 * angle), half * math.cos(axis), half * math.sin(axis), 0.0


def in_world(x: float, y: float, z: float) -> tuple[float, float, float]:
    """A vector (x, y, along the normal) of the upright arm plane in the world's frame."""
    return x, -z, y


def about_z(angle: float) -> Quaternion:
    """A turn about the z axis."""
    return math.cos(0.5 * angle), 0.0, 0.0, math.sin(0.5 * angle)


def product(p: Quaternion, q: Quaternion) -> Quaternion:
    """The turn q, then the turn p."""
    a, b, c, d = p
    e, f, g, h = q
    return (
        a * e - b * f - c * g - d * h,
        a * f + b * e + c * h - d * g,
        a * g - b * h + c * e + d * f,
        a * h + b * g - c * f + d * e,
    )


def turned(q: Quaternion, v: tuple[float, float, float]) -> tuple[float, float, float]:
    """A vector after a turn."""
    a, b, c, d = q
    _, x, y, z = product(product(q, (0.0, *v)), (a, -b, -c, -d))
    return x, y, z
