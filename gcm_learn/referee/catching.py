"""The list of catches: names, times, order, and how long each fills the hand."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from gcm_learn.referee.form import is_number
from gcm_learn.referee.rotations import Array
from gcm_learn.referee.tolerances import AFTERWARDS, MOMENT, Complaint

LATER = {"hold": "held_until", "place": "placed"}
"""Times that an entry has if its target has a field."""


class Catch(NamedTuple):
    """Catch of a target: its name, and the times of catch, end of hold and placing."""

    body: str
    time: float
    held_until: float | None = None
    placed: float | None = None

    @property
    def times(self) -> list[float]:
        """Instants that must be samples."""
        return [t for t in self[1:] if t is not None]

    @property
    def free(self) -> float:
        """Instant from which on the hand is free again."""
        return self.times[-1]


def catches_of(
    solution: Mapping[str, Any], situation: Mapping[str, Any]
) -> tuple[list[Catch], list[Complaint]]:
    """Return the catches that a solution names, and complaints about their form."""
    last = (solution["catch_body"], solution["catch_time"])
    if not isinstance(last[0], str):
        return [], [Complaint("catch_body", "is not a name")]
    if not is_number(last[1]):
        return [], [Complaint("catch_time", "is not a finite number")]
    if "catches" not in solution:
        return [Catch(*last)], []
    given = solution["catches"]
    if not isinstance(given, list) or not given:
        return [], [Complaint("catches", "is not a list of at least one catch")]
    bodies = {body["name"]: body for body in situation["bodies"]}
    for entry in given:
        what = _entry(entry, bodies)
        if what:
            return [], [Complaint("catches", f"has an entry {what}")]
    catches = [Catch(**entry) for entry in given]
    tests = (("catch_body", last[0], catches[-1].body), ("catch_time", last[1], catches[-1].time))
    odd = [Complaint(name, "is not the last catch's") for name, mine, its in tests if mine != its]
    return catches, odd


def _entry(entry: Any, bodies: Mapping[str, Any]) -> str:
    """Return a complaint about the form of an entry; empty if the form is right."""
    if not isinstance(entry, Mapping) or not {"body", "time"} <= set(entry):
        return "that is not body and time"
    if not isinstance(entry["body"], str):
        return "without a name or a finite time"
    asked = bodies.get(entry["body"], {})
    later = {name for field, name in LATER.items() if field in asked}
    if set(entry) != {"body", "time", *later}:
        return f"that is not {', '.join(['body', 'time', *sorted(later)])}"
    times = all(is_number(entry[name]) for name in entry if name != "body")
    return "" if times else "without a name or a finite time"


def sampled(catches: list[Catch], time: Array, slack: float) -> list[Catch] | None:
    """Return the catches at the samples nearest to their times; None if a time is far from all."""
    found = []
    for catch in catches:
        near = [time[np.abs(time - t).argmin()] for t in catch.times]
        if any(abs(s - t) > slack for s, t in zip(near, catch.times, strict=True)):
            return None
        snapped = iter(near)
        times = [None if t is None else float(next(snapped)) for t in catch[1:]]
        found.append(Catch(catch.body, *times))  # type: ignore[arg-type]
    return found


def catch_complaints(
    situation: Mapping[str, Any], given: list[Catch], time: Array, version: int
) -> tuple[list[Catch], list[Complaint]]:
    """Return catches at samples, and complaints about names, times, order and number."""
    targets = {body["name"]: body for body in situation["bodies"] if body["role"] == "target"}
    unknown = [catch for catch in given if catch.body not in targets]
    if unknown:
        return [], [Complaint("catch_body", f"{c.body} is not a target", c.time) for c in unknown]
    catches = sampled(given, time, MOMENT if version > 3 else 0.0)
    names, asked = list(targets), situation.get("catch", "any")
    order = [(catch.time, names.index(catch.body)) for catch in catches or given]
    count = {"any": 1, "all": len(targets)}.get(asked, len(given))
    tests = (
        (len({catch.body for catch in given}) == len(given), "catch a target twice"),
        (order == sorted(order), "are not in order of time"),
        (catches is not None, "are not all at samples"),
        (len(given) == count, f"are {len(given)}, asked for: {asked}"),
        (all(_held(catch, targets) for catch in given), "are not held as long as is asked"),
        (all(c.free >= max(c.times) for c in given), "are placed before their hold has ended"),
        (not _full(catches or []), "come while the hand is full"),
    )
    complaints = [Complaint("catches", what) for kept, what in tests if not kept]
    return catches or [], complaints + _ends(situation, catches or given, float(time[-1]), version)


def _held(catch: Catch, targets: Mapping[str, Any]) -> bool:
    hold = targets[catch.body].get("hold")
    return hold is None or abs(catch.times[1] - catch.time - hold["seconds"]) <= 2.0 * MOMENT


def _full(catches: list[Catch]) -> bool:
    """Tell if a catch comes while another target fills the hand.

    At the very instant of another's catch it counts as before it, unless both last.
    """
    return any(
        one.time < other.time < one.free
        or (one.time == other.time and one.time < one.free and other.time < other.free)
        for one in catches
        for other in catches
        if one is not other
    )


def _ends(
    situation: Mapping[str, Any], catches: list[Catch], end: float, version: int
) -> list[Complaint]:
    """Return complaints about the end of the trajectory, and about the horizon."""
    horizon, last = situation["horizon"], max(catch.free for catch in catches)
    share = 1.0 + MOMENT if version > 3 else 1.0
    close = MOMENT if version > 3 else 0.0
    complaints = []
    if situation.get("end", "free") == "free" and abs(end - last) > close:
        what = f"is not the end of the trajectory, {end:.9g} s"
        complaints.append(Complaint("catch_time", what, last))
    if max(catch.time for catch in catches) > horizon * share:
        complaints.append(Complaint("catch_time", f"is after the horizon, {horizon:g} s", last))
    for limit in (horizon + AFTERWARDS, situation.get("end_by", math.inf)):
        if end > limit * share:
            complaints.append(Complaint("trajectory.time", f"goes on after {limit:.9g} s", end))
    return complaints
