"""Capsules around convex parts; parts are cut where a single capsule would reach too far out."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import combinations
from typing import NamedTuple

import numpy as np
from scipy.ndimage import map_coordinates
from scipy.optimize import minimize
from scipy.spatial import ConvexHull, QhullError

from gcm_learn.arms.convex_kernels import gaps
from gcm_learn.arms.kinematics import off_segment
from gcm_learn.arms.robots.tree import Hull, all_balls, crossings, sphere

DIGITS = 6  # of numbers that are written; radii are enlarged by what rounding may take
_NODES = 20_000  # of a field of distances
_PLACES = (0.2, 0.35, 0.5, 0.65, 0.8)  # of planes that cut, as shares of what they cut
_INSETS = (1.0, 0.7, 0.4, 0.0)  # of the ends of capsules that are tried, in radii
_NUDGE = 0.3  # of ends, with which a search begins [radii]
_TRIED = 2  # divisions that are worked out, of all that are thought of


class FittedCapsule(NamedTuple):
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
    def hull(self) -> Hull:
        """The same as a convex part."""
        return Hull(np.column_stack([[self.start, self.end], np.full(2, self.radius)]))

    def skin(self, sample: Skin) -> tuple[np.ndarray, np.ndarray]:
        """Return points (n, 3) all over the surface, and the area of each (n,)."""
        start, end, radius = self
        axis = end - start
        length = math.sqrt(axis @ axis)
        mirror = _UP - axis / length if length > 0.0 else _UP  # takes z to the axis
        size = max(float(mirror @ mirror), 1e-30)
        ways = sample.ways - (sample.ways @ mirror)[:, None] * (2.0 / size * mirror)
        points = start + sample.shares[:, None] * axis + radius * ways
        return points, radius * (radius * sample.ends + length * sample.side)


class Skin(NamedTuple):
    """Points all over a capsule along z: on both ends, and in rings between them."""

    ways: np.ndarray  # (n, 3): from the axis
    shares: np.ndarray  # (n,): of the axis, at which they leave it
    ends: np.ndarray  # (n,): their area on ends [radius^2]
    side: np.ndarray  # (n,): their area between the ends [radius length]

    @classmethod
    def of(cls, count: int, rings: int, around: int) -> Skin:
        """Return `count` points on the ends, and as many rings of others."""
        ball, turn = sphere(count), np.linspace(0.0, 2.0 * math.pi, around, endpoint=False)
        ring = np.column_stack([np.cos(turn), np.sin(turn), np.zeros(around)])
        shares = np.repeat((np.arange(rings) + 0.5) / rings, around)
        first = np.arange(count + rings * around) < count
        return cls(
            np.concatenate([ball, np.tile(ring, (rings, 1))]),
            np.append(ball[:, 2] > 0.0, shares),
            np.where(first, 4.0 * math.pi / count, 0.0),
            np.where(first, 0.0, 2.0 * math.pi / (rings * around)),
        )


_MANY, _FEW = Skin.of(300, 24, 60), Skin.of(80, 8, 16)
_UP = np.array([0.0, 0.0, 1.0])


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


def packed(hulls: Sequence[Hull]) -> Packed:
    """Pack parts for kernels."""
    sizes, least = [len(h.balls) for h in hulls], [h.balls[:, 3].min() for h in hulls]
    about = [enclosing(h.balls) for h in hulls]
    rounds = [[*c.start, *c.end, c.radius, low] for c, low in zip(about, least, strict=True)]
    balls = all_balls(hulls) - np.outer(np.repeat(least, sizes), (0.0, 0.0, 0.0, 1.0))
    return Packed(balls, np.cumsum([0, *sizes]), np.array(rounds))


class Site:
    """Parts in the frame of a joint that share capsules, and how far points are from them."""

    def __init__(self, joint: int, hulls: Sequence[Hull], limit: float) -> None:
        self.joint, self.hulls, self.limit = joint, hulls, limit
        self._parts = packed(hulls) + packed([Hull(np.zeros((1, 4)))])
        balls = all_balls(hulls)
        low = (balls[:, :3] - balls[:, 3:]).min(axis=0) - 2.0 * limit
        high = (balls[:, :3] + balls[:, 3:]).max(axis=0) + 2.0 * limit
        step = float(np.prod(high - low) / _NODES) ** (1.0 / 3.0)
        axes = [np.arange(a, b + step, step) for a, b in zip(low, high, strict=True)]
        nodes = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)
        self._field = self.away(nodes.reshape(-1, 3)).reshape(nodes.shape[:3])
        self._low, self._step = low, step

    def away(self, points: np.ndarray) -> np.ndarray:
        """Return distances (n,) of points (n, 3) from the nearest part."""
        still = np.tile(np.eye(3), (len(points), 1, 1))
        return np.maximum(gaps(*self._parts, len(self.hulls), still, points, 1e9), 0.0)

    def cost(self, capsule: FittedCapsule) -> float:
        """Return a capsule's volume beyond its parts, times a factor that grows with overhang."""
        points, areas = capsule.skin(_FEW)
        nodes = (points - self._low) / self._step
        out = map_coordinates(self._field, nodes.T, order=1, mode="nearest", output=float)
        share = out.max() / self.limit
        return float(areas @ out * (1.0 + share + 10.0 * max(share - 0.9, 0.0)))


