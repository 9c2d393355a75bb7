"""Capsules about convex parts, which are cut where one capsule would lie too far beyond them."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
from scipy.optimize import minimize
from scipy.spatial import ConvexHull, QhullError

from gcm_learn.arms.convex_kernels import gaps, radius_about, skin, spill
from gcm_learn.arms.robots.tree import Hull

DIGITS = 6  # of numbers that are written; radii are enlarged by what rounding may take
_NODES = 20_000  # of a field of distances
_PLACES = (0.2, 0.35, 0.5, 0.65, 0.8)  # of planes that cut, as shares of what they cut
_INSETS = (1.0, 0.7, 0.4, 0.0)  # of the ends of capsules that are tried, in radii
_TRIED = 2  # divisions that are worked out, of all that are thought of


class Piece(NamedTuple):
    """Convex hull of balls: a part of a link, or what planes leave of it."""

    balls: np.ndarray  # (n, 4): centres and radii
    link: int
    """Number of the link."""


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

    @property
    def piece(self) -> Piece:
        """The same as a convex part."""
        ends = np.array([self.start, self.end])
        return Piece(np.column_stack([ends, np.full(2, self.radius)]), -1)


def _sphere(count: int) -> np.ndarray:
    """Return directions (count, 3), spread evenly (Fibonacci's sphere)."""
    k = np.arange(count) + 0.5
    z, turn = 1.0 - 2.0 * k / count, math.pi * (1.0 + math.sqrt(5.0)) * k
    return np.column_stack([np.sqrt(1.0 - z * z) * f(turn) for f in (np.cos, np.sin)] + [z])


_MANY, _FEW = _sphere(300), _sphere(80)


class Packed(NamedTuple):
    """Convex parts as `gaps` takes them."""

    balls: np.ndarray  # (n, 4)
    first: np.ndarray  # (p + 1,)
    rounds: np.ndarray  # (p, 8)

    def __add__(self, other: Packed) -> Packed:  # type: ignore[override]
        """Return the parts of both."""
        return Packed(
            np.concatenate([self.balls, other.balls]),
            np.concatenate([self.first, self.first[-1] + other.first[1:]]),
            np.concatenate([self.rounds, other.rounds]),
        )


def packed(pieces: Sequence[Piece]) -> Packed:
    """Pack parts for kernels."""
    rounds, least = np.empty((len(pieces), 8)), [piece.balls[:, 3].min() for piece in pieces]
    for k, piece in enumerate(pieces):
        about = enclosing(piece.balls)
        rounds[k] = *about.start, *about.end, about.radius, least[k]
    sizes = [len(piece.balls) for piece in pieces]
    balls = all_balls(pieces)
    balls[:, 3] -= np.repeat(least, sizes)
    return Packed(balls, np.cumsum([0, *sizes]), rounds)


class Site:
    """Parts in the frame of a joint that share capsules, and how far points are from them."""

    def __init__(self, joint: int, pieces: Sequence[Piece], limit: float) -> None:
        self.joint, self.pieces, self.limit = joint, pieces, limit
        self._parts = packed(pieces)
        balls = all_balls(pieces)
        low = (balls[:, :3] - balls[:, 3:]).min(axis=0) - 2.0 * limit
        high = (balls[:, :3] + balls[:, 3:]).max(axis=0) + 2.0 * limit
        step = float(np.prod(high - low) / _NODES) ** (1.0 / 3.0)
        axes = [np.arange(a, b + step, step) for a, b in zip(low, high, strict=True)]
        nodes = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)
        self._field = self.away(nodes.reshape(-1, 3)).reshape(nodes.shape[:3])
        self._frame = np.append(low, step)

    def away(self, points: np.ndarray) -> np.ndarray:
        """Return distances (n,) of points (n, 3) from the nearest part."""
        point = Packed(np.zeros((1, 4)), np.array([0, 1]), np.zeros((1, 8)))
        still, origin = np.tile(np.eye(3), (len(points), 1, 1)), np.zeros_like(points)
        parts, count = self._parts + point, len(self._parts.rounds)
        return np.maximum(gaps(*parts, count, still, origin, still, points, 1e9), 0.0)

    def overhang(self, capsule: Capsule) -> float:
        """Return how far the surface of a capsule lies from the nearest part at most."""
        return float(self.away(skin(*capsule, _MANY)[0]).max())

    def cost(self, capsule: Capsule) -> float:
        """Return the volume of a capsule beyond the parts, and more where it lies far out."""
        most, volume = spill(self._field, self._frame, *capsule, _FEW)
        share = most / self.limit
        return float(volume * (1.0 + share + 10.0 * max(share - 0.9, 0.0)))


