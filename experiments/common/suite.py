"""Situations that are drawn by their stratum, with the oracle's bounds."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from gcm_learn import seeding
from gcm_learn.families import get_family
from gcm_learn.planners import marching
from gcm_learn.planners.baselines.straight import StraightPlanner
from gcm_learn.planners.completion import Problem
from gcm_learn.planners.oracle.bounds import bounds, stratum
from gcm_learn.situation import situation_from_json, situation_to_json


@dataclass(frozen=True)
class Case:
    """A situation with what the oracle knows of it."""

    index: int
    family: str
    stratum: str
    decided: bool
    """True if the oracle found a catch, or ruled one out."""
    lower: float
    """No movement catches before [s]."""
    upper: float
    """When the oracle's plan catches [s]."""
    situation: dict[str, Any]

    def read(self) -> Any:
        """The situation as a record."""
        return situation_from_json(self.situation)


def draw(config: dict[str, Any], index: int, wanted: tuple[str, ...]) -> Case | str:
    """Draw number `index` of an experiment, or why it is not kept.

    Families take turns.
    """
    family = config["families"][index % len(config["families"])]
    rng = seeding.rng(config["seed"], index)
    situation = get_family(family).draw(rng, f"{family}-{index:07d}")
    answer = Problem(situation, "oracle").early_answer()
    if answer is not None and answer.status == "start_blocked":
        return "start_blocked"
    # What is not wanted is not bounded: these two planners decide L and W by themselves.
    if StraightPlanner().plan(situation).caught:
        if "L" not in wanted:
            return "L"
    elif "W" not in wanted and marching().plan(situation).caught:
        return "W"
    known = bounds(situation)
    found = stratum(situation, known)
    if found not in wanted:
        return found
    return Case(
        index, family, found, known.decided, known.lower, known.upper, situation_to_json(situation)
    )
