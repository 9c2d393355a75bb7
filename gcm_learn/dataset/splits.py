"""Splits: records for training, for choosing and for the final test."""

from __future__ import annotations

from dataclasses import dataclass

from gcm_learn.dataset import checks
from gcm_learn.errors import SpecError

QUANTITIES = (
    "upper_arm", "max_hand_speed", "horizon", "obstacles", "top_speed", "largest"
)  # fmt: skip
"""Columns of a record that a range split may ask about."""
_MASK = (1 << 64) - 1


@dataclass(frozen=True)
class Split:
    """Shares of the records that are drawn by lot from their index."""

    validation: float = 0.05
    test: float = 0.05
    """The rest is for training."""

    def __post_init__(self) -> None:
        checks.share(self.validation, "validation")
        checks.share(self.test, "test")
        if self.validation + self.test > 1.0:
            total = f"{self.validation} + {self.test}"
            raise SpecError("test", f"the shares of validation and test exceed 1 ({total})")


@dataclass(frozen=True)
class Holdout:
    """Split for records that training must not see: a family, a range, an embodiment.

    All conditions that are given must hold.
    """

    split: str
    """Name of the split."""
    family: str | None = None
    """One family, left out of the others."""
    quantity: str | None = None
    """A column: upper_arm, max_hand_speed, horizon, obstacles (how many), top_speed (of the fastest
    body, in hand speeds) or largest (bounding radius of the largest obstacle)."""
    above: float | None = None
    below: float | None = None

    def __post_init__(self) -> None:
        checks.name(self.split, "split")
        if self.split in ("train", "validation"):
            raise SpecError("split", f"{self.split!r} cannot be held out")
        if self.family is None and self.quantity is None:
            raise SpecError("family", "is missing (or quantity with above or below)")
        if self.quantity is not None:
            checks.choice(self.quantity, "quantity", QUANTITIES)
            if self.above is None and self.below is None:
                raise SpecError("above", "is missing (or below)")
        for bound in ("above", "below"):
            if getattr(self, bound) is not None:
                checks.number(getattr(self, bound), bound)
                if self.quantity is None:
                    raise SpecError("quantity", f"is missing ({bound} needs one)")

    def holds(self, family: str, quantities: dict[str, float]) -> bool:
        """Return whether a record belongs to this split."""
        if self.family is not None and family != self.family:
            return False
        if self.quantity is None:
            return True
        value = quantities[self.quantity]
        high_enough = self.above is None or value > self.above
        return high_enough and (self.below is None or value < self.below)


def split_of(
    split: Split,
    holdouts: tuple[Holdout, ...],
    seed: int,
    k: int,
    family: str,
    quantities: dict[str, float],
) -> str:
    """Name of the split of item k."""
    for holdout in holdouts:
        if holdout.holds(family, quantities):
            return holdout.split
    lot = lot_of(seed, k)
    if lot < split.test:
        return "test"
    return "validation" if lot < split.test + split.validation else "train"


def lot_of(seed: int, k: int, salt: int = 0) -> float:
    """A number in [0, 1) that depends on seed, index and purpose only (the mixer of SplitMix64).

    It shares nothing with the generators of the draws, so it is independent of what is drawn.
    """
    z = (seed * 0xD1342543DE82EF95 + k * 0x9E3779B97F4A7C15 + salt * 0xA0761D6478BD642F) & _MASK
    for shift, factor in ((30, 0xBF58476D1CE4E5B9), (27, 0x94D049BB133111EB)):
        z = ((z ^ (z >> shift)) * factor) & _MASK
    return ((z ^ (z >> 31)) >> 11) * 2.0**-53
