"""Growth of a cover: examine the largest cells, keep the proven, cut the others; checks."""

from __future__ import annotations

import heapq
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from gcm_learn import seeding
from gcm_learn.cover.catches import Doubt, StoredCatch, doubt_of, planned
from gcm_learn.cover.cover import CLOSED, OPEN, Cell, Cover
from gcm_learn.cover.families import ParametricFamily
from gcm_learn.cover.held import held_catch, held_doubt
from gcm_learn.processes import Crew
from gcm_learn.scene import Scene, pack

BATCH = 16
"""Cells that are examined before their results are used, whoever does it."""
NEIGHBOURS = 3
"""Stored catches that are tried before one is planned."""
SPARED = 2
"""Cuts that are left to be found by examination."""
SMALLEST = 1.0 / 64.0
"""Side of a cell, as a share of the box's, at which it is not cut any more."""
SAVED_EVERY = 20.0
"""Time between checkpoints [s]."""


class Question(NamedTuple):
    """A cell to be examined, and the stored catches that may hold in it."""

    family: ParametricFamily
    centre: np.ndarray
    half: np.ndarray
    known: list[tuple[int, StoredCatch]]


@dataclass(frozen=True)
class Finding:
    """Result of the examination of a cell."""

    held: int = OPEN
    """Index of a stored catch that holds in the cell; OPEN if none of the given ones does."""
    catch: StoredCatch | None = None
    """A catch that was planned for the middle; it holds in the cell if there is no doubt."""
    doubt: Doubt | None = None
    axes: tuple[int, ...] = ()
    """Parameters along which the cell is to be cut, one after the other; empty to give it up."""


def examine(question: Question) -> Finding:
    """Look for a catch that provably holds in a cell: try stored catches, then plan a new one."""
    family, centre, half, known = question
    if family.holds:
        return _examine_held(question)
    scene = pack(family.situation(centre))
    for index, catch in known:
        if doubt_of(family, catch, centre, half, scene) is None:
            return Finding(index)
    catches, reason = planned(family, centre)
    doubts = []
    for catch in catches:
        doubt = doubt_of(family, catch, centre, half, scene)
        if doubt is None:
            return Finding(catch=catch)
        doubts.append(doubt)
    if catches:
        axes = _cuts(question, catches[0], doubts[0], scene)
        return Finding(catch=catches[0], doubt=doubts[0], axes=axes)
    drifts = family.drifts(np.linspace(0.0, family.middle.horizon, 5))
    moved = np.linalg.norm(drifts, axis=-1).max(axis=(0, 2))
    return Finding(doubt=(doubt := Doubt(reason, half * moved)), axes=_axis(family, half, doubt))


def _examine_held(question: Question) -> Finding:
    """Do the same for held catches, which are planned for the whole cell."""
    family, centre, half, known = question
    for index, catch in known:
        if held_doubt(family, catch, centre, half) is None:
            return Finding(index)
    found = held_catch(family, centre, half)
    if isinstance(found, StoredCatch):
        return Finding(catch=found)
    return Finding(doubt=found, axes=_axis(family, half, found))


def _cuts(question: Question, catch: StoredCatch, doubt: Doubt, scene: Scene) -> tuple[int, ...]:
    """Return the parameters along which to cut a cell, in order, before planning for its parts.

    Its sides are halved about the middle until the catch holds there. The last of these cuts are
    left to the parts, whose own catches may hold in more. There are at most as many cuts as
    parameters, since the catch says little of parts that are far from it.
    """
    family, centre, half = question.family, question.centre, question.half.copy()
    axes: list[int] = []
    left: Doubt | None = doubt
    most = len(half) + SPARED
    while left is not None and len(axes) < most and (axis := _axis(family, half, left)):
        axes.extend(axis)
        half[axis[0]] *= 0.5
        left = doubt_of(family, catch, centre, half, scene)
    return tuple(axes[: max(len(axes) - SPARED, 1)])


@dataclass(frozen=True)
class Budget:
    """Limits of growth, which ends when the first of them is reached."""

    share: float = 0.95
    """Share of the box that is to be covered."""
    minutes: float | None = None
    """Time on the wall, of this run [min]."""
    cells: int | None = None
    """Cells examined in all runs, in whole batches."""

    def spent(self, cover: Cover, seconds: float) -> bool:
        """Return whether growth ends, after some time of this run [s]."""
        over = self.minutes is not None and seconds >= 60.0 * self.minutes
        return over or (self.cells is not None and cover.examined >= self.cells)


