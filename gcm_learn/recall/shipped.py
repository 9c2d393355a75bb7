"""The memories behind planners that are asked for by name."""

from __future__ import annotations

import os
from pathlib import Path

from gcm_learn.errors import RecallError
from gcm_learn.recall.disk import MANIFEST
from gcm_learn.recall.index import index_class
from gcm_learn.recall.store import Memory

VARIABLE = "GCM_LEARN_MODELS"
"""Environment variable with the folder of models; by default that of the repository."""
_REFILED = {"recall-raw": "raw", "recall-pca": "pca", "recall-random": "random"}


def models_folder() -> Path:
    """Where models are kept."""
    return Path(os.environ.get(VARIABLE) or Path(__file__).parents[2] / "models")


def shipped_memory(name: str) -> Memory:
    """The memory of a planner's name, e.g. ``recall``.

    Controls that have none of their own file that of ``recall`` anew, by their own index.

    Raises
    ------
    RecallError
        One line that says how to make one.
    """
    folder = models_folder()
    if (folder / name / MANIFEST).exists():
        return Memory.load(folder / name)
    whole = folder / "recall"
    if not (whole / MANIFEST).exists():
        raise RecallError(
            f"planner {name!r}: no memory in {folder / name}; make one with "
            f"'gcm-learn remember DATASET --out {folder / name}' or set {VARIABLE}"
        )
    memory = Memory.load(whole)
    if name not in _REFILED:
        return memory
    kind = index_class(_REFILED[name])
    return memory.refiled(kind.fit(memory.situations(), 0))
