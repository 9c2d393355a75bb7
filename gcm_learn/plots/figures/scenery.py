"""An arm among solids before a camera: at one instant, or over a movement.

Everything stands over a floor that shows its shadow, and a line drawn through solids shows what
they hide.  Paths are coloured by time; places of one colour belong to one time.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from gcm_learn.plots.figures import style
from gcm_learn.rendering import (
    APPROACH,
    HAND,
    PIXELS,
    SAMPLES,
    SHADES,
    TIME,
    Camera,
    Faces,
    JointSituation,
    Window,
    arm_faces,
    body_colour,
    body_faces,
    body_poses,
    box_of,
    centred,
    floor_of,
    limb_along,
    path_faces,
    staged,
    turned_view,
    view_of,
    window_of,
)

if TYPE_CHECKING:
    from gcm_learn.motion import Movement

TIME_COLOURS = LinearSegmentedColormap.from_list("time", TIME, N=SHADES)
GHOSTS = 4  # instants at which the arm is drawn, the last one being the catch
PALEST = 0.15  # alpha of the earliest


def draw_start(
    ax: Axes, situation: JointSituation, view: Camera | None = None, pixels: int = PIXELS
) -> Axes:
    """Draw arm and bodies at t = 0.

    Parameters
    ----------
    ax : Axes
        Ordinary two-dimensional axes.
    situation : Situation
        With an arm that moves in its joints.
    view : Camera, optional
        By default `view_of` the situation.
    pixels : int
        Of a side.
    """
    view = view or view_of(situation)
    things = [*body_faces(situation, 0.0), *arm_faces(situation.arm, situation.arm.joints)]
    window = window_of(situation, view, things)
    show_image(ax, staged(view, window, floor_of(situation, things), things, pixels), window)
    return ax


def show_image(ax: Axes, image: np.ndarray, window: Window) -> None:
    """Show an image in axes that have its camera's coordinates."""
    ax.imshow(
        image, origin="lower", extent=window.extent, zorder=1, interpolation="antialiased"
    )  # fmt: skip
    left, right, bottom, top = window.extent
    ax.set(xlim=(left, right), ylim=(bottom, top))
    ax.axis("off")


def draw_courses(ax: Axes, situation: JointSituation, end: float, view: Camera) -> None:
    """Draw an arrow along the path of every body that moves until `end` [s]."""
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
    """An arm among solids as seen by a camera, in the same picture at every instant.

    Parameters
    ----------
    situation : Situation
        With an arm that moves in its joints.
    trajectory : Movement, optional
        Without one the arm rests.
    view : Camera, optional
        By default `view_of` them.  The camera is moved so that the picture holds everything.
    turns : bool
        The picture holds everything while the camera turns, too.
    """

    def __init__(
        self,
        situation: JointSituation,
        trajectory: Movement | None = None,
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
        """Return everything at time t [s], with the paths of hand and target until then."""
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


def draw_poses(
    ax: Axes,
    situation: JointSituation,
    trajectory: Movement,
    view: Camera | None = None,
    *,
    count: int = GHOSTS,
    pixels: int = PIXELS,
) -> Axes:
    """Draw a movement: the arm at several instants, later ones darker, with the hand's path.

    Bodies are as at the end; paler ones show where they were before.
    """
    view = view or view_of(situation, trajectory)
    end = trajectory.duration
    things = [*path_faces(situation, trajectory)]
    moments = _moments(situation, trajectory, count)
    for t, alpha in zip(moments, [*np.linspace(PALEST, 0.5, len(moments) - 1), 1.0], strict=True):
        things += body_faces(situation, t, alpha)
        things += arm_faces(situation.arm, trajectory.joints_at(t), alpha)
    window = window_of(situation, view, things)
    show_image(ax, staged(view, window, floor_of(situation, things), things, pixels), window)
    show_through(ax, view, trajectory.hand_at(np.linspace(0.0, end, SAMPLES)))
    return ax


def _moments(situation: JointSituation, trajectory: Movement, count: int) -> np.ndarray:
    """Return instants evenly over the movement; fewer where the hand hardly moves."""
    arm = situation.arm
    thin = limb_along(arm, np.atleast_2d(arm.joints)).radii.min()
    fitting = 1 + int(trajectory.length / (3.0 * HAND * thin))
    return np.linspace(0.0, trajectory.duration, min(max(fitting, 2), count))


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


def key_below(figure: Figure, situation: JointSituation) -> None:
    """Explain the colours below pictures of movements."""
    tint = TIME_COLOURS(0.65)
    handles: list[Patch | Line2D] = [
        Patch(color=style.ARM, label="arm"),
        Patch(color=style.TARGET, label="target"),
        Patch(color=style.OBSTACLE, label="obstacle"),
        Line2D([], [], color=tint, lw=2.5, label="hand's path"),
        Line2D([], [], color=tint, lw=2.0, ls=(0, (2, 1)), label="target's path"),
    ]
    if any(body.approach is not None for body in situation.bodies):
        handles[2:2] = [Patch(color=APPROACH, label="approach")]
    figure.legend(
        handles=handles, loc="outside lower center", ncols=len(handles), fontsize=style.SMALL,
        frameon=False, labelcolor=style.INK, handlelength=1.6, columnspacing=1.4,
    )  # fmt: skip
