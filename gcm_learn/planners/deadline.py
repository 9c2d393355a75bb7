"""Until when a planner may think."""

from __future__ import annotations

import time
from collections.abc import Callable

GAIN = 0.01
"""Share of the horizon by which a catch must be earlier to be looked for."""


class Deadline:
    """A time by which an answer is wanted, counted from now.

    By default it is processor time, as thinking is charged everywhere here: on an idle core that is
    the time on the wall, on a busy one others' work is not counted. Searches look at it about once
    in a millisecond.

    Parameters
    ----------
    seconds : float
        From 0 on; 0 asks for what can be said at once.
    clock : callable
        Tells the time [s], e.g. `time.perf_counter` for that on the wall.
    """

    def __init__(self, seconds: float, clock: Callable[[], float] = time.process_time) -> None:
        if not seconds >= 0.0:
            raise ValueError(f"deadline: must be from 0 on (got {seconds!r})")
        self._clock, self._end = clock, clock() + seconds

    @property
    def over(self) -> bool:
        """Whether it is too late."""
        return self._clock() >= self._end


def deadline_of(given: float | Deadline | None) -> Deadline | None:
    """A deadline that many seconds from now; one that runs already is kept, as is none."""
    return Deadline(given) if isinstance(given, (int, float)) else given