class Group(NamedTuple):
    """Parts, or pieces of them, that share a capsule."""

    pieces: Sequence[Piece]
    capsule: Capsule
    overhang: float
    """Largest distance of the capsule's surface from all parts of the site."""


def grouped(pieces: Sequence[Piece], site: Site) -> Group:
    """Put pieces into a capsule that holds them, whatever is rounded."""
    start, end, radius = _fitted(all_balls(pieces), site)
    step = 10.0**-DIGITS
    capsule = Capsule(
        np.round(start, DIGITS), np.round(end, DIGITS), float(np.round(radius + 2 * step, DIGITS))
    )
    return Group(pieces, capsule, site.overhang(capsule))


def divided(group: Group, site: Site) -> tuple[Group, Group] | None:
    """Divide a group into two that lie less far beyond the parts, if that is possible.

    Parts are cut by planes. Each piece lies in the capsule of its group, which is convex, so that
    the capsules hold the whole part. Balls and capsules are not cut.
    """
    tried: list[tuple[float, int, tuple[list[Piece], list[Piece]]]] = []
    for sides in _divisions(group):
        if all(sides):
            cost = sum(min(map(site.cost, _tries(all_balls(side)))) for side in sides)
            tried.append((cost, len(tried), sides))
    made = [(grouped(one, site), grouped(two, site)) for _, _, (one, two) in sorted(tried)[:_TRIED]]
    return min(made, key=lambda two: sum(site.cost(g.capsule) for g in two), default=None)


def _divisions(group: Group) -> Iterator[tuple[list[Piece], list[Piece]]]:
    """Yield divisions of a group's parts in two: by planes that cut, and of whole parts."""
    balls, pieces = all_balls(group.pieces), group.pieces
    middles = np.array([piece.balls[:, :3].mean(axis=0) for piece in pieces])
    axis = group.capsule.end - group.capsule.start
    for way in [*_axes(balls[:, :3]), axis / max(float(np.linalg.norm(axis)), 1e-30)]:
        along = balls[:, :3] @ way
        low, high = (along - balls[:, 3]).min(), (along + balls[:, 3]).max()
        for offset in low + np.array(_PLACES) * (high - low):
            cuts = [_cut(piece, way, offset) for piece in pieces]
            yield [a for a, _ in cuts if a is not None], [b for _, b in cuts if b is not None]
            if len(pieces) > 1:
                yield _parted(pieces, middles @ way > offset)
    if len(pieces) > 1:
        size = np.array(
            [np.ptp(p.balls[:, :3], axis=0).max() + p.balls[:, 3].max() for p in pieces]
        )
        yield _parted(pieces, size > 0.5 * size.max())


def _parted(pieces: Sequence[Piece], second: np.ndarray) -> tuple[list[Piece], list[Piece]]:
    """Divide whole parts, each to the capsule that it leaves less; `second` is a first guess."""
    sides = _sides(pieces, second)
    for _ in range(3):
        if not all(sides):
            break
        made = [enclosing(all_balls(side)) for side in sides]
        out = np.array([
            [radius_about(c.start, c.end, p.balls) - c.radius for c in made] for p in pieces
        ])  # fmt: skip
        second = np.where(out[:, 0] == out[:, 1], second, out[:, 1] < out[:, 0])
        sides = _sides(pieces, second)
    return sides


def _sides(pieces: Sequence[Piece], second: np.ndarray) -> tuple[list[Piece], list[Piece]]:
    first = [piece for piece, there in zip(pieces, second, strict=True) if not there]
    return first, [piece for piece, there in zip(pieces, second, strict=True) if there]


def _cut(piece: Piece, way: np.ndarray, offset: float) -> tuple[Piece | None, Piece | None]:
    """Cut a part by a plane; one with radii goes to the side of its middle as a whole."""
    along = piece.balls[:, :3] @ way - offset
    if piece.balls[:, 3].any():
        return (piece, None) if along.mean() <= 0.0 else (None, piece)
    if along.max() <= 0.0 or along.min() >= 0.0:
        return (piece, None) if along.max() <= 0.0 else (None, piece)
    pairs = _edges(piece.balls[:, :3])
    a, b = along[pairs[:, 0]], along[pairs[:, 1]]
    crossing = a * b < 0.0
    share = (a[crossing] / (a[crossing] - b[crossing]))[:, None]
    first, second = piece.balls[pairs[crossing]].transpose(1, 0, 2)
    section = first + share * (second - first)
    below, above = (
        _reduced(np.concatenate([piece.balls[side], section]), piece.link)
        for side in (along <= 0.0, along >= 0.0)
    )
    return below, above


