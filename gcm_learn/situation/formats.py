"""Versions of the exchange format of situations, and what each of them holds."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

from gcm_learn.arms import Kind, kinds
from gcm_learn.situation.laws import Motion
from gcm_learn.situation.motion import Pendulum, PlanarQuadratic, SolidQuadratic
from gcm_learn.situation.timed_motion import Piecewise, Sampled


@dataclass(frozen=True)
class Format:
    """One version of the exchange format.

    Parameters
    ----------
    name : str
    motions : tuple of type
        Motion laws that bodies may follow.
    catches : tuple of str
        Known values of `catch`; the first is the default, and one alone is never written.
    approach : bool
        Whether targets may have an approach.
    planes : bool
        Whether a planar arm may stand in a plane among solids.
    normalises : bool
        Whether unit vectors may be off by up to `checks.UNIT_LENGTH`, and are normalised.
    """

    name: str
    motions: tuple[type[Motion], ...]
    catches: tuple[str, ...] = ("any",)
    approach: bool = False
    planes: bool = False
    normalises: bool = False

    @property
    def kinds(self) -> tuple[Kind, ...]:
        """Kinds of arms that situations of this format have."""
        return tuple(kind for kind in kinds() if self.name in kind.formats)

    @cached_property
    def motion_kinds(self) -> tuple[str, ...]:
        """Values of `kind` in motions."""
        return tuple(dict.fromkeys(motion.kind for motion in self.motions))

    @cached_property
    def absent(self) -> frozenset[str]:
        """Fields of situations and bodies that this format does not know."""
        given = {"catch": len(self.catches) > 1, "approach": self.approach}
        return frozenset(name for name, known in given.items() if not known)


_QUADRATIC = (PlanarQuadratic, SolidQuadratic, Pendulum)
CATCHES = ("any", "all", "most")

FORMATS = {
    version.name: version
    for version in (
        Format("gcm-learn/situation@1", _QUADRATIC, planes=True),
        Format("gcm-learn/situation@2", _QUADRATIC),
        Format(
            "gcm-learn/situation@3",
            (*_QUADRATIC, Piecewise, Sampled),
            CATCHES,
            approach=True,
            normalises=True,
        ),
    )
}