def grow(
    cover: Cover,
    budget: Budget,
    crew: Crew,
    *,
    keep: Callable[[Cover], None] = lambda cover: None,
    progress: Callable[[float], None] = lambda share: None,
) -> None:
    """Examine cells, the largest first, until a share is covered or a budget is spent.

    The result depends on the number of cells only, not on who examines them or on interruptions.

    Parameters
    ----------
    cover : Cover
        Changed in place.
    budget : Budget
    crew : Crew
        Examines cells.
    keep : callable
        Called now and then, at the end and at an interruption, to save the cover.
    progress : callable
        Called with the share that is covered.
    """
    queue = [(-cover.size(c), k) for k, c in enumerate(cover.cells) if _waits(c)]
    heapq.heapify(queue)
    share, before = cover.share, cover.seconds
    started = saved = time.monotonic()
    while queue and share < budget.share and not budget.spent(cover, time.monotonic() - started):
        batch = [heapq.heappop(queue)[1] for _ in range(min(BATCH, len(queue)))]
        try:
            findings = list(crew.map(examine, [_question(cover, k) for k in batch]))
        except KeyboardInterrupt:
            keep(cover)
            raise
        for k, finding in zip(batch, findings, strict=True):
            share += _use(cover, k, finding, queue)
        now = time.monotonic()
        count = cover.examined + len(batch)
        cover.curve.append((count, len(cover.used), share, before + now - started))
        progress(share)
        if now - saved > SAVED_EVERY:
            keep(cover)
            saved = time.monotonic()
    keep(cover)


def _waits(cell: Cell) -> bool:
    return cell.axis < 0 and cell.held == OPEN


def _question(cover: Cover, k: int) -> Question:
    """Return the question for cell k: the catch of the cell it was cut from, and near catches."""
    cell, family = cover.cells[k], cover.family
    centre, half = 0.5 * (cell.low + cell.high), 0.5 * (cell.high - cell.low)
    near = _nearest(cover, centre)
    known = [cell.trial, *(index for index in near if index != cell.trial)]
    return Question(family, centre, half, [(i, cover.catches[i]) for i in known if i >= 0])


def _nearest(cover: Cover, centre: np.ndarray) -> list[int]:
    """Return the held catches that were planned nearest to a point of the box."""
    used = sorted(cover.used)
    if not used:
        return []
    anchors = np.array([cover.catches[index].anchor for index in used])
    sides = cover.family.high - cover.family.low
    far = np.abs((anchors - centre) / sides).max(axis=1)
    return [used[i] for i in np.argsort(far, kind="stable")[:NEIGHBOURS]]


def _use(cover: Cover, k: int, finding: Finding, queue: list[tuple[float, int]]) -> float:
    """Note the catch found for cell k, or cut or close the cell; return the share newly covered."""
    cell = cover.cells[k]
    index = finding.held
    if finding.catch is not None:
        index = len(cover.catches)
        cover.catches.append(finding.catch)
    if finding.doubt is None:
        cover.hold(cell, index)
        return cover.size(cell)
    cell.reason = finding.doubt.reason
    if not finding.axes:
        cell.held = CLOSED
        return 0.0
    _cut(cover, k, finding.axes, index, queue)
    return 0.0


def _cut(
    cover: Cover, k: int, axes: tuple[int, ...], trial: int, queue: list[tuple[float, int]]
) -> None:
    """Cut cell k along parameters, one after the other, and queue the final parts."""
    cell, first = cover.cells[k], len(cover.cells)
    if not axes:
        heapq.heappush(queue, (-cover.size(cell), k))
        return
    cell.cut_in(axes[0], first)
    for lower in (True, False):
        half = Cell(cell.low.copy(), cell.high.copy(), trial=trial)
        (half.high if lower else half.low)[axes[0]] = cell.cut
        cover.cells.append(half)
    for part in (first, first + 1):
        _cut(cover, part, axes[1:], trial, queue)


def _axis(family: ParametricFamily, half: np.ndarray, doubt: Doubt) -> tuple[int, ...]:
    """Return the parameter that adds most to a doubt, if a side is left that may be cut."""
    sides = 2.0 * half / (family.high - family.low)
    weights = np.where(sides > SMALLEST * (1.0 + 1e-9), doubt.shares, -1.0)
    return (int(weights.argmax()),) if weights.max() >= 0.0 else ()


def draws(
    cover: Cover, count: int, seed: int, first: int = 0
) -> Iterator[tuple[np.ndarray, StoredCatch]]:
    """Draw parameters (K,) evenly over the proven cells, each with the stored catch of its cell.

    Draw k depends on the seed and k only; `first` is the first k.
    """
    held = [cell for cell in cover.leaves() if cell.held >= 0]
    sizes = np.cumsum([cover.size(cell) for cell in held])
    for k in range(first, first + count if held else first):
        rng = seeding.rng(seed, k)
        cell = held[int(np.searchsorted(sizes, rng.random() * sizes[-1], side="right"))]
        yield rng.uniform(cell.low, cell.high), cover.catches[cell.held]


def broken_of(
    cover: Cover, count: int, seed: int, progress: Callable[[], None] = lambda: None, first: int = 0
) -> tuple[int, int]:
    """Verify draws from proven cells; return how many break a promise, and how many there are."""
    broken = drawn = 0
    for theta, catch in draws(cover, count, seed, first):
        broken += not catch.verdict(cover.family, theta).good
        drawn += 1
        progress()
    return broken, drawn