class SiteCapsule:
    """A capsule that holds parts of a site, or pieces of them, whatever is rounded."""

    def __init__(self, hulls: Sequence[Hull], site: Site) -> None:
        self.hulls, self.site = hulls, site
        start, end, radius = _fitted(all_balls(hulls), site)
        radius = float(np.round(radius + 2.0 * 10.0**-DIGITS, DIGITS))
        self.capsule = FittedCapsule(np.round(start, DIGITS), np.round(end, DIGITS), radius)
        self.packed = packed([self.capsule.hull])
        self.overhang = float(site.away(self.capsule.skin(_MANY)[0]).max())
        """Largest distance of the capsule's surface from all parts of the site."""
        self.whole = False  # if it cannot be divided

    def divided(self) -> tuple[SiteCapsule, SiteCapsule] | None:
        """Return two capsules that lie less far beyond the parts, if that is possible.

        Parts are cut by planes. Each piece lies in this capsule, which is convex, so that both hold
        the whole part. Balls and capsules are not cut.
        """
        tried: list[tuple[float, int, Sides]] = []
        for sides in _divisions(self):
            if all(sides):
                cost = sum(min(map(self.site.cost, _tries(all_balls(side)))) for side in sides)
                tried.append((cost, len(tried), sides))
        made = [
            (SiteCapsule(a, self.site), SiteCapsule(b, self.site))
            for _, _, (a, b) in sorted(tried)[:_TRIED]
        ]
        return min(
            made, key=lambda two: sum(self.site.cost(cell.capsule) for cell in two), default=None
        )


Sides = tuple[list[Hull], list[Hull]]


def _divisions(cell: SiteCapsule) -> Iterator[Sides]:
    """Yield divisions of a capsule's parts in two: by planes that cut, and of whole parts."""
    balls, hulls = all_balls(cell.hulls), cell.hulls
    middles = np.array([hull.centres.mean(axis=0) for hull in hulls])
    axis = cell.capsule.end - cell.capsule.start
    for way in [*_axes(balls[:, :3]), axis / max(float(np.linalg.norm(axis)), 1e-30)]:
        along = balls[:, :3] @ way
        low, high = (along - balls[:, 3]).min(), (along + balls[:, 3]).max()
        for offset in low + np.array(_PLACES) * (high - low):
            cuts = [_cut(hull, way, offset) for hull in hulls]
            yield [a for a, _ in cuts if a is not None], [b for _, b in cuts if b is not None]
            if len(hulls) > 1:
                yield _parted(hulls, middles @ way > offset)
    if len(hulls) > 1:
        size = np.array([np.ptp(h.centres, axis=0).max() + h.radii.max() for h in hulls])
        yield _parted(hulls, size > 0.5 * size.max())


def _parted(hulls: Sequence[Hull], second: np.ndarray) -> Sides:
    """Assign each whole part to the capsule that it exceeds less; `second` is a first guess."""
    for _ in range(4):
        both = list(zip(hulls, second, strict=True))
        sides = [h for h, there in both if not there], [h for h, there in both if there]
        if not all(sides):
            break
        made = [enclosing(all_balls(side)) for side in sides]
        out = np.array(
            [[_about(c.start, c.end, h.balls)[2] - c.radius for c in made] for h in hulls]
        )
        second = np.where(out[:, 0] == out[:, 1], second, out[:, 1] < out[:, 0])
    return sides


