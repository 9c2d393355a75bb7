"""Capsules about convex parts: small ones that surely hold them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.optimize import minimize
from scipy.spatial import ConvexHull, QhullError

from gcm_learn.arms.robots.tree import Hull

SLACK = 0.15
"""Two parts share a capsule if its volume is larger by this share, at most, than that of two."""
DIGITS = 6  # of numbers that are written; radii are enlarged by what rounding may take
_FEW = 40  # points of which none is left out before a fit


class Capsule(NamedTuple):
    """A capsule about parts of a link; a ball where both ends are equal."""

    start: np.ndarray  # (3,)
    end: np.ndarray  # (3,)
    radius: float

    @property
    def volume(self) -> float:
        """Volume [lengths^3]."""
        length = float(np.linalg.norm(self.end - self.start))
        return math.pi * self.radius**2 * (length + 4.0 / 3.0 * self.radius)

    def support(self, directions: np.ndarray) -> np.ndarray:
        """Return how far it reaches in unit directions (n, 3)."""
        return np.maximum(directions @ self.start, directions @ self.end) + self.radius


def support(hulls: Sequence[Hull], directions: np.ndarray) -> np.ndarray:
    """Return how far any of the hulls reaches in unit directions (n, 3)."""
    reached = [(directions @ hull.centres.T + hull.radii).max(axis=1) for hull in hulls]
    return np.max(reached, axis=0)


def overhang(capsule: Capsule, hulls: Sequence[Hull], count: int = 500) -> float:
    """Return how far a capsule lies beyond the hull of parts at most, over some directions."""
    k = np.arange(count) + 0.5
    z, turn = 1.0 - 2.0 * k / count, math.pi * (1.0 + math.sqrt(5.0)) * k  # Fibonacci's sphere
    flat = np.sqrt(1.0 - z * z)
    directions = np.column_stack([flat * np.cos(turn), flat * np.sin(turn), z])
    return float(np.max(capsule.support(directions) - support(hulls, directions)))


class Group(NamedTuple):
    """Parts that share a capsule."""

    hulls: tuple[Hull, ...]
    capsule: Capsule


def covered(hulls: Sequence[Hull], most: int) -> list[Group]:
    """Cover convex parts by capsules.

    Every part has one of its own first. Then the two whose common capsule costs the least volume
    are joined, as long as that is little or there are too many.

    Parameters
    ----------
    hulls : sequence of Hull
    most : int
        Capsules at most.

    Returns
    -------
    list of Group
        Each part lies within the capsule of its group.
    """
    groups = [Group((hull,), _guess((hull,))) for hull in hulls]
    costs: dict[tuple[int, int], tuple[float, Group]] = {}
    names = list(range(len(groups)))  # of groups, since costs of pairs that stay are kept
    fresh = len(groups)
    while len(groups) > 1:
        for i in range(len(groups)):
            for j in range(i):
                pair = names[j], names[i]
                if pair not in costs:
                    costs[pair] = _joined(groups[j], groups[i])
        pairs = {(names[j], names[i]): (j, i) for i in range(len(groups)) for j in range(i)}
        best = min(pairs, key=lambda pair: costs[pair][0])
        if costs[best][0] > SLACK and len(groups) <= most:
            break
        j, i = pairs[best]
        groups = [g for k, g in enumerate(groups) if k not in (i, j)] + [costs[best][1]]
        names = [name for k, name in enumerate(names) if k not in (i, j)] + [fresh]
        fresh += 1
    return [Group(group.hulls, _rounded(_fitted(group))) for group in groups]


def _joined(a: Group, b: Group) -> tuple[float, Group]:
    """Return by how much the volume grows if two groups share a capsule, and the new group."""
    hulls = (*a.hulls, *b.hulls)
    capsule = _guess(hulls)
    return capsule.volume / (a.capsule.volume + b.capsule.volume) - 1.0, Group(hulls, capsule)


def _balls(hulls: Sequence[Hull]) -> tuple[np.ndarray, np.ndarray]:
    """Return centres and radii of the balls that matter."""
    centres = np.concatenate([hull.centres for hull in hulls])
    radii = np.concatenate([hull.radii for hull in hulls])
    if len(centres) > _FEW and not radii.any():
        try:
            kept = ConvexHull(centres).vertices
        except QhullError:  # all in one plane
            return centres, radii
        return centres[kept], radii[kept]
    return centres, radii


def _radius(start: np.ndarray, end: np.ndarray, centres: np.ndarray, radii: np.ndarray) -> float:
    """Return the smallest radius with which a capsule holds all balls."""
    axis = end - start
    length2 = float(axis @ axis)
    away = centres - start
    share = np.clip(away @ axis / length2, 0.0, 1.0) if length2 > 0.0 else np.zeros(len(centres))
    return float((np.linalg.norm(away - share[:, None] * axis, axis=1) + radii).max())


def _guess(hulls: Sequence[Hull]) -> Capsule:
    """Return the smallest of some capsules along the principal axes."""
    centres, radii = _balls(hulls)
    middle = 0.5 * ((centres - radii[:, None]).min(axis=0) + (centres + radii[:, None]).max(axis=0))
    spread = centres - centres.mean(axis=0)
    axes = np.linalg.svd(spread, full_matrices=False)[2] if len(centres) > 1 else np.eye(3)
    tries = [Capsule(middle, middle, _radius(middle, middle, centres, radii))]
    for axis in axes:
        along = (centres - middle) @ axis
        low, high = (along - radii).min(), (along + radii).max()
        centre = middle + 0.5 * (low + high) * axis
        far = _radius(centre - 1e3 * axis, centre + 1e3 * axis, centres, radii)
        for inset in (1.0, 0.75, 0.5):
            half = max(0.5 * (high - low) - inset * far, 0.0) * axis
            start, end = centre - half, centre + half
            tries.append(Capsule(start, end, _radius(start, end, centres, radii)))
    return min(tries, key=lambda capsule: capsule.volume)


def _fitted(group: Group) -> Capsule:
    """Return a capsule of least volume, by a search that begins at the group's."""
    centres, radii = _balls(group.hulls)
    best = group.capsule

    def made(x: np.ndarray) -> Capsule:
        return Capsule(x[:3], x[3:], _radius(x[:3], x[3:], centres, radii))

    for nudge in (0.0, 0.2):
        shift = nudge * best.radius * np.array([1.0, -1.0, 1.0])
        begin = np.concatenate([best.start - shift, best.end + shift])
        found = minimize(
            lambda x: made(x).volume, begin, method="Nelder-Mead",
            options={"maxiter": 3000, "xatol": 1e-6, "fatol": 1e-12, "adaptive": True},
        )  # fmt: skip
        best = min(best, made(found.x), key=lambda capsule: capsule.volume)
    return best


def _rounded(capsule: Capsule) -> Capsule:
    """Return the capsule with few digits, and large enough for what that takes."""
    ends = np.round(capsule.start, DIGITS), np.round(capsule.end, DIGITS)
    step = 10.0**-DIGITS
    return Capsule(*ends, float(np.round(capsule.radius + 2.0 * step, DIGITS)))
