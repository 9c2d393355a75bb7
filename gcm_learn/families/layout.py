"""Where things are put so that a situation is worth planning for.

Bodies drawn anywhere hardly ever matter. Here they are put, or aimed, at a point that the limb
would sweep on the straight way from the hand to where the target is met; and those that would
touch the limb at its start, or make the meeting impossible, are recognised.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from gcm_learn.families.pieces import Piece, Vector
from gcm_learn.families.ranges import Range, Ranges, pick, pick_angle, pick_sign, span
from gcm_learn.situation import Arm

TRIES = 10  # draws of what has to fit; after that many the last one is taken
LATEST = 0.9  # latest planned meeting [horizons]
UPPER = 0.25  # share of points that are put on the upper arm, the others on the forearm
PARTS = {"upper": (0.3, 1.0), "fore": (0.2, 1.1)}  # how far along a segment; 1.1 is beyond the hand
CORNER = 1.42  # a bar's corners are at most this many half widths from its middle line


class Event(NamedTuple):
    """What a situation is about: the target, and one way for the hand to meet it."""

    target: Piece
    meet: Vector
    """Where the hand may meet it [forearms]."""
    when: float
    """[s]"""
    horizon: float
    """[s]"""
    side: float
    """1 or -1: a choice that all bodies of the situation share."""


def elbow_at(arm: Arm, hand: Vector) -> Vector:
    """Elbow of a hand position (erratum 7's closed form, as in `arm.kinematics`)."""
    x, y = hand
    r2 = max(x * x + y * y, 1e-12)
    rho = arm.upper_arm
    a = min(max((r2 + rho * rho - 1.0) / (2.0 * rho * math.sqrt(r2)), -1.0), 1.0)
    b = math.sqrt(1.0 - a * a) * (1.0 if arm.elbow == "right" else -1.0)
    scale = rho / math.sqrt(r2)
    return scale * (a * x + b * y), scale * (a * y - b * x)


@dataclass(frozen=True)
class WayRanges(Ranges):
    """Where the target may be met, as seen from the hand's start."""

    turn: Range = span(0.6, 2.4, most=3.14)
    """Angle at the shoulder, to either side [rad]."""
    length: Range = span(0.15, 0.6)
    """Length of the straight way, in ways that the hand can make within the horizon."""

    def end(self, rng: np.random.Generator, arm: Arm, horizon: float, radii: Range) -> Vector:
        """A place in the ring between two radii."""
        hand = math.atan2(arm.hand[1], arm.hand[0])
        for _ in range(TRIES):
            place = polar(pick(rng, radii), hand + pick_sign(rng) * pick(rng, self.turn))
            if self.length[0] <= way_time(arm, place) / horizon <= self.length[1]:
                break
        return place


def meeting_time(
    rng: np.random.Generator, arm: Arm, meet: Vector, wait: Range, horizon: float
) -> float:
    """When a moving target is where it may be met [s].

    Parameters
    ----------
    rng : numpy.random.Generator
    arm : Arm
    meet : (2,) tuple of float
    wait : (float, float)
        In times that the hand needs for the straight way.
    horizon : float
        [s]
    """
    return min(pick(rng, wait) * way_time(arm, meet), LATEST * horizon)


def on_the_way(
    rng: np.random.Generator, arm: Arm, event: Event, share: Range
) -> tuple[Vector, float]:
    """A point that the limb sweeps on its straight way to the meeting, and when.

    Parameters
    ----------
    rng : numpy.random.Generator
    arm : Arm
    event : Event
    share : (float, float)
        Range of shares of the way.

    Returns
    -------
    point : (2,) tuple of float
        [forearms]
    when : float
        [s]
    """
    s = pick(rng, share)
    (x, y), (mx, my) = arm.hand, event.meet
    hand = (x + s * (mx - x), y + s * (my - y))
    ex, ey = elbow_at(arm, hand)
    if rng.random() < UPPER:
        f = pick(rng, PARTS["upper"])
        point = (f * ex, f * ey)
    else:
        f = pick(rng, PARTS["fore"])
        point = (ex + f * (hand[0] - ex), ey + f * (hand[1] - ey))
    return point, s * event.when


def way_time(arm: Arm, meet: Vector) -> float:
    """How long the hand takes to a place at least [s]."""
    return math.hypot(meet[0] - arm.hand[0], meet[1] - arm.hand[1]) / arm.max_hand_speed


def anywhere(rng: np.random.Generator, arm: Arm) -> Vector:
    """A place in the disc that the arm reaches, evenly."""
    return polar(arm.reach * math.sqrt(rng.random()), pick_angle(rng))


def polar(radius: float, angle: float) -> Vector:
    """The vector of a length and a direction."""
    return radius * math.cos(angle), radius * math.sin(angle)


def leaves_room(piece: Piece, arm: Arm, event: Event) -> bool:
    """Whether a piece touches the limb neither at its start nor at the meeting.

    Decided in the plane, with bars rounded off: for solids, which may lean, it is a good guess.
    """
    if touches(piece, arm, arm.hand, 0.0):
        return False
    return not touches(piece, arm, event.meet, event.when)


def touches(piece: Piece, arm: Arm, hand: Vector, t: float) -> bool:
    """Whether a piece is nearer to the limb of a hand position than its thickness, at time t."""
    x, y = piece.at(t)
    long, wide = piece.size if len(piece.size) == 2 else (0.0, piece.size[0])
    near = arm.thickness + (CORNER * wide if long else wide)
    ex, ey = elbow_at(arm, hand)
    ax = ay = bx = by = 0.0
    if long:
        angle = piece.angle + piece.spin * (t - piece.when)
        c, s = math.cos(angle), math.sin(angle)
        ax, ay = (piece.offset - long) * c, (piece.offset - long) * s
        bx, by = (piece.offset + long) * c, (piece.offset + long) * s
    bar = (x + ax, y + ay, x + bx, y + by)
    upper, fore = (0.0, 0.0, ex, ey), (ex, ey, hand[0], hand[1])
    return _squared_gap(bar, upper) <= near * near or _squared_gap(bar, fore) <= near * near


Line = tuple[float, float, float, float]  # both ends of a segment


def _squared_gap(p: Line, q: Line) -> float:
    """Squared distance of two segments in the plane: 0 if they cross, else at one of the ends."""
    ux, uy, vx, vy = p[2] - p[0], p[3] - p[1], q[2] - q[0], q[3] - q[1]
    wx, wy = q[0] - p[0], q[1] - p[1]
    cross = ux * vy - uy * vx
    if cross != 0.0:
        s, t = (wx * vy - wy * vx) / cross, (wx * uy - wy * ux) / cross
        if 0.0 <= s <= 1.0 and 0.0 <= t <= 1.0:
            return 0.0
    return min(
        _from_end(p[0], p[1], q, vx, vy),
        _from_end(p[2], p[3], q, vx, vy),
        _from_end(q[0], q[1], p, ux, uy),
        _from_end(q[2], q[3], p, ux, uy),
    )


def _from_end(x: float, y: float, line: Line, dx: float, dy: float) -> float:
    """Squared distance of a point to a segment with the direction (dx, dy)."""
    x, y = x - line[0], y - line[1]
    length2 = dx * dx + dy * dy
    s = min(max((x * dx + y * dy) / length2, 0.0), 1.0) if length2 > 0.0 else 0.0
    x, y = x - s * dx, y - s * dy
    return x * x + y * y
