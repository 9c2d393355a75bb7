"""A function over tasks, wherever it is done; what comes out does not depend on where."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Iterator
from types import TracebackType
from typing import Self, TypeVar

STRIKES = 3  # times that a task may be under way when its process dies, before it is done alone
Task = TypeVar("Task")
Result = TypeVar("Result")


class Crew(ABC):
    """Workers that live as long as their ``with`` block.

    Leaving it by an error, e.g. by Ctrl-C, ends what they are at.
    """

    @abstractmethod
    def results(
        self,
        work: Callable[[Task], Result],
        tasks: Iterable[Task],
        alone: Callable[[Task], Result] | None = None,
    ) -> Iterator[tuple[int, Result]]:
        """Do tasks; results come as they are ready, each with the number of its task.

        Parameters
        ----------
        work : callable
            ``work(task)``, a pure function at the top level of a module, so that others find it.
        tasks : iterable
            Taken as there is somebody to do them.
        alone : callable, optional
            ``alone(task)``, run in this process for tasks that `STRIKES` times could not be ended;
            by default `work`.
        """

    def map(
        self,
        work: Callable[[Task], Result],
        tasks: Iterable[Task],
        alone: Callable[[Task], Result] | None = None,
    ) -> Iterator[Result]:
        """Do tasks as `results` does; what comes of them comes in their order."""
        early: dict[int, Result] = {}
        wanted = 0
        for number, result in self.results(work, tasks, alone):
            early[number] = result
            while wanted in early:
                yield early.pop(wanted)
                wanted += 1

    def __enter__(self) -> Self:
        return self

    @abstractmethod
    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Let everybody go."""


class Here(Crew):
    """Crew of the present process alone."""

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        pass

    def results(
        self,
        work: Callable[[Task], Result],
        tasks: Iterable[Task],
        alone: Callable[[Task], Result] | None = None,
    ) -> Iterator[tuple[int, Result]]:
        """Do tasks one after the other."""
        for number, task in enumerate(tasks):
            yield number, work(task)
