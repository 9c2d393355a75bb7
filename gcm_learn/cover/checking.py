"""Draws from proven cells, verified one by one."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from gcm_learn import seeding
from gcm_learn.cover.catches import StoredCatch
from gcm_learn.cover.cover import Cover
from gcm_learn.motion import rules_of, verify
from gcm_learn.scene import pack


def draws(
    cover: Cover, count: int, seed: int, first: int = 0
) -> Iterator[tuple[np.ndarray, StoredCatch]]:
    """Draw parameters (K,) evenly over what is covered, each with its stored catch.

    Draw k depends on the seed and k only; `first` is the first of them.
    """
    held = [cell for cell in cover.leaves() if cell.held >= 0]
    sizes = np.cumsum([cover.size(cell) for cell in held])
    for k in range(first, first + count if held else first):
        rng = seeding.rng(seed, k)
        cell = held[int(np.searchsorted(sizes, rng.random() * sizes[-1], side="right"))]
        yield rng.uniform(cell.low, cell.high), cover.catches[cell.held]


def broken_of(
    cover: Cover,
    count: int,
    seed: int,
    progress: Callable[[], None] = lambda: None,
    first: int = 0,
) -> tuple[int, int]:
    """Verify draws from proven cells; return how many break a promise, and how many there are."""
    broken = drawn = 0
    for theta, catch in draws(cover, count, seed, first):
        scene = pack(cover.family.situation(theta))
        movement = catch.movement(cover.family, theta)
        broken += not verify(scene, rules_of(scene), movement, catch.body).good
        drawn += 1
        progress()
    return broken, drawn
