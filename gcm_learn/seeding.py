"""The only place where an integer becomes a random generator."""

from __future__ import annotations

import numpy as np


def rng(seed: int, *index: int) -> np.random.Generator:
    """Return the generator of item `index` under `seed`.

    Streams of different indices are independent, and item ``(seed, 7)`` is the same whether
    it is drawn alone, first or last.

    Parameters
    ----------
    seed : int
        Non-negative root seed.
    *index : int
        Non-negative position of the item, e.g. family number and item number.
    """
    return np.random.default_rng(np.random.SeedSequence(entropy=seed, spawn_key=index))
