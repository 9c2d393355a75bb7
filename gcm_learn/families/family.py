"""Base of all families: the arm's ranges, and draws in which the limb starts free."""

from __future__ import annotations

import math
from abc import abstractmethod
from dataclasses import dataclass, field, replace
from typing import ClassVar

import numpy as np

from gcm_learn.arms import Arm
from gcm_learn.errors import FamilyError
from gcm_learn.families import ranges
from gcm_learn.motion import start_clearance
from gcm_learn.scene import pack
from gcm_learn.situation import AnySituation, Pendulum, Situation

ATTEMPTS = 50  # draws until the limb starts free; after that many the last one is given
TINY = 1e-3  # what must be positive is at least this


@dataclass(frozen=True)
class ArmRanges(ranges.Ranges):
    """Ranges of planar arms and horizons; `dataclasses.replace` gives another embodiment."""

    upper_arm: ranges.Range = ranges.span(0.8, 1.2, TINY)
    """Length of the upper arm [forearms]."""
    right: float = ranges.number(0.5)
    """Share of arms whose elbow is on the right."""
    thickness: tuple[float, ...] = ranges.options(0.0, 0.03)
    """Radii of the segments, one of which is drawn [forearms]."""
    hand_speed: ranges.Range = ranges.span(2.8, 3.8, TINY)
    """Largest speed of the hand [forearms/s]."""
    horizon: ranges.Range = ranges.span(1.0, 1.4, TINY)
    """Last moment at which a catch counts [s]."""
    grasp: ranges.Range = ranges.span(0.05, 0.05)
    """Distance at which the hand catches [forearms]."""
    inner_margin: float = ranges.number(0.35)
    """Between the ring's inner rim and where hands start and meet targets [forearms]."""
    outer_margin: float = ranges.number(0.1)
    """Margin at the outer rim [forearms]."""

    def __post_init__(self) -> None:
        """Check the fields, and that the margins leave a ring."""
        super().__post_init__()
        width = 2.0 * min(self.upper_arm[0], 1.0)
        if self.inner_margin + self.outer_margin >= width:
            both = f"{self.inner_margin!r} and {self.outer_margin!r}"
            raise FamilyError("inner_margin", f"margins {both} fill the ring (width {width:g})")

    def draw(self, rng: np.random.Generator) -> tuple[Arm, float]:
        """Draw an arm, its hand in any direction from the shoulder, and a horizon [s]."""
        elbow = "right" if rng.random() < self.right else "left"
        upper_arm = ranges.pick(rng, self.upper_arm)
        angle, radius = ranges.pick_angle(rng), ranges.pick(rng, self.radii(upper_arm))
        arm = Arm(
            hand=(radius * math.cos(angle), radius * math.sin(angle)),
            thickness=ranges.choose(rng, self.thickness),
            max_hand_speed=ranges.pick(rng, self.hand_speed),
            upper_arm=upper_arm,
            elbow=elbow,
            grasp=ranges.pick(rng, self.grasp),
        )
        return arm, ranges.pick(rng, self.horizon)

    def radii(self, upper_arm: float) -> ranges.Range:
        """Distances from the shoulder at which hands start and meet targets [forearms]."""
        return abs(upper_arm - 1.0) + self.inner_margin, upper_arm + 1.0 - self.outer_margin


@dataclass(frozen=True)
class Family(ranges.Ranges):
    """Base of families: a law for drawing random situations, with the ranges to draw from.

    `dataclasses.replace` gives the same law with other ranges: faster, larger, more, another arm.
    """

    name: ClassVar[str]
    """Under which it is registered."""
    summary: ClassVar[str]
    """Description in one line."""
    kind: ClassVar[str] = "planar"
    """Of the arm: planar or spatial."""
    several: ClassVar[bool] = False
    """True if every situation asks for several catches."""

    def draw(self, rng: np.random.Generator, name: str = "") -> AnySituation:
        """Draw a situation in which the limb touches nothing at t = 0.

        Draws that start blocked are thrown away, which thins out obstacles near the arm.  After
        `ATTEMPTS` of them the last one is given; only ranges that leave no space lead there.

        Parameters
        ----------
        rng : numpy.random.Generator
            The only source of randomness.
        name : str
            Of the situation; by default the family's. Names must be unique in a file.

        Returns
        -------
        Situation
            Valid; the target may be out of reach.
        """
        for _ in range(ATTEMPTS):
            situation = self.sketch(rng, name or self.name)
            if _starts_free(situation):
                break
        return situation

    @abstractmethod
    def sketch(self, rng: np.random.Generator, name: str) -> AnySituation:
        """Draw once, the limb free or not."""


@dataclass(frozen=True)
class PlanarFamily(Family):
    """Base of families for an arm that moves in a plane."""

    arm: ArmRanges = field(default_factory=ArmRanges)
    obstacles: ranges.Counts = ranges.counts(1, 4)
    """Number of obstacles."""

    @abstractmethod
    def sketch(self, rng: np.random.Generator, name: str) -> Situation:
        """Draw once, the limb free or not."""


def _starts_free(situation: AnySituation) -> bool:
    """Return whether the limb touches nothing at t = 0."""
    if any(isinstance(body.motion, Pendulum) for body in situation.bodies):
        # Packing one integrates its swing up to the horizon, of which nothing is needed here.
        situation = replace(situation, horizon=TINY)
    return start_clearance(pack(situation)) > 0.0
