"""A 3D view of solids, the arm plane and the arm: parallel projection, back to front.

What is behind the arm plane comes first, then the plane, then what is in front of it; solids that
the plane cuts are cut. Within each of these, faces are sorted by depth.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.colors import to_rgb

from gcm_learn.arms import elbow_position
from gcm_learn.plots.figures import style
from gcm_learn.rendering import Camera, body_colour, faces, shaded
from gcm_learn.scene import pose
from gcm_learn.situation import PLANAR, Cylinder, Plane, Situation, Sphere

HEADROOM = 3.6  # [forearms] what figures show above the shoulder; a long cord goes on
GLASS, GLASS_ALPHA = "#8fbc9a", 0.38  # the arm plane; green, as in Fig. 4
LIMB, JOINT, HAND = 0.055, 0.085, 0.11  # [forearms] radii of the drawn arm
LIMB_LIFT = 0.2  # [forearms] how much nearer the arm counts when faces are sorted by depth
BEHIND, GLASSY, BEFORE = -1, 0, 1  # layers, in the order of drawing


def camera(plane: Plane, azimuth: float = -40.0, elevation: float = 20.0) -> Camera:
    """Return a camera on the side of the arm plane that its normal points to.

    Parameters
    ----------
    plane : Plane
    azimuth, elevation : float
        Degrees to the right of, and above, the normal.
    """
    normal = np.asarray(plane.normal)
    top = np.array([0.0, 0.0, 1.0])
    if abs(normal @ top) > 0.9:  # a lying plane: its y axis is as good an upward as any
        top = np.asarray(plane.y)
    front = normal - (normal @ top) * top
    front /= np.linalg.norm(front)
    side = np.cross(top, front)
    a, e = np.radians(azimuth), np.radians(elevation)
    level = np.cos(a) * front + np.sin(a) * side
    nearer = np.cos(e) * level + np.sin(e) * top
    right = np.cross(top, nearer)
    right /= np.linalg.norm(right)
    return Camera(right, np.cross(nearer, right), nearer)


def draw_scene(
    ax: Axes,
    situation: Situation,
    t: float = 0.0,
    *,
    hand: np.ndarray | tuple[float, float] | None = None,
    view: Camera | None = None,
    headroom: float | None = None,
) -> Axes:
    """Draw a 3D situation at one instant.

    Parameters
    ----------
    ax : Axes
        Ordinary two-dimensional axes.
    situation : Situation
        With a plane.
    t : float
        Time [s].

    Other Parameters
    ----------------
    hand : (2,) array_like, optional
        Hand in arm-plane coordinates; by default the one at t = 0.
    view : Camera, optional
        On the side of the arm plane that its normal points to.
    headroom : float, optional
        Cut the picture off this far above the shoulder [forearms].

    Returns
    -------
    Axes
    """
    if situation.plane is None:
        raise ValueError(f"situation {situation.name!r} is planar: it has no 3D view")
    view = view or camera(situation.plane)
    hand = situation.arm.hand if hand is None else hand
    polygons, colours, nearness = [], [], []
    for corners, colour, alpha, layer in _scenery(situation, t, hand):
        seen = view.see(corners)
        facing = _normal(seen)
        if alpha == 1.0 and facing[2] <= 0.0:
            continue  # the far side of a solid
        polygons.append(seen)
        colours.append((*shaded(np.array(to_rgb(colour)), facing), alpha))
        lift = LIMB_LIFT if colour == style.ARM else 0.0
        nearness.append((layer, seen[:, 2].mean() + lift))
    order = sorted(range(len(nearness)), key=nearness.__getitem__)
    ax.add_collection(
        PolyCollection(
            [polygons[k][:, :2] for k in order],
            facecolors=[colours[k] for k in order],
            edgecolors=[(*colours[k][:3], colours[k][3] ** 2) for k in order],
            linewidths=0.5,
        )
    )
    ax.set_aspect("equal", anchor="N")
    ax.axis("off")
    ax.autoscale_view()
    if headroom is not None:
        top = view.see(np.asarray(situation.plane.origin))[1] + headroom
        ax.set_ylim(top=min(top, ax.get_ylim()[1]))
    return ax


def draw_course(
    ax: Axes, situation: Situation, index: int, end: float, view: Camera | None = None
) -> None:
    """Draw the path of a solid's centre from t = 0 to `end` [s], with an arrow head."""
    assert situation.plane is not None
    times = np.linspace(0.0, end, 60)
    centres = np.array([pose(situation, index, t)[0] for t in times])
    view = view or camera(situation.plane)
    path = view.see(to_world(situation.plane, centres))[:, :2]
    colour = body_colour(situation.bodies[index])
    ax.plot(*path.T, color=colour, lw=1.4, ls=(0, (2, 1.5)), zorder=3)
    style.arrow(ax, path[-2], path[-1], colour)