def _cut(hull: Hull, way: np.ndarray, offset: float) -> tuple[Hull | None, Hull | None]:
    """Cut a part by a plane; a part with radii goes whole to the side of its middle."""
    along = hull.centres @ way - offset
    along = np.full_like(along, along.mean()) if hull.radii.any() else along
    if along.max() <= 0.0 or along.min() >= 0.0:
        return (hull, None) if along.max() <= 0.0 else (None, hull)
    faces = _faces(hull.centres)
    pairs = np.column_stack(np.triu_indices(len(along), 1)) if faces is None else faces
    edges = np.concatenate([pairs[:, two] for two in combinations(range(pairs.shape[1]), 2)])
    section = crossings(hull.balls, edges, along)
    below, above = (
        reduced(hull._replace(balls=np.concatenate([hull.balls[side], section])))
        for side in (along <= 0.0, along >= 0.0)
    )
    return below, above


def _faces(points: np.ndarray) -> np.ndarray | None:
    """Return triangles (f, 3) of the hull of points, also if flat; None for too few points."""
    try:
        return np.asarray(ConvexHull(points, qhull_options="QJ").simplices)
    except (QhullError, ValueError):
        return None


def reduced(hull: Hull) -> Hull:
    """Return a part without the corners that lie inside."""
    faces = _faces(hull.centres) if len(hull.balls) > 4 and not hull.radii.any() else None
    return hull if faces is None else hull._replace(balls=hull.balls[np.unique(faces)])


def _axes(points: np.ndarray) -> np.ndarray:
    """Return the principal axes (3, 3) of points."""
    spread = points - points.mean(axis=0)
    return np.linalg.eigh(spread.T @ spread)[1].T


def _about(start: np.ndarray, end: np.ndarray, balls: np.ndarray) -> FittedCapsule:
    """Return the thinnest capsule with given ends that holds balls (n, 4)."""
    radius = (off_segment(balls[:, :3], start, end) + balls[:, 3]).max()
    return FittedCapsule(start, end, float(radius))


def _tries(balls: np.ndarray) -> Iterator[FittedCapsule]:
    """Yield candidate capsules that hold the balls, along the principal axes of their centres."""
    points, radii = balls[:, :3], balls[:, 3:]
    middle = 0.5 * ((points - radii).min(axis=0) + (points + radii).max(axis=0))
    yield _about(middle, middle, balls)
    for axis in _axes(points):
        along = (points - middle) @ axis
        low, high = (along - balls[:, 3]).min(), (along + balls[:, 3]).max()
        centre = middle + 0.5 * (low + high) * axis
        far = _about(centre - 1e3 * axis, centre + 1e3 * axis, balls).radius
        for inset in _INSETS:
            half = max(0.5 * (high - low) - inset * far, 0.0) * axis
            yield _about(centre - half, centre + half, balls)


def enclosing(balls: np.ndarray) -> FittedCapsule:
    """Return a small capsule about balls (n, 4); that of a capsule is itself."""
    if len(balls) < 3 and np.ptp(balls[:, 3]) == 0.0:
        return FittedCapsule(balls[0, :3], balls[-1, :3], float(balls[0, 3]))
    return min(_tries(balls), key=lambda capsule: capsule.volume)


def _fitted(balls: np.ndarray, site: Site) -> FittedCapsule:
    """Return a capsule that lies little beyond the parts, by a search that begins at a guess."""
    if len(balls) < 3 and np.ptp(balls[:, 3]) == 0.0:
        return enclosing(balls)
    best = min(_tries(balls), key=site.cost)
    first = np.concatenate([best.start, best.end])
    found = minimize(
        lambda x: site.cost(_about(x[:3], x[3:], balls)), first, method="Nelder-Mead",
        options={"maxiter": 150, "xatol": 1e-5, "fatol": 1e-12, "adaptive": True,
                 "initial_simplex": first + _NUDGE * best.radius * np.eye(7, 6, -1)},
    )  # fmt: skip
    return min(best, _about(found.x[:3], found.x[3:], balls), key=site.cost)
