"""Camera for scenes in space, and rendering of a scene's faces as an image.

All faces are quadrilaterals, some with two equal corners, so that a scene is one array.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from gcm_learn.compiled import njit


@njit(_nrt=False)
def fill(points, shades, image, depth):
    """Paint triangles into an image, where nothing is nearer.

    Parameters
    ----------
    points : (n, 3, 3) ndarray
        Of every corner the column and row in pixels, and its nearness, larger when nearer.
    shades : (n, 3, 3) ndarray
        Red, green and blue of every corner.
    image : (h, w, 3) ndarray
    depth : (h, w) ndarray
        Nearness of what is in front.
    """
    for k in range(points.shape[0]):
        p, c = points[k], shades[k]
        x0, y0, x1, y1, x2, y2 = p[0, 0], p[0, 1], p[1, 0], p[1, 1], p[2, 0], p[2, 1]
        area = (x1 - x0) * (y2 - y0) - (x2 - x0) * (y1 - y0)
        if area == 0.0:
            continue
        left = max(0, int(np.ceil(min(x0, x1, x2) - 0.5)))
        right = min(image.shape[1] - 1, int(np.floor(max(x0, x1, x2) - 0.5)))
        bottom = max(0, int(np.ceil(min(y0, y1, y2) - 0.5)))
        top = min(image.shape[0] - 1, int(np.floor(max(y0, y1, y2) - 0.5)))
        for i in range(bottom, top + 1):
            for j in range(left, right + 1):
                x, y = j + 0.5, i + 0.5
                b = ((x - x0) * (y2 - y0) - (x2 - x0) * (y - y0)) / area
                d = ((x1 - x0) * (y - y0) - (x - x0) * (y1 - y0)) / area
                a = 1.0 - b - d
                if a < 0.0 or b < 0.0 or d < 0.0:
                    continue
                near = a * p[0, 2] + b * p[1, 2] + d * p[2, 2]
                if near <= depth[i, j]:
                    continue
                depth[i, j] = near
                for m in range(3):
                    image[i, j, m] = a * c[0, m] + b * c[1, m] + d * c[2, m]


FINER = 2  # computed pixels a side of a pixel
JUMP = 0.06  # [half pictures] steps in depth that get an outline
INKED = 0.6  # brightness of outlines
RIM = 480  # one part of so many of a picture's side is their width
LIGHT = np.array([0.35, 0.4, 0.85])  # to the light, in the camera's frame: right, up, nearer
HIGHLIGHT = 0.25  # share of white in full light
CLOSEST = 0.8  # [distances of the eye] what comes nearer to it is left out
FOG = 0.5  # share of white in what is farthest away


@dataclass(frozen=True)
class Camera:
    """Camera with a parallel projection, or a perspective projection from an eye at a distance.

    Parameters
    ----------
    right, up, nearer : (3,) ndarray
        Orthonormal: the picture's axes and the direction to the viewer, in the world frame.
    centre : (3,) ndarray
        Point in the middle of the picture; things at its depth are shown in their size.
    distance : float
        From the eye to the centre; infinite for a parallel projection.
    """

    right: np.ndarray
    up: np.ndarray
    nearer: np.ndarray
    centre: np.ndarray = field(default_factory=lambda: np.zeros(3))
    distance: float = np.inf

    def see(self, points: np.ndarray) -> np.ndarray:
        """World points (..., 3) to picture x, y and nearness (..., 3)."""
        seen = self.turned(points - self.centre)
        seen[..., :2] /= 1.0 - seen[..., 2:] / self.distance
        return seen

    def turned(self, vectors: np.ndarray) -> np.ndarray:
        """Vectors (..., 3) of the world in the camera's axes."""
        turned: np.ndarray = vectors @ np.stack([self.right, self.up, self.nearer], axis=1)
        return turned


def camera_from(
    azimuth: float, elevation: float, centre: ArrayLike = (0.0, 0.0, 0.0), distance: float = np.inf
) -> Camera:
    """Return a camera before a centre, with the world's z upwards.

    Parameters
    ----------
    azimuth, elevation : float
        Where the eye is: degrees from the x axis towards y, and above the level.
    centre : (3,) array_like
    distance : float
        Of the eye.
    """
    a, e = np.radians(azimuth), np.radians(elevation)
    nearer = np.array([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)])
    right = np.array([-np.sin(a), np.cos(a), 0.0])
    return Camera(right, np.cross(nearer, right), nearer, np.asarray(centre, float), distance)


class Faces(NamedTuple):
    """Faces of one thing, with the colours, normals and flags for rendering."""

    corners: np.ndarray
    """(n, 4, 3) float: in the world, counter-clockwise when seen from outside."""
    colours: np.ndarray
    """(3,), (n, 1, 3) or (n, 4, 3) float: red, green, blue of all, of faces or of corners."""
    alpha: float = 1.0
    normals: np.ndarray | None = None
    """(n, 4, 3) float: unit, at the corners of what is round; None where faces are flat."""
    both: bool = False
    """Show the faces from behind as well, as the faces of a skin."""
    lit: bool = True
    """Faces that are lit are shaded, and paler far away."""
    kept: bool = False
    """Faces that are kept are in the picture however far they are from the arm."""


