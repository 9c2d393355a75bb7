"""Capsules for the links of an arm: most where they cost free postures, or lie far out."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import replace
from functools import cache
from itertools import combinations, product
from typing import Any, NamedTuple

import numpy as np

from gcm_learn.arms.chain_model import ChainModel, Link
from gcm_learn.arms.robots.capsules import Site, SiteCapsule, enclosing, packed
from gcm_learn.arms.robots.pairs import Frames, Meets, RigidLink, meetings
from gcm_learn.arms.robots.tree import Hull, all_balls

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
    """Shares of random postures without self-collision, and the overlaps that reduce them most."""

    parts: float
    capsules: float
    worst: tuple[Clash, ...]


def covered(
    model: ChainModel, solids: Sequence[RigidLink], joined: Collection[frozenset[str]], each: int,
    seed: int,
) -> tuple[ChainModel, tuple[Cover, ...], tuple[tuple[Hull, ...], ...], Freedom]:  # fmt: skip
    """Return the first fields of `Fitted`: capsules about links, and pairs to be checked.

    Links and pairs of the given model do not count. `joined` has the names of two links that one
    joint joins. A link gets as many capsules as `each` at most.
    """
    frames = Frames.sampled(model, seed)
    meets, passed = meetings(solids, frames, joined)
    hand = frames.places[model.hand.joint] + frames.rotations[model.hand.joint] @ model.hand.point
    reach = float(np.linalg.norm(hand - model.joints[0].origin, axis=1).max())
    cells = DividedCapsules(frames, meets, max(SMALL[0], SMALL[1] * reach), each)
    cells.cover(solids, passed)
    names = {site: _named(site, solids) for site in cells.sites}
    cells.cells.sort(key=lambda cell: cells.sites.index(cell.site))
    number = {cell: k for k, cell in enumerate(cells.cells)}
    links, covers = [], []
    for cell in cells.cells:
        start, end, radius = cell.capsule
        ends: tuple[Any, Any] = start.tolist(), end.tolist()
        links.append(Link(cell.site.joint, *ends, radius, names[cell.site]))
    for site, name in names.items():
        over = [cell.overhang for cell in cells.cells if cell.site is site]
        covers.append(Cover(name, site.joint, len(over), max(over)))
    pairs = tuple(sorted((number[a], number[b]) for a, b in cells.pairs))
    model = replace(model, links=tuple(links), self_collision=pairs)
    parts = tuple(tuple(cell.hulls) for cell in cells.cells)
    return model, tuple(covers), parts, _freedom(cells, list(names.values()))


def _named(site: Site, solids: Sequence[RigidLink]) -> str:
    """Return the name of a site's largest link, and the number of other links in the site."""
    own = sorted({hull.link for hull in site.hulls})
    first = max(own, key=lambda k: enclosing(all_balls(solids[k].hulls)).volume)
    return solids[first].name + (f" and {len(own) - 1} more" if len(own) > 1 else "")


def _freedom(cells: DividedCapsules, names: Sequence[str]) -> Freedom:
    """Compare capsules with parts at the random postures, in all and for each pair of sites."""
    number = {hull.link: k for k, site in enumerate(cells.sites) for hull in site.hulls}
    frames = cells.frames.some(cells.frames.random)
    overlaps: tuple[Meets, Meets] = {}, {}

    def note(which: int, sites: Sequence[int], hit: np.ndarray) -> None:
        i, j = sorted(sites)
        overlaps[which][i, j] = overlaps[which].get((i, j), False) | hit

    for links, met in cells.meets.items():
        note(0, [number[link] for link in links], met[cells.frames.random])
    for one, two in cells.pairs:
        hit = frames.gaps(one.packed, two.packed, (one.site.joint, two.site.joint)) <= 0.0
        note(1, [cells.sites.index(cell.site) for cell in (one, two)], hit)
    parts, capsules = (1.0 - float(frames.any_of(each.values()).mean()) for each in overlaps)
    worst = [
        Clash((names[i], names[j]), float(met.mean()), float(overlaps[1][i, j].mean()))
        for (i, j), met in overlaps[0].items()
    ]
    return Freedom(parts, capsules, tuple(sorted(worst, key=lambda clash: -clash.capsules)))