def label_body(
    ax: Axes, situation: Situation, index: int, text: str, offset: tuple[float, float]
) -> None:
    """Write a word at an offset [forearms] from a solid's centre at t = 0."""
    assert situation.plane is not None
    centre = to_world(situation.plane, pose(situation, index, 0.0)[0])
    seen = camera(situation.plane).see(centre)[:2]
    style.label(ax, seen + offset, text, body_colour(situation.bodies[index]))


def align_views(panels: Sequence[Axes]) -> None:
    """Give several 3D views the same limits, wide enough for all."""
    x, y = (np.array([ax.get_xlim() for ax in panels]), np.array([ax.get_ylim() for ax in panels]))
    for ax in panels:
        ax.set_xlim(x[:, 0].min(), x[:, 1].max())
        ax.set_ylim(y[:, 0].min(), y[:, 1].max())


def to_world(plane: Plane, points: np.ndarray) -> np.ndarray:
    """Arm-plane coordinates (..., 3), or (..., 2) in the plane itself, to world ones (..., 3)."""
    axes = np.array([plane.x, plane.y, plane.normal])[: points.shape[-1]]
    return np.asarray(plane.origin) + points @ axes


Face = tuple[np.ndarray, str, float, int]  # corners (k, 3), colour, opacity, layer


def _scenery(situation: Situation, t: float, hand: np.ndarray | tuple[float, float]) -> list[Face]:
    """All faces in the world frame with their colour, opacity and layer."""
    assert situation.plane is not None
    plane, out = situation.plane, []
    for index, body in enumerate(situation.bodies):
        if isinstance(body.shape, PLANAR):
            continue
        centre, rotation = pose(situation, index, t)
        for face in faces(body.shape):
            for layer in (BEHIND, BEFORE):
                part = beside_plane(centre + face @ rotation.T, layer)
                if len(part) > 2:
                    out.append((to_world(plane, part), body_colour(body), 1.0, layer))
    for tile in _disc_tiles(situation.arm.reach):
        out.append((to_world(plane, tile), GLASS, GLASS_ALPHA, GLASSY))
    for face in _limb(situation, np.asarray(hand, dtype=float)):
        out.append((to_world(plane, face), style.ARM, 1.0, BEFORE))
    return out


def beside_plane(corners: np.ndarray, side: int) -> np.ndarray:
    """Return the part of a convex polygon on one side of the arm plane.

    Parameters
    ----------
    corners : (k, 3) ndarray
        In arm-plane coordinates, in order.
    side : int
        1 for what is in front of the plane, -1 for what is behind it.

    Returns
    -------
    (m, 3) ndarray
        Empty if there is no such part.
    """
    height = side * corners[:, 2]
    if height.min() >= 0.0:
        return corners
    out = []
    for k, here in enumerate(height):
        before = height[k - 1]
        if (here > 0.0) != (before > 0.0):
            share = before / (before - here)
            out.append(corners[k - 1] + share * (corners[k] - corners[k - 1]))
        if here > 0.0:
            out.append(corners[k])
    return np.array(out).reshape(-1, 3)


def _disc_tiles(radius: float) -> list[np.ndarray]:
    """Split a disc into tiles (k, 2), whose seams show how it lies."""
    rings, sectors = np.linspace(0.0, radius, 8), np.linspace(0.0, 2 * np.pi, 49)
    out = []
    for r0, r1 in itertools.pairwise(rings):
        for a, b in itertools.pairwise(sectors):
            corner = [(r0, a), (r1, a), (r1, b), (r0, b)]
            out.append(np.array([(r * np.cos(s), r * np.sin(s)) for r, s in corner]))
    return out


def _limb(situation: Situation, hand: np.ndarray) -> list[np.ndarray]:
    """Faces of the arm in arm-plane coordinates."""
    arm = situation.arm
    shoulder, elbow = np.zeros(2), elbow_position(hand, arm.upper_arm, arm.elbow)
    out = []
    for start, end in ((shoulder, elbow), (elbow, hand)):
        along = (end - start) / np.linalg.norm(end - start)
        frame = np.array([(-along[1], along[0], 0.0), (0.0, 0.0, 1.0), (*along, 0.0)])
        middle = np.array([*(start + end) / 2, 0.0])
        tube = Cylinder(LIMB, float(np.linalg.norm(end - start)) / 2)
        out += [middle + face @ frame for face in faces(tube)]
    for centre, radius in ((shoulder, JOINT), (elbow, JOINT), (hand, HAND)):
        out += [np.array([*centre, 0.0]) + face for face in faces(Sphere(radius))]
    return out


def _normal(corners: np.ndarray) -> np.ndarray:
    """Unit normal of a polygon (k, 3) whose neighbouring corners may coincide."""
    cross = np.cross(corners, np.roll(corners, -1, axis=0)).sum(axis=0)
    size = np.linalg.norm(cross)
    return cross / size if size > 0.0 else np.array([0.0, 0.0, 1.0])
