"""The table of contests by kind of arm."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from gcm_learn.arms import PLANAR, SPATIAL, ByKind
from gcm_learn.evaluation.movements import hand_movement, joint_movement
from gcm_learn.evaluation.resting import hand_resting, joints_resting


@dataclass(frozen=True)
class ContestKind:
    """Contests between methods on situations with one kind of arm."""

    example: str | None
    """Family of the situations that methods answer beforehand; None for the first one itself."""
    movement: Callable[..., dict[str, Any]]
    """Numbers of an answer's path, of situation, result and path."""
    resting: Callable[[Any, float], str]
    """Outcome of a rest in a situation for some time [s]."""


CONTESTS = ByKind(
    {
        PLANAR: ContestKind("crossing-swarm", hand_movement, hand_resting),
        SPATIAL: ContestKind("crossing-swarm-space", joint_movement, joints_resting),
    },
    default=ContestKind(None, joint_movement, joints_resting),
)
