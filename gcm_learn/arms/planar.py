"""The planar arm: two bones in a plane, the forearm of length 1."""

from __future__ import annotations

import math
from dataclasses import dataclass

from gcm_learn.checks import choice, non_negative, positive, positive_vector, put, vector
from gcm_learn.errors import SituationError

ELBOWS = ("left", "right")
REACH_TOLERANCE = 1e-9
"""Relative slack for a hand that stands on the rim of the reachable ring up to rounding."""


@dataclass(frozen=True)
class Arm:
    """A planar arm of two segments with its shoulder at the origin; the forearm has length 1.

    Parameters
    ----------
    hand : (2,) tuple of float
        Position of the hand at t = 0, inside the reachable ring.
    max_hand_speed : float
        Above zero [forearms/s].
    upper_arm : float
        Length of the upper arm, rho, above zero.
    elbow : {"right", "left"}
        Side on which the elbow lies when looking from shoulder to hand; it is kept.
    max_joint_speed : (2,) tuple of float, optional
        Limits for shoulder and elbow [rad/s], above zero; no limits when absent.
    thickness : float
        Radius of both segments, not negative.
    grasp : float
        Distance at which the hand catches a target, not negative.
    """

    hand: tuple[float, float]
    max_hand_speed: float
    upper_arm: float = 1.0
    elbow: str = "right"
    max_joint_speed: tuple[float, float] | None = None
    thickness: float = 0.0
    grasp: float = 0.05

    def __post_init__(self) -> None:
        """Check the documented ranges, then that the hand is within reach."""
        put(self, "upper_arm", positive(self.upper_arm, "upper_arm"))
        put(self, "elbow", choice(self.elbow, "elbow", ELBOWS))
        put(self, "hand", vector(self.hand, "hand", 2))
        put(self, "max_hand_speed", positive(self.max_hand_speed, "max_hand_speed"))
        if self.max_joint_speed is not None:
            limits = positive_vector(self.max_joint_speed, "max_joint_speed", 2)
            put(self, "max_joint_speed", limits)
        put(self, "thickness", non_negative(self.thickness, "thickness"))
        put(self, "grasp", non_negative(self.grasp, "grasp"))
        self._check_reach()

    def _check_reach(self) -> None:
        """Refuse a hand outside the reachable ring."""
        distance = math.hypot(*self.hand)
        slack = REACH_TOLERANCE * self.reach
        if distance > self.reach + slack:
            raise SituationError("hand", f"{self.hand} is out of reach (max {self.reach})")
        if distance < self.inner_reach - slack:
            raise SituationError("hand", f"{self.hand} is out of reach (min {self.inner_reach})")

    @property
    def reach(self) -> float:
        """Largest distance between shoulder and hand."""
        return self.upper_arm + 1.0

    @property
    def inner_reach(self) -> float:
        """Smallest distance between shoulder and hand."""
        return abs(self.upper_arm - 1.0)
