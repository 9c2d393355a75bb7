"""Answers of the engine to the page, pictures included: a function of a question."""

from __future__ import annotations

import base64
import json
import math
import time
from collections.abc import Callable
from importlib.resources import files
from typing import Any

import numpy as np

from gcm_learn import families
from gcm_learn.charts import Lattice, occupied_cells
from gcm_learn.errors import GcmError
from gcm_learn.maps import CognitiveMap, build_map
from gcm_learn.planners import Bounds, Plan, bounds, get_planner, plan_to_json, plan_with, stratum
from gcm_learn.play import questions
from gcm_learn.situation import Situation, situation_to_json
from gcm_learn.wave import MarchingParams

SIZE = 120  # cells a side of extended obstacles
LEVELS = 250  # of arrival times, from 0 to the last one
OBSTACLE, TARGET, NEVER = 253, 254, 255  # instead of an arrival


def map_picture(cognitive_map: CognitiveMap) -> dict[str, Any]:
    """Return a map as a picture.

    Returns
    -------
    dict
        `size` (cells a side), `last` (the time of level `LEVELS` [s]) and `cells`: a byte for each
        cell, row by row from below. A byte is a level of arrival, or one of the marks above it.
    """
    arrival = cognitive_map.arrival.filled(np.inf)
    reached = np.isfinite(arrival)
    last = float(arrival[reached].max(initial=0.0)) or 1.0
    cells = np.full(arrival.shape, NEVER, dtype=np.uint8)
    cells[reached] = np.rint(LEVELS / last * arrival[reached])
    cells[cognitive_map.effective_obstacles & ~reached] = OBSTACLE
    cells[cognitive_map.effective_target & ~reached] = TARGET
    return {"size": len(cells), "last": last, "cells": _text(cells)}


def extended_pictures(situation: Situation, instants: list[float]) -> list[dict[str, Any]]:
    """Return the hand positions that obstacles forbid, one picture for each instant.

    Returns
    -------
    list of dict
        `time` [s], `size` and `cells`: a bit for each cell, row by row from below, the first cell
        in the highest bit.
    """
    lattice = Lattice(SIZE, situation.arm.upper_arm, situation.arm.elbow)
    return [
        {
            "time": t,
            "size": SIZE,
            "cells": _text(np.packbits(occupied_cells(situation, lattice, t))),
        }
        for t in instants
    ]


def _text(cells: np.ndarray) -> str:
    return base64.b64encode(cells.tobytes()).decode("ascii")


FIRST_ARRIVAL = ("gcm", "marching", "straight", "potential")
"""Planners of which the hand never waits, so that their maps have one arrival a cell."""
DIGITS = 5  # of hands and times on the page

Values = dict[str, Any]


def respond(kind: str, question: Values) -> Values:
    """Answer a question of the page.

    Parameters
    ----------
    kind : str
        A key of `ANSWERS`.
    question : dict
        As parsed from JSON.

    Returns
    -------
    dict
        Plain values for JSON. A refusal has only `error`, the engine's sentence in one line.
    """
    try:
        return ANSWERS[kind](question)
    except (GcmError, RecursionError) as error:
        return {"error": _line(error)}


def _line(error: BaseException) -> str:
    """Return an error's message as one line."""
    return " ".join(str(error).split())


def begin(question: Values) -> Values:
    """Return the names of planners, scenes and families that the page offers."""
    return {
        "planners": questions.planners(),
        "scenes": list(questions.scenes()),
        "families": questions.families(),
    }


def read(question: Values) -> Values:
    """Return the situation of a file's text, with the formats' defaults filled in."""
    return {"situation": situation_to_json(questions.text_of(question))}


def example() -> Values:
    """Return the situation with which the page begins."""
    text = files(__package__).joinpath("pages", "start.json").read_text("utf-8")
    found: Values = json.loads(text)
    return found


def draw(question: Values) -> Values:
    """Return a scene by name, or a situation of a family by name and index."""
    scenes, name = questions.scenes(), question.get("name")
    if isinstance(name, str) and name in scenes:
        return {"situation": situation_to_json(scenes[name])}
    family = questions.known(name, [*scenes, *questions.families()], "family")
    drawn = families.draw(family, 0, questions.index_of(question))
    return {"situation": situation_to_json(drawn)}


