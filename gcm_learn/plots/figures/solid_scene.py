"""A planar arm among solids, drawn with its plane as a pane of glass, over a floor with shadows."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes

from gcm_learn.arms import elbow_position
from gcm_learn.plots.figures import style
from gcm_learn.plots.figures.scenery import show_image
from gcm_learn.rendering import (
    AWAY,
    EYE,
    HAND,
    Camera,
    Faces,
    Limb,
    Window,
    body_colour,
    camera_from,
    limb_faces,
    placed,
    rgb,
    staged,
)
from gcm_learn.scene import pose
from gcm_learn.situation import PLANAR, Plane, Situation

HEADROOM = 3.6  # [forearms] shown above the shoulder; a long cord goes on
STEEP = 0.9  # height of a unit normal beyond which a plane counts as lying
GLASS = ("#8fbc9a", "#84b290")  # green, as in Fig. 4; tiles show how the plane lies
GLASS_ALPHA = 0.38
RINGS, SECTORS = 8, 48  # tiles of the glass
BONE = 0.055  # [forearms] radius of the drawn bones
HELD = 9  # instants of a film that its picture has to hold
MARGIN, UNDER = 0.1, 0.05  # [forearms] about what a film shows, and from it down to the floor
AZIMUTH, ELEVATION = -40.0, 20.0  # [degrees] of the eye, from the normal of the arm's plane


def camera(plane: Plane, azimuth: float = AZIMUTH, elevation: float = ELEVATION) -> Camera:
    """Return a camera in front of the arm's plane, with the world's z upwards.

    Parameters
    ----------
    plane : Plane
    azimuth, elevation : float
        Degrees to the right of the normal, and above the level.
    """
    normal = np.asarray(plane.normal)
    front = normal if abs(normal[2]) <= STEEP else -np.asarray(plane.y)
    towards = float(np.degrees(np.arctan2(front[1], front[0])))
    return camera_from(towards + azimuth, elevation, plane.origin, 2.0 * EYE)


def scene_window(
    situation: Situation, times: Sequence[float], view: Camera | None = None
) -> Window:
    """Return the part of a picture that shows a solid scene at some times [s]."""
    view = view or camera(_plane_of(situation))
    things = [thing for t in times for thing in scene_faces(situation, t)]
    seen = np.concatenate([view.see(thing.corners).reshape(-1, 3) for thing in things])[:, :2]
    low, high = seen.min(axis=0), np.minimum(seen.max(axis=0), (np.inf, HEADROOM))
    return Window(0.5 * (low + high), 0.5 * float((high - low).max()) + MARGIN)


class SolidFilm:
    """Film of a solid scene; the picture holds the whole path of the targets.

    Parameters
    ----------
    situation : Situation
        With a plane.
    end : float
        Of the film [s].
    """

    def __init__(self, situation: Situation, end: float) -> None:
        self.situation, self.end = situation, end
        self.view = camera(_plane_of(situation))
        things = [thing for t in np.linspace(0.0, end, HELD) for thing in self._held(t)]
        corners = np.concatenate([thing.corners.reshape(-1, 3) for thing in things])
        seen = self.view.see(corners)[:, :2]
        low, high = seen.min(axis=0), seen.max(axis=0)
        half = 0.5 * float((high - low).max()) + MARGIN
        self.window = Window(0.5 * (low + high), half)
        self.floor = float(corners[:, 2].min()) - UNDER

    def _held(self, t: float) -> list[Faces]:
        """Return faces that the picture has to hold at t [s]: arm plane, targets, near bodies."""
        situation = self.situation
        plane, reach = _plane_of(situation), situation.arm.reach
        held = [_glass(plane, reach)]
        for index, body in enumerate(situation.bodies):
            if (solid := _solid(situation, index, t)) is not None:
                away = np.linalg.norm(solid.corners - plane.origin, axis=2).max(axis=1)
                near = (away < AWAY * reach) | (body.role == "target")
                held.append(solid._replace(corners=solid.corners[near]))
        return held

    def seen(self, points: np.ndarray) -> np.ndarray:
        """Return points (k, 2) of the arm's plane as they are in the picture."""
        return self.view.see(to_world(_plane_of(self.situation), points))[:, :2]

    def frame(self, ax: Axes) -> None:
        """Frame the picture."""
        style.view_frame(ax, self.window.extent)

    def show(
        self, ax: Axes, t: float, hand: np.ndarray, pixels: int, other: np.ndarray | None = None
    ) -> None:
        """Draw time t [s] with the hand (2,), and an arm with another hand in grey."""
        things = scene_faces(self.situation, t, hand)
        if other is not None:
            grey = rgb(style.FAINT)
            things += [part._replace(colours=grey) for part in limb_in_plane(self.situation, other)]
        show_image(ax, staged(self.view, self.window, self.floor, things, pixels), self.window)


