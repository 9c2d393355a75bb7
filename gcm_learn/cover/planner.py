"""Planner `covered`: answers from covers, in a time that does not depend on their size."""

from __future__ import annotations

import time
from dataclasses import dataclass
from functools import cached_property, lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from gcm_learn import artifacts
from gcm_learn.arms import Kind, kind_of
from gcm_learn.cover.catches import StoredCatch, verdict_of
from gcm_learn.cover.cover import CLOSED, MANIFEST, Cell, Cover, load_cover
from gcm_learn.cover.families import FAMILIES, SAME
from gcm_learn.errors import CoverError
from gcm_learn.motion import Failure
from gcm_learn.planners import Plan, as_ours
from gcm_learn.situation import AnySituation

NAME = "covered"


class ProvenPlan(Plan):
    """Plan of a proven cell; the clearance is measured at its first use."""

    @classmethod
    def of(cls, situation: AnySituation, catch: StoredCatch, **known: Any) -> ProvenPlan:
        """Return the plan of a situation by a stored catch."""
        made = cls(name=situation.name, status="caught", format=situation.format, **known)
        vars(made)["_asked"] = situation, catch.body, catch.span
        del vars(made)["clearance"]  # so that the property answers
        return made

    @cached_property
    def clearance(self) -> float | None:  # type: ignore[override]
        """Smallest distance of limb and obstacles, less the thickness."""
        situation, body, span = vars(self)["_asked"]
        return verdict_of(situation, self.trajectory, body, span).clearance  # type: ignore[arg-type]


@dataclass(frozen=True)
class CoveredPlanner:
    """Answers situations of proven cells by the rule of the stored catch, and no others.

    Nothing is searched or verified.  "Caught" rests on the proof of the cell, which was made for
    all of its situations at once.
    """

    covers: tuple[Cover, ...]
    name: str = NAME

    def takes(self, kind: Kind) -> bool:
        """Return whether a cover is for arms of a kind."""
        return any(kind_of(cover.family.middle) == kind for cover in self.covers)

    def plan(self, situation: AnySituation) -> Plan:
        """Answer a situation."""
        started = time.perf_counter()
        why = "no family has this situation"
        for cover in self.covers:
            theta = cover.family.parameters_of(situation)
            if theta is None:
                why = _fixed(cover, situation) or why
                continue
            cell = cover.find(theta.tolist())
            if cell is not None and cell.held >= 0:
                return self._caught(situation, cover, cell.held, theta, started)
            why = _why(cover, cell, theta)
        return Plan(
            name=situation.name,
            planner=self.name,
            status="unreachable",
            message=f"not covered: {why}",
            planning_ms=1e3 * (time.perf_counter() - started),
            failure=Failure.NO_MEMORY,
            format=situation.format,
        )

    def _caught(
        self, situation: AnySituation, cover: Cover, held: int, theta: np.ndarray, started: float
    ) -> Plan:
        """Return the plan of a stored catch."""
        catch = cover.catches[held]
        movement = catch.movement(cover.family, theta)
        body = situation.bodies[catch.body].name
        when, until = (movement.duration, None) if catch.span is None else catch.span
        return ProvenPlan.of(
            situation,
            catch,
            planner=self.name,
            message=f"caught {body!r} at {when:.3f} s",
            planning_ms=1e3 * (time.perf_counter() - started),
            catch_time=when,
            held_until=until,
            catch_body=body,
            trajectory=movement,
        )


def _fixed(cover: Cover, situation: AnySituation) -> str:
    """Return which parameter differs from the value that a cover is for; empty for others."""
    if cover.family.name not in FAMILIES:
        return ""
    whole, free = FAMILIES[cover.family.name](), len(cover.family.parameters)
    theta = whole.parameters_of(situation)
    if theta is None:
        return ""
    rest = zip(whole.parameters[free:], theta[free:].tolist(), whole.centre[free:], strict=True)
    for parameter, value, middle in rest:
        if abs(value - middle) > SAME:
            held = f"the cover holds for {middle:g} {parameter.unit} only"
            return f"{parameter.name} = {value:g}, and {held}"
    return ""


def _why(cover: Cover, cell: Cell | None, theta: np.ndarray) -> str:
    """Return why parameters of a family are not covered."""
    if cell is not None:
        return cell.reason if cell.held == CLOSED else "the cell was not examined"
    for parameter, value in zip(cover.family.parameters, theta.tolist(), strict=True):
        if not parameter.low <= value <= parameter.high:
            reach = f"{parameter.low:g} to {parameter.high:g}"
            return f"{parameter.name} = {value:g} is outside of {reach} {parameter.unit}"
    return "outside of the box"


def with_cover(folder: Path) -> CoveredPlanner:
    """Return the planner with the cover of a folder.

    Raises
    ------
    CoverError
    """
    return as_ours(CoveredPlanner((load_cover(folder),)))


@lru_cache(maxsize=1)
def covered() -> CoveredPlanner:
    """Make the planner with all covers among the models.

    Raises
    ------
    CoverError
        One line that says how to make one.
    """
    folders: Any = artifacts.models(MANIFEST)
    if not folders:
        make = f"gcm-learn cover belt --out {artifacts.own('models') / 'cover-belt'}"
        raise CoverError(f"planner {NAME!r}: {artifacts.missing('models', 'cover', make)}")
    return CoveredPlanner(tuple(load_cover(folder) for folder in folders.values()))
