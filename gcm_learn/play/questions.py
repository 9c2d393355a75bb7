"""Questions of the page: parsed, checked, and free of paths and names of code."""

from __future__ import annotations

import math
from typing import Any

from gcm_learn.arms import Arm
from gcm_learn.errors import FieldError, SituationError, UnknownNameError
from gcm_learn.families import PAPER_SCENES, draw, family_names, gate_scene
from gcm_learn.recall import has_memory
from gcm_learn.situation import JsonTextError, Situation, parse, situation_from_json

FORMAT = "gcm-learn/situation@1"
PLANNERS = ("search", "gcm", "marching", "straight", "straight-wait", "potential")
FROM_MEMORY = ("recall", "hybrid")
"""Planners that need the shipped memory."""
MOST_PLANNERS, MOST_INSTANTS = 2, 16  # in one question
MOST_BODIES = 40
LAST_INDEX = 10**9  # of a family
SCENES = {"opening-gate": gate_scene, **PAPER_SCENES}
"""Scenes without random numbers, of which the planar ones are offered."""


class QuestionError(FieldError):
    """A question to the engine is malformed."""


def planners() -> list[str]:
    """Return the names of the planners that the page offers."""
    return [*PLANNERS, *(FROM_MEMORY if has_memory() else ())]


def scenes() -> dict[str, Situation]:
    """Return the scenes that the page can show, by name."""
    made = {name: scene() for name, scene in SCENES.items()}
    return {name: scene for name, scene in made.items() if scene.plane is None}


def families() -> list[str]:
    """Return the names of the families that draw planar bodies for planar arms."""
    return [name for name in family_names("planar") if _shown(draw(name, 0, 0))]


def situation_of(question: dict[str, Any]) -> Situation:
    """Return the situation of a question.

    Raises
    ------
    SituationError
        With the engine's own sentence, for a situation that is impossible or not planar.
    """
    given = question.get("situation")
    if isinstance(given, dict) and given.get("format", FORMAT) != FORMAT:
        raise SituationError("format", f"this page shows {FORMAT} only")
    return shown(situation_from_json(given))


def shown(situation: Any) -> Situation:
    """Return the situation, after checking that the page can show it.

    Raises
    ------
    SituationError
    """
    if not _shown(situation):
        raise SituationError("bodies", "this page shows planar arms among planar bodies only")
    if len(situation.bodies) > MOST_BODIES:
        raise SituationError("bodies", f"this page shows at most {MOST_BODIES} bodies")
    return situation  # type: ignore[no-any-return]


def _shown(situation: Any) -> bool:
    return isinstance(situation.arm, Arm) and situation.plane is None


def text_of(question: dict[str, Any]) -> Situation:
    """Return the situation in a file's text: one object, or the first line of several.

    Raises
    ------
    QuestionError, SituationError
    """
    text = question.get("text")
    if not isinstance(text, str):
        raise QuestionError("text", "must be a string")
    try:
        found = _first_object(text)
    except JsonTextError as error:
        raise QuestionError(f"line {error.line}", f"not valid JSON: {error.reason}") from None
    if isinstance(found, dict) and isinstance(found.get("situation"), dict):
        found = found["situation"]  # a line of a suite
    return situation_of({"situation": found})


def _first_object(text: str) -> object:
    """Return the JSON value of a text, or of its first line if more lines follow."""
    try:
        return parse(text)
    except JsonTextError:
        lines = [line for line in text.splitlines() if line.strip()]
        if len(lines) < 2 or not lines[0].rstrip().endswith("}"):
            raise
        return parse(lines[0])


def planners_of(question: dict[str, Any]) -> list[str]:
    """Return the planners named in a question; refuse names that the page does not offer."""
    names = question.get("planners", [PLANNERS[0]])
    if not isinstance(names, list) or not 1 <= len(names) <= MOST_PLANNERS:
        raise QuestionError("planners", f"must be a list of 1 to {MOST_PLANNERS} names")
    for name in names:
        if name not in PLANNERS:  # the memory is looked for only when it is asked
            known(name, planners(), "planner")
    return names


def known(name: object, names: list[str], what: str) -> str:
    """Return a name that is offered; refuse others."""
    if not isinstance(name, str) or name not in names:
        raise UnknownNameError.among(what, name, names)
    return name


def instants_of(question: dict[str, Any]) -> list[float]:
    """Return the instants for which a question wants extended obstacles [s]."""
    times = question.get("instants", [])
    if not isinstance(times, list) or len(times) > MOST_INSTANTS:
        raise QuestionError("instants", f"must be a list of at most {MOST_INSTANTS} numbers")
    return [_number(t, "instants") for t in times]


def deadline_of(question: dict[str, Any]) -> float | None:
    """Return the processor time that each planner may take [s], or None."""
    given = question.get("deadline")
    return None if given is None else _number(given, "deadline")


def index_of(question: dict[str, Any]) -> int:
    """Return the index of a draw from a family."""
    index = question.get("index", 0)
    if type(index) is not int or not 0 <= index <= LAST_INDEX:
        raise QuestionError("index", f"must be an integer from 0 to {LAST_INDEX}")
    return index


def _number(value: object, field: str) -> float:
    if type(value) not in (int, float) or not math.isfinite(float(value)) or float(value) < 0.0:  # type: ignore[arg-type]
        raise QuestionError(field, "must be a number from 0 on")
    return float(value)  # type: ignore[arg-type]
