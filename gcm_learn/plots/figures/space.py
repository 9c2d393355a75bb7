"""The arm in space among its bodies: at one instant, or over a movement.

Everything stands over a floor that shows its shadow, and a line drawn through solids shows what
they hide.  Paths are coloured by time; what has the same colour is there at the same time.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.colors import LinearSegmentedColormap, to_rgb
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from numpy.typing import ArrayLike

from gcm_learn.arms import SpatialArm, forward_in_space
from gcm_learn.plots.figures import style
from gcm_learn.plots.figures.rendering import Camera, Faces, Window, camera_from, render
from gcm_learn.plots.figures.solids import placed, tube
from gcm_learn.plots.figures.staging import (
    PIXELS,
    SpatialSituation,
    box_of,
    centred,
    floor_of,
    show_image,
    staged,
    turned_view,
    window_of,
)
from gcm_learn.plots.figures.workspace import body_colour
from gcm_learn.scene import pack_bodies, poses_at
from gcm_learn.situation import Capsule, Sphere, arm_frame

if TYPE_CHECKING:
    from gcm_learn.motion import SpatialTrajectory

TIME_COLOURS = LinearSegmentedColormap.from_list(
    "time", ["#fbc65d", "#ef7b5a", "#c2427f", style.PATH]
)
THINNEST = 0.022  # of the reach: thinner bones are drawn so thick
BALL, HAND = 1.12, 1.3  # radii of joints and hand, in those of the bones
LINE = 0.007  # of the reach: radius of a path
SAMPLES = 60  # points of a path
GHOSTS = 4  # instants at which the arm is drawn, the last one being the catch
PALEST = 0.15  # alpha of the earliest
SIGHT = 28  # pixels a side of pictures that are tried for what they hide
EYE = 7.0  # [reaches] distance of the eye
ELEVATION = 24.0  # [degrees] of the eye
JOINT = "#f3dfe3"


def body_poses(situation: SpatialSituation, times: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
    """Where the bodies are at some times, in the world.

    Parameters
    ----------
    situation : Situation
        With a spatial arm.
    times : (k,) array_like
        [s]

    Returns
    -------
    centres : (k, m, 3) ndarray
    rotations : (k, m, 3, 3) ndarray
        Columns are the bodies' axes.
    """
    bodies, (axes, origin) = pack_bodies(situation), arm_frame(situation)
    instants = np.atleast_1d(np.asarray(times, dtype=float))
    out = np.zeros((len(instants), len(situation.bodies), 12))
    out[..., 3:] = np.eye(3).ravel()  # spheres leave it so
    for t, poses in zip(instants, out, strict=True):
        poses_at(bodies, t, poses)
    turns = axes.T @ out[..., 3:].reshape(*out.shape[:2], 3, 3)
    return out[..., :3] @ axes + origin, turns


def bone_radius(arm: SpatialArm) -> float:
    """Radius with which the bones are drawn."""
    return max(arm.thickness, THINNEST * arm.reach)


def arm_faces(arm: SpatialArm, joints: ArrayLike, alpha: float = 1.0) -> list[Faces]:
    """The arm as two capsules, with balls for shoulder, elbow and hand.

    Parameters
    ----------
    arm : SpatialArm
    joints : (4,) array_like
        [rad]
    alpha : float
    """
    elbow, hand = forward_in_space(arm, joints)
    shoulder, radius = np.asarray(arm.base.origin), bone_radius(arm)
    out = []
    for a, b in ((shoulder, elbow), (elbow, hand)):
        length = float(np.linalg.norm(b - a))
        turn = frame_along((b - a) / length)
        bone = Capsule(radius, length / 2)
        out.append(placed(bone, (a + b) / 2, turn, np.array(to_rgb(style.ARM)), alpha))
    for centre, size, colour in (
        (shoulder, BALL, style.INK), (elbow, BALL, JOINT), (hand, HAND, style.ARM),
    ):  # fmt: skip
        ball = Sphere(size * radius)
        out.append(placed(ball, centre, np.eye(3), np.array(to_rgb(colour)), alpha))
    return out


def frame_along(z: np.ndarray) -> np.ndarray:
    """A rotation (3, 3) whose third column is a unit vector."""
    x = np.cross(np.eye(3)[np.abs(z).argmin()], z)
    x /= np.linalg.norm(x)
    return np.column_stack([x, np.cross(z, x), z])


def body_faces(
    situation: SpatialSituation, t: float, alpha: float = 1.0, roles: Sequence[str] = ()
) -> Iterator[Faces]:
    """Yield the bodies at time t [s], or those in some roles."""
    centres, turns = body_poses(situation, [t])
    for body, centre, turn in zip(situation.bodies, centres[0], turns[0], strict=True):
        if not roles or body.role in roles:
            colour = np.array(to_rgb(body_colour(body)))
            yield placed(body.shape, centre, turn, colour, alpha)  # type: ignore[arg-type]


def view_of(
    situation: SpatialSituation,
    trajectory: SpatialTrajectory | None = None,
    *,
    elevation: float = ELEVATION,
    turn: float = 0.0,
) -> Camera:
    """Return a camera that sees arm and hand's way from the side, and little in front of them.

    Parameters
    ----------
    situation : Situation
        With a spatial arm.
    trajectory : SpatialTrajectory, optional

    Other Parameters
    ----------------
    elevation : float
        Of the eye [degrees].
    turn : float
        The camera is turned about the vertical by so much [degrees].
    """
    arm = situation.arm
    end = situation.horizon if trajectory is None else trajectory.duration
    times = np.linspace(0.0, end, 12)
    joints = np.tile(arm.joints, (12, 1)) if trajectory is None else trajectory.joints_at(times)
    elbow, hand = forward_in_space(arm, joints)
    centres, _ = body_poses(situation, times[-3:])
    target = [body.role == "target" for body in situation.bodies]
    shoulder = np.asarray(arm.base.origin)
    seen = np.concatenate([shoulder[None], elbow, hand, hand, centres[:, target].reshape(-1, 3)])
    centre = 0.5 * (shoulder + hand.mean(axis=0))
    wanted = [*arm_faces(arm, joints[-1]), *body_faces(situation, end, roles=("target",))]
    wanted += [] if trajectory is None else path_faces(situation, trajectory)
    others = list(body_faces(situation, end, roles=("obstacle",)))

    def merit(azimuth: float) -> float:
        view = camera_from(azimuth, elevation, centre, EYE * arm.reach)
        flat = view.turned(seen - centre)[:, :2]
        spread = np.sqrt(np.linalg.det(np.cov(flat.T)) + 1e-12) / arm.reach**2
        return float(spread * _share_in_sight(view, arm.reach, wanted, others) ** 2)

    best = max(np.arange(0.0, 360.0, 20.0), key=merit)
    return camera_from(best + turn, elevation, centre, EYE * arm.reach)


def _share_in_sight(
    view: Camera, reach: float, wanted: Sequence[Faces], others: Sequence[Faces]
) -> float:
    """Share of what is wanted in a picture that others leave in sight."""
    red, blue = np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0])
    marked = [thing._replace(colours=red, lit=False) for thing in wanted]
    hiding = [thing._replace(colours=blue, lit=False) for thing in others]
    window = Window(np.zeros(2), reach)
    images = [render(view, window, things, SIGHT) for things in (marked, marked + hiding)]
    whole, rest = ((image[..., 0] > 1.2 * image[..., 2]).sum() for image in images)
    return float(rest / max(whole, 1))


def draw_space(
    ax: Axes,
    situation: SpatialSituation,
    t: float = 0.0,
    *,
    joints: ArrayLike | None = None,
    view: Camera | None = None,
    pixels: int = PIXELS,
) -> Axes:
    """Draw the arm and the bodies at one instant.

    Parameters
    ----------
    ax : Axes
        Ordinary two-dimensional axes.
    situation : Situation
        With a spatial arm.
    t : float
        Time [s].

    Other Parameters
    ----------------
    joints : (4,) array_like, optional
        By default those at t = 0 [rad].
    view : Camera, optional
        By default `view_of` the situation.
    pixels : int
        Of a side.
    """
    posture = situation.arm.joints if joints is None else joints
    view = view or view_of(situation)
    things = [*body_faces(situation, t), *arm_faces(situation.arm, posture)]
    window = window_of(situation, view, things)
    show_image(ax, staged(view, window, floor_of(situation, things), things, pixels), window)
    return ax


def draw_courses_in_space(ax: Axes, situation: SpatialSituation, end: float, view: Camera) -> None:
    """Draw an arrow along the way of every body that moves until `end` [s]."""
    centres, _ = body_poses(situation, np.linspace(0.0, end, SAMPLES))
    for k, body in enumerate(situation.bodies):
        if np.ptp(centres[:, k], axis=0).max() < 0.05 * situation.arm.reach:
            continue
        path = view.see(centres[:, k])
        ax.plot(
            *path[:, :2].T, color=body_colour(body), lw=1.2, ls=(0, (2, 1.5)), zorder=4,
            path_effects=[style.HALO],
        )  # fmt: skip
        style.arrow(ax, path[-2, :2], path[-1, :2], body_colour(body))


class Scenery:
    """A spatial situation as seen by a camera, in the same picture at every instant.

    Parameters
    ----------
    situation : Situation
        With a spatial arm.
    trajectory : SpatialTrajectory, optional
        Without one the arm rests.
    view : Camera, optional
        By default `view_of` them.  It is moved so that all is in the picture.
    turns : bool
        Whether it will be turned, and all is to stay in the picture.
    """

    def __init__(
        self,
        situation: SpatialSituation,
        trajectory: SpatialTrajectory | None = None,
        view: Camera | None = None,
        *,
        turns: bool = False,
    ) -> None:
        self.situation, self.trajectory = situation, trajectory
        self.view = view or view_of(situation, trajectory)
        self.end = situation.horizon if trajectory is None else trajectory.duration
        things = [thing for t in np.linspace(0.0, self.end, 4) for thing in self.at(t)]
        self.view = centred(situation, self.view, things)
        views = [turned_view(self.view, turn) for turn in range(0, 360, 30 if turns else 360)]
        half = max(window_of(situation, view, things).reach for view in views)
        self.window = Window(np.zeros(2), half)
        self.floor = floor_of(situation, things)
        self.box = np.stack(box_of(situation, things), axis=1)
        self.box[2, 0] = self.floor
        self._drawn: tuple[float, float, int, np.ndarray] = (-1.0, 0.0, 0, np.empty(0))

    def at(self, t: float) -> list[Faces]:
        """Everything at time t [s], with the ways of hand and target until then."""
        things = list(body_faces(self.situation, t))
        if self.trajectory is None:
            return things + arm_faces(self.situation.arm, self.situation.arm.joints)
        things += arm_faces(self.situation.arm, self.trajectory.joints_at(t))
        if t > 0.0:
            things += path_faces(self.situation, self.trajectory, t)
        return things

    def show_world(self, ax: Axes, t: float) -> None:
        """Draw the bodies at time t [s], and the arm as it was at t = 0."""
        arm = self.situation.arm
        things = [*body_faces(self.situation, t), *arm_faces(arm, arm.joints)]
        show_image(ax, staged(self.view, self.window, self.floor, things), self.window)

    def show(self, ax: Axes, t: float, turn: float = 0.0, pixels: int = PIXELS) -> None:
        """Draw time t [s], from a camera that is turned about the vertical [degrees]."""
        if self._drawn[:3] != (t, turn, pixels):
            view, things = turned_view(self.view, turn), self.at(t)
            image = staged(view, self.window, self.floor, things, pixels)
            self._drawn = (t, turn, pixels, image)
        show_image(ax, self._drawn[3], self.window)


def draw_movement_in_space(
    ax: Axes,
    situation: SpatialSituation,
    trajectory: SpatialTrajectory,
    view: Camera | None = None,
    *,
    count: int = GHOSTS,
    pixels: int = PIXELS,
) -> Axes:
    """Draw a movement: the arm at several instants, later ones darker, with the hand's way.

    Bodies are as at the end; paler ones show where they were before.
    """
    view = view or view_of(situation, trajectory)
    end = trajectory.duration
    things = [*path_faces(situation, trajectory)]
    moments = _moments(situation.arm, trajectory, count)
    for t, alpha in zip(moments, [*np.linspace(PALEST, 0.5, len(moments) - 1), 1.0], strict=True):
        things += body_faces(situation, t, alpha)
        things += arm_faces(situation.arm, trajectory.joints_at(t), alpha)
    window = window_of(situation, view, things)
    show_image(ax, staged(view, window, floor_of(situation, things), things, pixels), window)
    show_through(ax, view, trajectory.hand_at(np.linspace(0.0, end, SAMPLES)))
    return ax


def _moments(arm: SpatialArm, trajectory: SpatialTrajectory, count: int) -> np.ndarray:
    """Instants evenly over the movement; fewer where the hand hardly moves."""
    fitting = 1 + int(trajectory.length / (3.0 * HAND * bone_radius(arm)))
    return np.linspace(0.0, trajectory.duration, min(max(fitting, 2), count))


def path_faces(situation: SpatialSituation, trajectory: SpatialTrajectory,
               until: float | None = None) -> Iterator[Faces]:  # fmt: skip
    """Yield the ways of the hand, and of the targets dashed, coloured by time."""
    end = trajectory.duration
    last = end if until is None else until
    times = np.linspace(0.0, last, SAMPLES)
    radius = LINE * situation.arm.reach
    shades = TIME_COLOURS(0.5 * (times[1:] + times[:-1]) / max(end, 1e-9))[:, :3]
    hand = trajectory.hand_at(times)
    if np.ptp(hand, axis=0).max() > radius:
        yield Faces(tube(hand, radius), np.repeat(shades, 6, axis=0)[:, None])
    centres, _ = body_poses(situation, times)
    for k, body in enumerate(situation.bodies):
        if body.role == "target" and np.ptp(centres[:, k], axis=0).max() > radius:
            path = tube(centres[:, k], 0.8 * radius).reshape(-1, 6, 4, 3)
            dashes = np.arange(len(path)) % 3 != 2
            yield Faces(
                path[dashes].reshape(-1, 4, 3), np.repeat(shades[dashes], 6, axis=0)[:, None]
            )


def show_through(ax: Axes, view: Camera, path: np.ndarray, alpha: float = 0.4) -> None:
    """Draw a path (k, 3) once more over everything; faint, so that what hides it shows."""
    seen = view.see(path)[:, :2]
    shades = TIME_COLOURS(np.linspace(0.0, 1.0, len(seen) - 1))
    ax.add_collection(
        LineCollection(
            list(np.stack([seen[:-1], seen[1:]], axis=1)), colors=shades, linewidths=1.6,
            alpha=alpha, zorder=3,
        )
    )  # fmt: skip


def time_bar(ax: Axes, end: float) -> None:
    """Explain the colours of paths in the lower left corner of a picture."""
    bar = ax.inset_axes((0.03, 0.02, 0.3, 0.022), zorder=20)
    bar.imshow(np.linspace(0.0, 1.0, 128)[None], cmap=TIME_COLOURS, aspect="auto")
    bar.axis("off")
    for x, text in ((0.0, "0"), (1.0, f"{end:.2f} s")):
        bar.text(
            x, 1.5, text, transform=bar.transAxes, fontsize=style.SMALL, color=style.INK,
            ha="left" if x == 0.0 else "right", va="bottom", path_effects=[style.HALO],
        )  # fmt: skip


def key_in_space(figure: Figure) -> None:
    """Say below pictures of movements what is what."""
    tint = TIME_COLOURS(0.65)
    handles = [
        Patch(color=style.ARM, label="arm"),
        Patch(color=style.TARGET, label="target"),
        Patch(color=style.OBSTACLE, label="obstacle"),
        Line2D([], [], color=tint, lw=2.5, label="hand's way"),
        Line2D([], [], color=tint, lw=2.0, ls=(0, (2, 1)), label="target's way"),
    ]
    figure.legend(
        handles=handles, loc="outside lower center", ncols=len(handles), fontsize=style.SMALL,
        frameon=False, labelcolor=style.INK, handlelength=1.6, columnspacing=1.4,
    )  # fmt: skip
