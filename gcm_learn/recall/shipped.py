"""The memories behind planners that are asked for by name."""

from __future__ import annotations

from gcm_learn import artifacts
from gcm_learn.errors import RecallError
from gcm_learn.recall.disk import MANIFEST
from gcm_learn.recall.index import index_class
from gcm_learn.recall.store import Memory

_REFILED = {"recall-raw": "raw", "recall-pca": "pca", "recall-random": "random"}


WHOLE = "recall"


def has_memory() -> bool:
    """Whether there is a memory that planners can ask."""
    return artifacts.model(WHOLE, MANIFEST) is not None


def shipped_memory(name: str) -> Memory:
    """The memory of a planner's name, e.g. ``recall``.

    Controls that have none of their own file that of ``recall`` anew, by their own index.

    Raises
    ------
    RecallError
        One line that says how to make one.
    """
    folder = artifacts.model(name, MANIFEST) or artifacts.model(WHOLE, MANIFEST)
    if folder is None:
        make = f"gcm-learn remember DATASET --out {artifacts.own('models') / name}"
        reason = artifacts.missing("models", f"memory {name!r}", make)
        raise RecallError(f"planner {name!r}: {reason}")
    memory = Memory.load(folder)
    if folder.name == name or name not in _REFILED:
        return memory
    kind = index_class(_REFILED[name])
    return memory.refiled(kind.fit(memory.situations(), 0))
