"""What the demo's last parts run, compiled by another process while the first ones are made."""

from __future__ import annotations

import contextlib
from collections.abc import Sequence
from multiprocessing.context import SpawnProcess

from gcm_learn.evaluation import entrants_of, warmed
from gcm_learn.processes import Context, cores


def compile_ahead(names: Sequence[str]) -> SpawnProcess | None:
    """Start compiling what methods run; join the process before they are needed.

    None if there are no names, or a single core, where a second process would only be in the way.
    """
    if not names or cores() < 2:
        return None
    process = Context().Process(target=_compile, args=(tuple(names),), daemon=True)
    process.start()
    return process


def _compile(names: Sequence[str]) -> None:
    """Let methods answer once; what goes wrong here is said by whoever needs them."""
    for entrant in entrants_of(names):
        with contextlib.suppress(Exception):
            warmed(entrant)