def draw_scene(
    ax: Axes,
    situation: Situation,
    t: float = 0.0,
    *,
    hand: np.ndarray | tuple[float, float] | None = None,
    window: Window | None = None,
) -> Axes:
    """Draw a solid scene at one instant.

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
        Hand in arm-plane coordinates; by default the hand at t = 0.
    window : Window, optional
        Part of the picture; by default `scene_window` at that instant.

    Returns
    -------
    Axes
    """
    view = camera(_plane_of(situation))
    window = window or scene_window(situation, [t], view)
    things = scene_faces(situation, t, hand)
    floor = min(float(thing.corners[..., 2].min()) for thing in things) - UNDER
    show_image(ax, staged(view, window, floor, things), window)
    return ax


def scene_faces(
    situation: Situation, t: float, hand: np.ndarray | tuple[float, float] | None = None
) -> list[Faces]:
    """Solids, the glass of the arm's plane and the arm at time t [s], in the world."""
    arm = situation.arm
    solids = [_solid(situation, index, t) for index in range(len(situation.bodies))]
    things = [
        _glass(_plane_of(situation), arm.reach),
        *(solid for solid in solids if solid is not None),
    ]
    return things + limb_in_plane(situation, arm.hand if hand is None else hand)


def limb_in_plane(situation: Situation, hand: np.ndarray | tuple[float, float]) -> list[Faces]:
    """Return the faces, in the world, of the arm with its hand (2,) in arm-plane coordinates."""
    arm, end = situation.arm, np.asarray(hand, dtype=float)
    elbow = elbow_position(end, arm.upper_arm, arm.elbow)
    joints = to_world(_plane_of(situation), np.array([np.zeros(2), elbow, end]))
    ends = np.array([[joints[:2], joints[1:]]])
    return limb_faces(Limb(ends, np.full(2, BONE), joints[2:], joints[0]))


def _solid(situation: Situation, index: int, t: float) -> Faces | None:
    """Return the faces of a body at time t [s], in the world; None if its shape is planar."""
    body, plane = situation.bodies[index], _plane_of(situation)
    if isinstance(body.shape, PLANAR):
        return None
    centre, rotation = pose(situation, index, t)
    turn = np.array([plane.x, plane.y, plane.normal]).T @ rotation
    return placed(body.shape, to_world(plane, centre), turn, rgb(body_colour(body)))


def draw_course(ax: Axes, situation: Situation, index: int, end: float) -> None:
    """Draw the path of a solid's centre from t = 0 to `end` [s], with an arrow head."""
    plane = _plane_of(situation)
    centres = np.array([pose(situation, index, t)[0] for t in np.linspace(0.0, end, 60)])
    path = camera(plane).see(to_world(plane, centres))[:, :2]
    colour = body_colour(situation.bodies[index])
    ax.plot(*path.T, color=colour, lw=1.4, ls=(0, (2, 1.5)), zorder=3)
    style.arrow(ax, path[-2], path[-1], colour)


def label_body(
    ax: Axes, situation: Situation, index: int, text: str, offset: tuple[float, float]
) -> None:
    """Write a word at an offset [forearms] from a solid's centre at t = 0."""
    plane = _plane_of(situation)
    seen = camera(plane).see(to_world(plane, pose(situation, index, 0.0)[0]))[:2]
    style.label(ax, seen + offset, text, body_colour(situation.bodies[index]))


def to_world(plane: Plane, points: np.ndarray) -> np.ndarray:
    """Convert arm-plane coordinates (..., 3), or (..., 2) in the plane, to world ones (..., 3)."""
    axes = np.array([plane.x, plane.y, plane.normal])[: points.shape[-1]]
    return np.asarray(plane.origin) + points @ axes


def _plane_of(situation: Situation) -> Plane:
    if situation.plane is None:
        raise ValueError(f"situation {situation.name!r} is planar: it has no 3D view")
    return situation.plane


def _glass(plane: Plane, radius: float) -> Faces:
    """Disc of the arm's reach in tiles of two shades, just behind the arm."""
    r, a = np.linspace(0.0, radius, RINGS + 1), np.linspace(0.0, 2.0 * np.pi, SECTORS + 1)
    points = np.stack([np.outer(r, np.cos(a)), np.outer(r, np.sin(a))], axis=-1)
    corners = [points[:-1, :-1], points[1:, :-1], points[1:, 1:], points[:-1, 1:]]
    tiles = np.stack(corners, axis=2).reshape(-1, 4, 2)
    shade = np.add.outer(np.arange(RINGS), np.arange(SECTORS)).ravel() % 2
    colours = np.array([rgb(name) for name in GLASS])[shade][:, None]
    behind = np.sign(camera(plane).nearer @ plane.normal) * HAND * BONE * np.array(plane.normal)
    return Faces(to_world(plane, tiles) - behind, colours, GLASS_ALPHA, both=True, lit=False)
