"""Placement of bodies such that a situation is worth planning for.

Bodies drawn anywhere hardly ever matter. Here they are put, or aimed, at a point that the limb
would sweep on the straight way from the hand to its meeting with the target. Bodies that would
touch the limb at its start, or make the meeting impossible, are recognised.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from gcm_learn.arms import SIDE, Arm, elbow_of
from gcm_learn.collision import limb_segment2
from gcm_learn.families.pieces import PlanarPiece, Vector
from gcm_learn.families.ranges import Range, Ranges, pick, pick_angle, pick_sign, span

TRIES = 10  # draws of what has to fit; after that many the last one is taken
LATEST = 0.9  # latest planned meeting [horizons]
UPPER_ARM = (0.3, 1.0)  # where along it points are put
FOREARM = (0.2, 1.1)  # the same; 1.1 is beyond the hand
TINY = 1e-3  # [forearms]
CORNER = 1.42  # a bar's corners are at most this many half widths from its middle line


class Event(NamedTuple):
    """Target of a situation, and one place and time for the hand to meet it."""

    target: PlanarPiece
    meet: Vector
    """Place at which the hand may meet it [forearms]."""
    when: float
    """[s]"""
    horizon: float
    """[s]"""
    side: float
    """1 or -1: a choice that all bodies of the situation share."""


def elbow_at(arm: Arm, hand: Vector) -> Vector:
    """Elbow of a hand position."""
    x, y = elbow_of(*hand, arm.upper_arm, SIDE[arm.elbow])
    return x, y


@dataclass(frozen=True)
class WayRanges(Ranges):
    """Ranges of the place at which the hand may meet the target, as seen from the hand's start."""

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
    """Draw the time at which the hand may meet a moving target [s].

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
    rng: np.random.Generator, arm: Arm, event: Event, share: Range, inside: float
) -> tuple[Vector, float]:
    """Draw a point that the limb sweeps on its straight way to the meeting, and the time then.

    A body nearer to the shoulder than the elbow stops the upper arm from turning past it, so
    that the only detour is the long way round. Farther bodies can be dodged by folding the arm.

    Parameters
    ----------
    rng : numpy.random.Generator
    arm : Arm
    event : Event
    share : (float, float)
        Range of shares of the way.
    inside : float
        Share of points on the upper arm; the others are on the forearm, farther than the elbow.

    Returns
    -------
    point : (2,) tuple of float
        [forearms]
    when : float
        [s]
    """
    upper = rng.random() < inside
    (x, y), (mx, my) = arm.hand, event.meet
    for _ in range(TRIES):
        s = pick(rng, share)
        hand = (x + s * (mx - x), y + s * (my - y))
        ex, ey = elbow_at(arm, hand)
        if upper:
            f = pick(rng, UPPER_ARM)
            point = (f * ex, f * ey)
            break
        f = pick(rng, FOREARM)
        point = (ex + f * (hand[0] - ex), ey + f * (hand[1] - ey))
        if math.hypot(*point) > arm.upper_arm:
            break
    return point, s * event.when


def way_time(arm: Arm, meet: Vector) -> float:
    """Return the least time that the hand takes to a place [s]."""
    return math.hypot(meet[0] - arm.hand[0], meet[1] - arm.hand[1]) / arm.max_hand_speed


def anywhere(rng: np.random.Generator, arm: Arm, inside: float) -> Vector:
    """Draw a place within reach; a share `inside` is nearer to the shoulder than the elbow.

    In each of the two regions all places are equally likely.
    """
    near, far = (TINY, arm.upper_arm) if rng.random() < inside else (arm.upper_arm, arm.reach)
    return polar(math.sqrt(pick(rng, (near * near, far * far))), pick_angle(rng))


def polar(radius: float, angle: float) -> Vector:
    """The vector of a length and a direction."""
    return radius * math.cos(angle), radius * math.sin(angle)


def leaves_room(piece: PlanarPiece, arm: Arm, event: Event) -> bool:
    """Return whether a piece is clear of the limb both at the limb's start and at the meeting.

    Decided in the plane, with bars rounded off: for solids, which may lean, it is a good guess.
    """
    if touches(piece, arm, arm.hand, 0.0):
        return False
    return not touches(piece, arm, event.meet, event.when)


def touches(piece: PlanarPiece, arm: Arm, hand: Vector, t: float) -> bool:
    """Return whether a piece touches the limb at time t, with the hand at `hand`."""
    (x, y), (dx, dy) = piece.at(t), (0.0, 0.0)
    near = piece.size[-1]
    if len(piece.size) == 2:
        angle = piece.angle + piece.spin * (t - piece.when)
        dx, dy = piece.size[0] * math.cos(angle), piece.size[0] * math.sin(angle)
        # The origin is on the bar's middle line, `offset` from its middle.
        share = piece.offset / piece.size[0]
        x, y, near = x + share * dx, y + share * dy, CORNER * near
    elbow = elbow_of(*hand, arm.upper_arm, SIDE[arm.elbow])
    gap2 = limb_segment2(*hand, *elbow, x - dx, y - dy, x + dx, y + dy)
    return bool(gap2 <= (arm.thickness + near) ** 2)