class DividedCapsules:
    """Capsules of an arm, divided one by one, and the postures of their overlaps; see `meetings`.

    Capsules with an overhang above the limit are divided while there are fewer than `MOST`.
    """

    def __init__(self, frames: Frames, meets: Meets, limit: float, each: int) -> None:
        self.frames, self.meets, self.limit, self.each = frames, meets, limit, each
        free = frames.random & ~frames.any_of(meets.values())
        self._trials = frames.some(np.flatnonzero(free)[:TRIALS])
        self.sites: list[Site] = []
        self.cells: list[SiteCapsule] = []
        self.pairs: dict[tuple[SiteCapsule, SiteCapsule], np.ndarray] = {}
        """Pairs that are checked, and in which trials they overlap."""

    def cover(self, solids: Sequence[RigidLink], passed: Collection[tuple[int, int]]) -> None:
        """Cover links by capsules, and divide these; for the arguments see `meetings`."""
        for joint, hulls in _shared(solids, passed):
            self.sites.append(Site(joint, hulls, self.limit))
            self._add(SiteCapsule(hulls, self.sites[-1]))
        self.sites.sort(key=lambda site: site.hulls[0].link)
        least, tries = 1.0, 0
        while len(self.cells) < MOST:
            hits = self._trials.any_of(self.pairs.values())
            lost = float(hits.mean()) if hits.size else 0.0
            tries = 0 if lost < least else tries + 1
            least = min(lost, least)
            cell = self._costliest() if lost > LOST and tries < PATIENCE else None
            cell = cell or self._farthest() or (self._costliest() if lost > LOST else None)
            if cell is None:
                break
            self._divide(cell)

    def _add(self, new: SiteCapsule) -> None:
        """Add a capsule, and find its overlaps with all capsules whose parts its parts can meet."""
        for old in self.cells:
            joints = old.site.joint, new.site.joint
            if joints[0] != joints[1] and self._touching(old, new):
                self.pairs[old, new] = self._trials.gaps(old.packed, new.packed, joints) <= 0.0
        self.cells.append(new)

    def _touching(self, one: SiteCapsule, two: SiteCapsule) -> bool:
        """Return whether parts of links that are checked touch in any posture."""
        joints = one.site.joint, two.site.joint
        links = ({hull.link for hull in cell.hulls} for cell in (one, two))
        for a, b in product(*links):
            met = self.meets.get((a, b), self.meets.get((b, a)))
            if met is not None:
                near = self.frames.some(met)
                near = near.some(near.gaps(one.packed, two.packed, joints) <= 0.0)
                first, second = (
                    packed([hull for hull in cell.hulls if hull.link == k])
                    for cell, k in ((one, a), (two, b))
                )
                if (near.gaps(first, second, joints) <= 0.0).any():
                    return True
        return False

    def _costliest(self) -> SiteCapsule | None:
        """Return the capsule to which most trials are lost, that farther out of a pair."""
        weights = dict.fromkeys(self.cells, 0.0)
        many = np.maximum(np.sum([*self.pairs.values()], axis=0), 1)
        for pair, hit in self.pairs.items():
            over = [cell.overhang if self._divisible(cell) else 0.0 for cell in pair]
            for cell, out in zip(pair, over, strict=True):
                weights[cell] += float((hit / many).sum()) * out / max(sum(over), 1e-12)
        best = max(weights, key=weights.__getitem__)
        return best if weights[best] > 0.0 else None

    def _farthest(self) -> SiteCapsule | None:
        """Return the capsule with the largest overhang, if that is beyond the limit."""
        over = [c for c in self.cells if c.overhang > self.limit and self._divisible(c)]
        return max(over, key=lambda cell: cell.overhang, default=None)

    def _divisible(self, cell: SiteCapsule) -> bool:
        return not cell.whole and sum(c.site is cell.site for c in self.cells) < self.each

    def _divide(self, cell: SiteCapsule) -> None:
        """Replace a capsule by two, or mark it as whole if it cannot be divided."""
        two = cell.divided()
        cell.whole = two is None
        if two is not None:
            self.cells.remove(cell)
            self.pairs = {pair: hit for pair, hit in self.pairs.items() if cell not in pair}
            for new in two:
                self._add(new)


def _shared(
    solids: Sequence[RigidLink], passed: Collection[tuple[int, int]]
) -> Iterator[tuple[int, list[Hull]]]:
    """Yield a joint and parts for each capsule to begin with.

    Links share a capsule only if there are too many, one frame carries them, and the same links are
    not checked against them. Those come first whose capsule adds least to the two.
    """
    kinds, sets = [], [frozenset((k,)) for k in range(len(solids))]
    for k, solid in enumerate(solids):
        kinds.append((solid.joint, frozenset(sum(pair) - k for pair in passed if k in pair)))

    def hulls(links: frozenset[int]) -> list[Hull]:
        return [hull for k in sorted(links) for hull in solids[k].hulls]

    @cache
    def volume(links: frozenset[int]) -> float:
        return enclosing(all_balls(hulls(links))).volume

    while len(sets) > FIRST:
        alike = [(a, b) for a, b in combinations(sets, 2) if kinds[min(a)] == kinds[min(b)]]
        if not alike:
            break
        a, b = min(alike, key=lambda two: volume(two[0] | two[1]) - sum(map(volume, two)))
        sets = [a | b if links is a else links for links in sets if links is not b]
    for links in sets:
        yield solids[min(links)].joint, hulls(links)
