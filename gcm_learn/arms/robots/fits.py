"""Capsules for the links of an arm: most where they cost free postures, or lie far out."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import replace
from functools import cache
from itertools import combinations
from typing import Any, NamedTuple

import numpy as np

from gcm_learn.arms.chain import ChainModel, Link
from gcm_learn.arms.robots.capsules import (
    Group,
    Piece,
    Site,
    all_balls,
    divided,
    enclosing,
    grouped,
    packed,
)
from gcm_learn.arms.robots.pairs import Frames, Meets, Solid, meetings
from gcm_learn.arms.robots.tree import Hull

MOST = 40
"""Capsules of an arm, at most, unless more links move apart."""
FIRST = 20
"""Capsules to begin with: one a link, or fewer where links of one frame can share them."""
SMALL = 0.01, 0.02
"""Overhang that is small: the larger of a length and a share of the arm's reach."""
LOST = 0.04
"""Share of the postures free by the parts that the capsules may take without being divided."""
PATIENCE = 8  # divisions that do not lower this share, until the farthest capsules are divided
TRIALS = 3000  # postures, free by the parts, in which capsules are tried


class Cover(NamedTuple):
    """How a link of the robot is covered, or several that share capsules."""

    link: str
    joint: int
    """Joint of the chain that carries it, 0 for the base."""
    capsules: int
    overhang: float
    """Largest distance of the capsules' surfaces from the nearest part."""


class Clash(NamedTuple):
    """Two links, and in which shares of random postures they overlap."""

    links: tuple[str, str]
    parts: float
    capsules: float


class Freedom(NamedTuple):
    """Shares of random postures that are free of self-collision, and what costs most of them."""

    parts: float
    capsules: float
    worst: tuple[Clash, ...]


class Covered(NamedTuple):
    """Capsules of an arm, and what they make of it."""

    model: ChainModel
    covers: tuple[Cover, ...]
    parts: tuple[tuple[Hull, ...], ...]
    """Convex parts that each capsule holds, in the frame of its joint."""
    freedom: Freedom


def covered(
    model: ChainModel, solids: Sequence[Solid], joined: Collection[frozenset[str]], each: int,
    seed: int,
) -> Covered:  # fmt: skip
    """Put capsules about the links of an arm, and find those that are to be checked.

    Parameters
    ----------
    model : ChainModel
        The arm, whose links and pairs do not count.
    solids : sequence of Solid
    joined : collection of frozensets of str
        Names of two links that one joint joins.
    each : int
        Capsules that cover a link, at most.
    seed : int
        Of the sampled postures.
    """
    frames = Frames.sampled(model, seed)
    meets, passed = meetings(solids, frames, joined)
    hand = frames.places[model.hand.joint] + frames.rotations[model.hand.joint] @ model.hand.point
    reach = float(np.linalg.norm(hand - model.joints[0].origin, axis=1).max())
    cells = fitted(solids, frames, meets, passed, max(SMALL[0], SMALL[1] * reach), each)
    sites = sorted({cell.site for cell in cells.cells}, key=lambda site: site.pieces[0].link)
    names = [_named(site, solids) for site in sites]
    cells.cells.sort(key=lambda cell: sites.index(cell.site))
    number = {cell: k for k, cell in enumerate(cells.cells)}
    links, covers, parts = [], [], []
    for cell in cells.cells:
        start, end, radius = cell.group.capsule
        ends: tuple[Any, Any] = start.tolist(), end.tolist()
        links.append(Link(cell.site.joint, *ends, radius, names[sites.index(cell.site)]))
        parts.append(tuple(Hull(p.balls[:, :3], p.balls[:, 3]) for p in cell.group.pieces))
    for site, name in zip(sites, names, strict=True):
        over = [cell.group.overhang for cell in cells.cells if cell.site is site]
        covers.append(Cover(name, site.joint, len(over), max(over)))
    pairs = tuple(sorted((number[a], number[b]) for a, b in cells.pairs))
    model = replace(model, links=tuple(links), self_collision=pairs)
    return Covered(model, tuple(covers), tuple(parts), _freedom(cells, sites, names))


