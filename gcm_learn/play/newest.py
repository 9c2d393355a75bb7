"""One worker for dear questions: the newest of each kind wins, older ones are dropped."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any

from gcm_learn.planners import in_words

Values = dict[str, Any]
DROPPED: Values = {"dropped": True}
"""Answer to a question after which a newer one came."""


class _Waiting:
    """A question that waits for the worker."""

    def __init__(self, kind: str, question: Values) -> None:
        self.kind, self.question = kind, question
        self.answer = DROPPED
        self.done = threading.Event()


class Newest:
    """Answers questions one after the other, in a thread of its own.

    Parameters
    ----------
    respond : callable
        Takes kind and question, returns the answer; it is never called by two threads at once.
    """

    def __init__(self, respond: Callable[[str, Values], Values]) -> None:
        self._respond = respond
        self._waiting: dict[tuple[str, str], _Waiting] = {}
        self._changed = threading.Condition()
        threading.Thread(target=self._work, name="engine", daemon=True).start()

    def ask(self, kind: str, question: Values, page: str = "") -> Values:
        """Return the answer to a question, or `DROPPED` if a newer one of its kind came before.

        Parameters
        ----------
        kind : str
        question : dict
        page : str
            Questions of different pages never replace each other.
        """
        asked = _Waiting(kind, question)
        with self._changed:
            older = self._waiting.pop((page, kind), None)
            self._waiting[page, kind] = asked
            self._changed.notify()
        if older is not None:
            older.done.set()
        asked.done.wait()
        return asked.answer

    def _work(self) -> None:
        while True:
            with self._changed:
                while not self._waiting:
                    self._changed.wait()
                asked = self._waiting.pop(next(iter(self._waiting)))
            try:
                asked.answer = self._respond(asked.kind, asked.question)
            except Exception as error:  # the page goes on, and shows what happened
                asked.answer = {"error": f"unexpected error: {in_words(error)}"}
            asked.done.set()
