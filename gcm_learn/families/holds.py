"""Tasks beyond a touch: holds, an end at rest, margins that grow."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np

from gcm_learn.arms import Chain
from gcm_learn.families.family import TINY
from gcm_learn.families.ranges import Range, Ranges, number, pick, span
from gcm_learn.situation import Body, Hold, Margin, Situation, SolidQuadratic, with_end

SituationT = TypeVar("SituationT", bound=Situation[Chain])


@dataclass(frozen=True)
class Holds(Ranges):
    """Holds of targets, for arms with limits of acceleration.

    Lengths are in reaches, for spatial arms in forearms.
    """

    share: float = number(0.0)
    """Share of situations in which targets are to be held, and the arm ends at rest."""
    seconds: Range = span(0.1, 0.2, most=60.0)
    """Duration of a hold [s]."""
    relative_speed: Range = span(0.06, 0.12, TINY)
    """Largest speed of the hand relative to what it holds [lengths/s]."""
    growth: Range = span(0.0, 0.0)
    """Rate at which margins of moving obstacles grow [lengths/s]."""

    def ask(self, rng: np.random.Generator, situation: SituationT, unit: float) -> SituationT:
        """Return the situation with holds and rest, or unchanged; `unit` is a reach's length."""
        if self.share == 0.0 or rng.random() >= self.share:
            return situation
        hold = Hold(pick(rng, self.seconds), pick(rng, self.relative_speed) * unit)
        margin = Margin(0.0, pick(rng, self.growth) * unit) if self.growth[1] > 0.0 else None

        def asked(body: Body) -> Body:
            if body.role == "target":
                return replace(body, hold=hold)
            return replace(body, margin=margin) if margin is not None and moves(body) else body

        rests = with_end(situation, "rest")
        return replace(rests, bodies=tuple(map(asked, situation.bodies)))  # type: ignore[return-value]


def moves(body: Body) -> bool:
    """Return whether a body moves or turns."""
    law = body.motion
    return not isinstance(law, SolidQuadratic) or any((*law.velocity, *law.acceleration, *law.spin))