def _named(site: Site, solids: Sequence[Solid]) -> str:
    """Return the name of the largest link, and how many share its capsules."""
    own = sorted({piece.link for piece in site.pieces}, key=lambda k: -solids[k].volume)
    return solids[own[0]].name + (f" and {len(own) - 1} more" if len(own) > 1 else "")


def _freedom(cells: Cells, sites: Sequence[Site], names: Sequence[str]) -> Freedom:
    """Compare capsules with parts at the random postures, in all and for each pair of sites."""
    number = {piece.link: k for k, site in enumerate(sites) for piece in site.pieces}
    frames = cells.frames.some(cells.frames.random)
    overlaps: tuple[Meets, Meets] = {}, {}
    for links, met in cells.meets.items():
        i, j = sorted(number[link] for link in links)
        overlaps[0][i, j] = overlaps[0].get((i, j), False) | met[cells.frames.random]
    for one, two in cells.pairs:
        i, j = sorted(sites.index(cell.site) for cell in (one, two))
        hit = frames.gaps(one.packed, two.packed, (one.site.joint, two.site.joint)) <= 0.0
        overlaps[1][i, j] = overlaps[1].get((i, j), False) | hit
    parts, capsules = (1.0 - float(frames.any_of(each.values()).mean()) for each in overlaps)
    worst = [
        Clash((names[i], names[j]), float(met.mean()), float(overlaps[1][i, j].mean()))
        for (i, j), met in overlaps[0].items()
    ]
    return Freedom(parts, capsules, tuple(sorted(worst, key=lambda clash: -clash.capsules)))


class Cell:
    """A capsule that may still be divided."""

    def __init__(self, site: Site, group: Group) -> None:
        self.site, self.group = site, group
        self.whole = False  # if it cannot be divided
        self.packed = packed([group.capsule.piece])


class Cells:
    """Capsules of an arm that are divided one by one, and where they overlap.

    Parameters
    ----------
    frames : Frames
    meets : dict of (int, int) to ndarray
        See `meetings`.
    limit : float
        Overhang beyond which capsules are divided, as long as there are fewer than `MOST`.
    each : int
        Capsules that a link gets, at most.
    """

    def __init__(self, frames: Frames, meets: Meets, limit: float, each: int) -> None:
        self.frames, self.meets, self.limit, self.each = frames, meets, limit, each
        free = frames.random & ~frames.any_of(meets.values())
        self._trials = frames.some(np.flatnonzero(free)[:TRIALS])
        self.cells: list[Cell] = []
        self.pairs: dict[tuple[Cell, Cell], np.ndarray] = {}
        """Pairs that are checked, and in which trials they overlap."""

    def add(self, site: Site, group: Group) -> None:
        """Add a capsule, and check it against all others whose pieces it can meet."""
        new = Cell(site, group)
        for old in self.cells:
            if old.site.joint != site.joint and self._touching(old, new):
                joints = old.site.joint, site.joint
                self.pairs[old, new] = self._trials.gaps(old.packed, new.packed, joints) <= 0.0
        self.cells.append(new)

    def _touching(self, one: Cell, two: Cell) -> bool:
        """Return whether pieces of links that are checked touch in any posture."""
        joints = one.site.joint, two.site.joint
        for (a, first), (b, second) in ((x, y) for x in _by_link(one) for y in _by_link(two)):
            met = self.meets.get((a, b), self.meets.get((b, a)))
            if met is not None:
                near = self.frames.some(met)
                near = near.some(near.gaps(one.packed, two.packed, joints) <= 0.0)
                if (near.gaps(packed(first), packed(second), joints) <= 0.0).any():
                    return True
        return False

    def lost(self) -> float:
        """Return the share of trials in which capsules overlap."""
        hits = self._trials.any_of(self.pairs.values())
        return float(hits.mean()) if len(hits) else 0.0

    def costliest(self) -> Cell | None:
        """Return the capsule to which most trials are lost, that farther out of a pair."""
        weights = dict.fromkeys(self.cells, 0.0)
        many = np.maximum(np.sum([*self.pairs.values()], axis=0), 1)
        for pair, hit in self.pairs.items():
            over = [cell.group.overhang if self._divisible(cell) else 0.0 for cell in pair]
            for cell, out in zip(pair, over, strict=True):
                weights[cell] += float((hit / many).sum()) * out / max(sum(over), 1e-12)
        best = max(weights, key=weights.__getitem__)
        return best if weights[best] > 0.0 else None

    def farthest(self) -> Cell | None:
        """Return the capsule with the largest overhang, if that is beyond the limit."""
        over = [c for c in self.cells if c.group.overhang > self.limit and self._divisible(c)]
        return max(over, key=lambda cell: cell.group.overhang, default=None)

    def _divisible(self, cell: Cell) -> bool:
        return not cell.whole and sum(c.site is cell.site for c in self.cells) < self.each

    def divide(self, cell: Cell) -> None:
        """Put two capsules in the place of one, if that is possible."""
        two = divided(cell.group, cell.site)
        cell.whole = two is None
        if two is not None:
            self.cells.remove(cell)
            self.pairs = {pair: hit for pair, hit in self.pairs.items() if cell not in pair}
            for group in two:
                self.add(cell.site, group)


