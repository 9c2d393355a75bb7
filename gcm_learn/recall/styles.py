"""Records and bumps that kernels of hand paths and of joint movements share."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gcm_learn.compiled import njit

POLAR, CARTESIAN = 0, 1  # coordinates in which hand paths are adapted
HURRY, KEEP = 0, 1  # keep waits and hurry the rest, or keep all times


class Style(NamedTuple):
    """Style of an adaptation."""

    space: int  # POLAR or CARTESIAN; joint movements have no other than POLAR
    tempo: int  # HURRY or KEEP


class Chase(NamedTuple):
    """Numbers by which a target is chased, see `recall.meeting.meet`."""

    since: float  # first instant [s]
    speed: float  # of the hand [lengths / s]
    horizon: float  # [s]
    closing: float  # share of a delay in which hand and target can close the gap
    close: float  # time within which the instant is found [s]
    stride: float  # step without a target to be met [s]
    instant: float  # least step [s]
    most: int  # instants at most


class QuickCheck(NamedTuple):
    """Numbers of a quick check, see `recall.freeing.quick_check`."""

    touch: float  # distance of a limb that touches [lengths]
    unit: float  # length that margins are shares of
    enough: float  # clearance that costs nothing [lengths]
    end: float  # number of the last instant
    nearer: float  # by which clearance may shrink from one instant to the next [lengths]
    most: float  # instants that may be passed over


class Habits(NamedTuple):
    """Numbers by which a path that touches is changed, see `recall.freeing.free`."""

    changes: int  # changes in a round: pushes, then holds
    margin: float  # clearance of a changed path at quick checks [lengths]
    progress: float  # share of the contact that the best change may leave for another round
    lenient: bool  # True if the margin does not count at the end
    checks_first: bool  # True if a path is checked before it is changed
    alternatives: int  # memories that are compared before each check after the first


WIDTHS = (1.0, 0.3)  # of bumps [shares of the path]
SIDES = 2  # of an obstacle
PUSHED = SIDES * len(WIDTHS)  # changes that are pushes, the first of a round


@njit
def bump(share, top, wide):
    """Return the height of a bump at a share of the path.

    It is 1 at its top, and 0 at a distance of `wide` and at both ends. An end that is its top is 1.
    """
    s = 1.0
    if share != top:
        s = 1.0 - abs(share - top) / min(wide, top if share < top else 1.0 - top)
    return np.sin(0.5 * np.pi * min(max(s, 0.0), 1.0)) ** 2