class Window(NamedTuple):
    """A square part of a camera's picture."""

    middle: np.ndarray  # (2,) in the picture's coordinates
    half: float

    @property
    def reach(self) -> float:
        """Distance from the picture's origin, where the camera looks, to the farthest side."""
        return float(np.abs(self.middle).max()) + self.half

    @property
    def extent(self) -> tuple[float, float, float, float]:
        """Left, right, bottom and top."""
        (x, y), h = self.middle, self.half
        return (x - h, x + h, y - h, y + h)


def render(view: Camera, window: Window, things: Sequence[Faces], pixels: int) -> np.ndarray:
    """Render things as an image (pixels, pixels, 3), with the first row at the bottom.

    All faces of one alpha below 1 form a pane of glass, in which nearer faces hide the others.
    Panes lie over each other in the order of alpha.

    Parameters
    ----------
    view : Camera
    window : Window
    things : sequence of Faces
    pixels : int
        Of a side; computed twice as finely.
    """
    size = FINER * pixels
    image = np.ones((size, size, 3), dtype=np.float32)
    depth = np.zeros((size, size), dtype=np.float32)  # that of infinity
    for alpha in sorted({thing.alpha for thing in things}, key=lambda a: (a < 1.0, a)):
        pane, front = (image, depth) if alpha == 1.0 else (image.copy(), depth.copy())
        seen = [_triangles(view, window, thing, size) for thing in things if thing.alpha == alpha]
        fill(*(np.concatenate(parts) for parts in zip(*seen, strict=True)), pane, front)
        _outline(pane, front, depth if alpha < 1.0 else None, window.half / view.distance)
        if alpha < 1.0:
            image += np.float32(alpha) * (pane - image)
    parts = [image[i::FINER, j::FINER] for i in range(FINER) for j in range(FINER)]
    return sum(parts[1:], parts[0]) / len(parts)


def _triangles(
    view: Camera, window: Window, thing: Faces, size: int
) -> tuple[np.ndarray, np.ndarray]:
    """Return corners in pixels (m, 3, 3) and colours (m, 3, 3) of the triangles in sight."""
    with np.errstate(divide="ignore"):
        seen = view.see(thing.corners)
    away = _winding(seen[..., :2]) < 0.0
    keep = (seen[..., 2] < CLOSEST * view.distance).all(axis=1) & (thing.both | ~away)
    corners, seen = thing.corners[keep], seen[keep]
    flat = thing.normals is None
    normal = view.turned(normals(corners)[:, None] if flat else thing.normals[keep])  # type: ignore[index]
    normal = np.where(away[keep, None, None], -normal, normal)
    colours = np.broadcast_to(thing.colours, thing.corners.shape)[keep]
    if thing.lit:
        colours = _fogged(shaded(colours, normal), seen[..., 2:], window.half)
    points = np.empty_like(seen)
    points[..., :2] = (seen[..., :2] - window.middle + window.half) * (0.5 * size / window.half)
    points[..., 2] = 1.0 / (1.0 - seen[..., 2] / view.distance)  # linear in the picture
    parts = [[0, 1, 2], [0, 2, 3]]
    return points[:, parts].reshape(-1, 3, 3), colours[:, parts].reshape(-1, 3, 3)


def _winding(corners: np.ndarray) -> np.ndarray:
    """Twice the area (n,) of seen quadrilaterals (n, 4, 2); negative when seen from behind."""
    a, b = corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1]
    return a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]


def _fogged(colours: np.ndarray, nearness: np.ndarray, half: float) -> np.ndarray:
    """Mix colours (..., 3) with white, the more the farther away they are (..., 1)."""
    away = np.clip(-nearness / (1.8 * half), 0.0, 1.0)
    return colours + (1.0 - colours) * FOG * away


def _outline(image: np.ndarray, depth: np.ndarray, behind: np.ndarray | None, scale: float) -> None:
    """Darken the rims of things, where a neighbour is much farther away.

    Parameters
    ----------
    image : (h, w, 3) ndarray
    depth : (h, w) ndarray
    behind : (h, w) ndarray, optional
        Depth of what got its outlines before.
    scale : float
        Of depths.
    """
    wide = max(1, len(image) // RIM)
    farthest = depth.copy()
    for axis in (0, 1):
        for way in (wide, -wide):
            np.minimum(farthest, np.roll(depth, way, axis), out=farthest)
    rim = depth - farthest > JUMP * scale
    if behind is not None:
        rim &= depth > behind
    image[rim] *= INKED


def normals(corners: np.ndarray) -> np.ndarray:
    """Return unit normals (n, 3) of quadrilaterals (n, 4, 3), which may have two equal corners."""
    cross = np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])
    size = np.linalg.norm(cross, axis=1, keepdims=True)
    unit: np.ndarray = np.where(size > 0.0, cross / np.maximum(size, 1e-300), (0.0, 0.0, 1.0))
    return unit


def shaded(colours: np.ndarray, normal: np.ndarray) -> np.ndarray:
    """Lambert's law with much ambient light: faces turned away get darker, never black.

    Parameters
    ----------
    colours : (..., 3) ndarray
    normal : (..., 3) ndarray
        Unit normals in the camera's frame.
    """
    light = LIGHT / np.linalg.norm(LIGHT)
    bright = 0.62 + 0.38 * np.maximum(0.0, normal @ light)[..., None]
    lift = HIGHLIGHT * np.maximum(0.0, bright - 0.8) / 0.2  # towards white in full light
    return np.minimum(1.0, colours * bright + lift * (1 - colours))