def _edges(points: np.ndarray) -> np.ndarray:
    """Return pairs (e, 2) of points, among which are all edges of their hull."""
    faces = _faces(points)
    if faces is None:
        return np.column_stack(np.triu_indices(len(points), 1))
    size = faces.shape[1]
    return np.concatenate([faces[:, [i, j]] for i in range(size) for j in range(i)])


def _faces(points: np.ndarray) -> np.ndarray | None:
    """Return faces of the hull of points; edges where they lie in a plane, None in a line."""
    spread = points - points.mean(axis=0)
    for flat in (spread, spread @ np.linalg.svd(spread, full_matrices=False)[2][:2].T):
        try:
            return np.asarray(ConvexHull(flat).simplices)
        except (QhullError, ValueError):  # in a plane, or too few
            continue
    return None


def _reduced(balls: np.ndarray, link: int) -> Piece:
    """Return a piece without the corners that lie inside."""
    faces = _faces(balls[:, :3]) if len(balls) > 4 and not balls[:, 3].any() else None
    return Piece(balls if faces is None else balls[np.unique(faces)], link)


def pieces_of(hulls: Sequence[Hull], link: int) -> list[Piece]:
    """Return the parts of a link as pieces."""
    return [_reduced(np.column_stack([h.centres, h.radii]), link) for h in hulls]


def all_balls(pieces: Sequence[Piece]) -> np.ndarray:
    """Return all balls (n, 4) of pieces."""
    return np.concatenate([piece.balls for piece in pieces])


def _axes(points: np.ndarray) -> np.ndarray:
    """Return the principal axes (3, 3) of points."""
    spread = points - points.mean(axis=0)
    return np.linalg.eigh(spread.T @ spread)[1].T


def _tries(balls: np.ndarray) -> Iterator[Capsule]:
    """Yield capsules along the principal axes of what they hold."""
    points, radii = balls[:, :3], balls[:, 3:]
    middle = 0.5 * ((points - radii).min(axis=0) + (points + radii).max(axis=0))
    yield Capsule(middle, middle, radius_about(middle, middle, balls))
    for axis in _axes(points):
        along = (points - middle) @ axis
        low, high = (along - balls[:, 3]).min(), (along + balls[:, 3]).max()
        centre = middle + 0.5 * (low + high) * axis
        far = radius_about(centre - 1e3 * axis, centre + 1e3 * axis, balls)
        for inset in _INSETS:
            half = max(0.5 * (high - low) - inset * far, 0.0) * axis
            start, end = centre - half, centre + half
            yield Capsule(start, end, radius_about(start, end, balls))


def enclosing(balls: np.ndarray) -> Capsule:
    """Return a small capsule about balls (n, 4); that of a capsule is itself."""
    if len(balls) < 3 and np.ptp(balls[:, 3]) == 0.0:
        return Capsule(balls[0, :3], balls[-1, :3], float(balls[0, 3]))
    return min(_tries(balls), key=lambda capsule: capsule.volume)


def _fitted(balls: np.ndarray, site: Site) -> Capsule:
    """Return a capsule that lies little beyond the parts, by a search that begins at a guess."""
    if len(balls) < 3 and np.ptp(balls[:, 3]) == 0.0:
        return enclosing(balls)
    best = min(_tries(balls), key=site.cost)

    def made(x: np.ndarray) -> Capsule:
        return Capsule(x[:3], x[3:], radius_about(x[:3], x[3:], balls))

    for nudge in (0.0, 0.2):
        shift = nudge * best.radius * np.array([1.0, -1.0, 1.0])
        found = minimize(
            lambda x: site.cost(made(x)), np.concatenate([best.start - shift, best.end + shift]),
            method="Nelder-Mead",
            options={"maxiter": 150, "xatol": 1e-5, "fatol": 1e-12, "adaptive": True},
        )  # fmt: skip
        best = min(best, made(found.x), key=site.cost)
    return best
