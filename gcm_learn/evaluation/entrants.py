"""Entrants of a comparison, each under a name of its own, and their calls, shared out."""

from __future__ import annotations

import pickle
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from gcm_learn.errors import SuiteError
from gcm_learn.evaluation.methods import Method, get_method
from gcm_learn.planners import LIMIT, absolute, in_words, name_of
from gcm_learn.processes import cores, crew_of


@dataclass(frozen=True, eq=False)
class Held:
    """An object that stays in this process; equal to itself only."""

    given: Any


@dataclass(frozen=True)
class Entrant:
    """A method of a comparison, as it is sent to processes."""

    name: str
    """Name of its rows."""
    source: str | bytes | Held
    """A name or a reference, a pickled object, or an object of this process."""
    limit: float | None = LIMIT
    """Time on the wall for each answer of a method from outside [s]."""

    def method(self) -> Method:
        """Return the method.

        Raises
        ------
        SuiteError
            If an object cannot be unpickled here.
        """
        source: Any = self.source
        if isinstance(source, Held):
            source = source.given
        elif isinstance(source, bytes):
            try:
                source = pickle.loads(source)
            except Exception as error:
                raise SuiteError(_stays(self.name, in_words(error))) from None
        return get_method(source, self.name, self.limit)


def entrants_of(
    given: Sequence[str | Any], limit: float | None = LIMIT, *, alone: bool = True
) -> list[Entrant]:
    """Return entrants with distinct names.

    Parameters
    ----------
    given : sequence of str or object
        See `get_method`.
    limit : float, optional
        Time on the wall for each answer of a method from outside [s].
    alone : bool
        If false, other processes do the work, and objects have to be pickled.

    Raises
    ------
    SuiteError
        If an object cannot be sent to other processes.
    """
    made: list[Entrant] = []
    for item in given:
        name = _distinct(item if isinstance(item, str) else name_of(item), made)
        made.append(Entrant(name, _source(item, name, alone), limit))
    return made


def _distinct(name: str, made: Sequence[Entrant]) -> str:
    """Return a name that no entrant has: with a number if it is taken."""
    taken, found, count = {entrant.name for entrant in made}, name, 1
    while found in taken:
        count += 1
        found = f"{name} ({count})"
    return found


def _source(item: Any, name: str, alone: bool) -> str | bytes | Held:
    if isinstance(item, str):
        return absolute(item)
    if alone:
        return Held(item)
    home = item if isinstance(item, type) else type(item)
    typed_in = getattr(item, "__module__", home.__module__) == "__main__"
    if typed_in and not hasattr(sys.modules["__main__"], "__file__"):
        raise SuiteError(_stays(name, "it was defined in an interactive session"))
    try:
        return pickle.dumps(item)
    except Exception as error:
        raise SuiteError(_stays(name, in_words(error))) from None


def _stays(name: str, why: str) -> str:
    return (
        f"{name!r} cannot be sent to worker processes ({why}): "
        "give it as path.py:name, or ask for one worker"
    )


Rows = list[dict[str, Any]]


def is_alone(calls: int, workers: int | None, cluster: str | None) -> bool:
    """Return whether this process does all calls itself."""
    return cluster is None and min(workers or cores(), calls) <= 1


def rows_of(
    calls: Sequence[Callable[[], Rows]],
    workers: int | None,
    cluster: str | None,
    progress: Callable[[int], object],
) -> Rows:
    """Rows of all calls, in their order.

    Parameters
    ----------
    calls : sequence of callable
        Each makes a row for each of some situations; whoever does it gets it pickled.
    workers, cluster
        See `processes.crew_of`.
    progress : callable
        Told how many rows are new.
    """
    rows: Rows = []
    with crew_of(min(workers or cores(), len(calls)) or 1, cluster) as crew:
        for new in crew.map(_called, calls):
            rows += new
            progress(len(new))
    return rows


def _called(call: Callable[[], Rows]) -> Rows:
    return call()