def extend(question: Values) -> Values:
    """Return extended obstacles at some instants."""
    situation = questions.situation_of(question)
    return {"extended": extended_pictures(situation, questions.instants_of(question))}


def answer(question: Values) -> Values:
    """Return plans, maps and extended obstacles of a situation, and the time of each part [ms]."""
    watch = _Watch()
    situation = questions.situation_of(question)
    names, instants = questions.planners_of(question), questions.instants_of(question)
    deadline, shows_map = questions.deadline_of(question), bool(question.get("map", True))
    watch.lap("read")
    plans: list[Values] = []
    for name in names:
        plan = _plan(name, situation, deadline)
        found = plan_to_json(plan, situation) if isinstance(plan, Plan) else plan
        plans.append(_short(found))
        watch.lap(f"plan {name}")
        if shows_map and isinstance(plan, Plan) and plan.status != "start_blocked":
            plans[-1]["map"] = map_picture(_map(plan, name, situation))
            watch.lap(f"map {name}")
    extended = extended_pictures(situation, instants)
    watch.lap("obstacles")
    return {"plans": plans, "extended": extended, "parts_ms": watch.parts}


def _plan(name: str, situation: Situation, deadline: float | None) -> Plan | Values:
    """Return a plan, or the error of this planner alone."""
    try:
        planner = get_planner(name)
        limit = deadline if getattr(planner, "anytime", False) else None
        return plan_with(planner, situation, limit)
    except GcmError as error:
        return {"planner": name, "status": "error", "message": _line(error)}


def _map(plan: Plan, name: str, situation: Situation) -> CognitiveMap:
    """Return a plan's map, or a map by marching, without waits if `name` is in `FIRST_ARRIVAL`."""
    if plan.map is not None:
        return plan.map
    return build_map(situation, MarchingParams(), wait=name not in FIRST_ARRIVAL)


def _short(solution: Values) -> Values:
    """Return a solution with the hand's path only, in as many digits as a picture needs."""
    moves = solution.pop("trajectory", None)
    if moves is not None:
        path = {name: np.round(moves[name], DIGITS).tolist() for name in ("time", "hand")}
        solution["trajectory"] = path
    return solution


class _Watch:
    """Wall time of the parts of an answer."""

    def __init__(self) -> None:
        self.parts: dict[str, float] = {}
        self._last = time.perf_counter()

    def lap(self, name: str) -> None:
        """Record the time [ms] since the last call as the time of part `name`."""
        now = time.perf_counter()
        self.parts[name] = round(1e3 * (now - self._last), 2)
        self._last = now


def explain(question: Values) -> Values:
    """Return the stratum of a situation, and the sentences that give the reasons for it."""
    situation = questions.situation_of(question)
    straight = plan_with(get_planner("straight"), situation)
    if straight.caught:
        return _explained("L", [f"A straight line catches at {straight.catch_time:.3f} s."])
    known = bounds(situation)
    found = stratum(situation, known)
    missed = straight.message.rstrip(".")
    return _explained(found, [f"A straight line does not catch: {missed}.", *_why(found, known)])


def _explained(found: str, reasons: list[str]) -> Values:
    return {"stratum": found, "reasons": reasons}


def _why(found: str, known: Bounds) -> list[str]:
    """Return sentences on the bounds of a situation."""
    if found == "U":
        certain = "No movement can catch" if known.decided else "No catch was found"
        return [f"{certain} within the horizon."]
    round_it, queue = (
        "A hand that goes round without a wait catches.",
        "Only a hand that waits was found to catch.",
    )
    reasons = [round_it if found == "W" else queue]
    if math.isfinite(known.upper):
        reasons.append(
            f"The earliest catch is between {known.lower:.3f} s and {known.upper:.3f} s."
        )
    return reasons


ANSWERS: dict[str, Callable[[Values], Values]] = {
    "begin": begin,
    "read": read,
    "draw": draw,
    "extend": extend,
    "answer": answer,
    "explain": explain,
}
"""Kinds of questions."""