def _by_link(cell: Cell) -> list[tuple[int, list[Piece]]]:
    pieces = cell.group.pieces
    return [(k, [p for p in pieces if p.link == k]) for k in sorted({p.link for p in pieces})]


def fitted(
    solids: Sequence[Solid], frames: Frames, meets: Meets, passed: Collection[tuple[int, int]],
    limit: float, each: int = MOST,
) -> Cells:  # fmt: skip
    """Cover links by capsules; for the arguments see `Cells` and `meetings`."""
    made = Cells(frames, meets, limit, each)
    for joint, pieces in _shared(solids, passed):
        site = Site(joint, pieces, limit)
        made.add(site, grouped(pieces, site))
    least, tries = 1.0, 0
    while len(made.cells) < MOST:
        lost = made.lost()
        tries = 0 if lost < least else tries + 1
        least = min(lost, least)
        cell = made.costliest() if lost > LOST and tries < PATIENCE else None
        cell = cell or made.farthest() or (made.costliest() if lost > LOST else None)
        if cell is None:
            break
        made.divide(cell)
    return made


def _shared(
    solids: Sequence[Solid], passed: Collection[tuple[int, int]]
) -> Iterator[tuple[int, list[Piece]]]:
    """Yield a joint and pieces for each capsule to begin with.

    Links share a capsule only if there are too many, one frame carries them, and the same links are
    not checked against them. Those come first whose capsule adds least to the two.
    """
    kinds, sets = [], [frozenset((k,)) for k in range(len(solids))]
    for k, solid in enumerate(solids):
        kinds.append((solid.joint, frozenset(sum(pair) - k for pair in passed if k in pair)))

    def pieces(links: frozenset[int]) -> list[Piece]:
        return [piece for k in sorted(links) for piece in solids[k].pieces]

    @cache
    def volume(links: frozenset[int]) -> float:
        return enclosing(all_balls(pieces(links))).volume

    while len(sets) > FIRST:
        alike = [(a, b) for a, b in combinations(sets, 2) if kinds[min(a)] == kinds[min(b)]]
        if not alike:
            break
        a, b = min(alike, key=lambda two: volume(two[0] | two[1]) - sum(map(volume, two)))
        sets = [a | b if links is a else links for links in sets if links is not b]
    for links in sets:
        yield solids[min(links)].joint, pieces(links)
