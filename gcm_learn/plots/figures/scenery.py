"""Pictures of an arm among solids, at one instant or over a movement.

Everything stands over a floor that shows its shadow, and a line drawn through solids shows what
they hide.  Paths are coloured by time; places of one colour belong to one time.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Circle, Patch

from gcm_learn import rendering
from gcm_learn.arms import hands_along
from gcm_learn.plots.figures import style

if TYPE_CHECKING:
    from gcm_learn.motion import Movement

TIME_COLOURS = LinearSegmentedColormap.from_list("time", rendering.TIME, N=rendering.SHADES)
GHOSTS = 4  # instants at which the arm is drawn, the last one being the catch
PALEST = 0.15  # alpha of the earliest
RIM = 0.6  # alpha of the rims of targets
SEEN = 0.02  # of half a film's picture: radius of the smallest target
HELD = 6  # instants of a movement that a film's picture has to hold
WHOLE = 1.8  # [reaches] from the base: obstacles up to there are whole in a film
MARGIN = 0.05  # [reaches] about what a film's picture holds
PLACED: dict[str, Any] = {"marker": "x", "ls": "", "ms": 9, "color": style.GOOD, "mew": 2.2}
HELD_AS: dict[str, Any] = {"lw": 4.5, "color": style.INK, "zorder": 3.5}
ABREAST = 7  # entries of a key; more are set in two rows
EYES = 2.0  # distance of a film's eye, in that of the farthest target


def draw_start(
    ax: Axes,
    situation: rendering.JointSituation,
    view: rendering.Camera | None = None,
    pixels: int = rendering.PIXELS,
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
    view = view or rendering.view_of(situation)
    things = [
        *rendering.body_faces(situation, 0.0),
        *rendering.arm_faces(situation.arm, situation.arm.joints),
    ]
    window = rendering.window_of(situation, view, things)
    show_image(
        ax,
        rendering.staged(view, window, rendering.floor_of(situation, things), things, pixels),
        window,
    )
    return ax


def show_image(ax: Axes, image: np.ndarray, window: rendering.Window) -> None:
    """Show an image in axes with the coordinates of the camera's window."""
    ax.imshow(
        image, origin="lower", extent=window.extent, zorder=1, interpolation="antialiased"
    )  # fmt: skip
    left, right, bottom, top = window.extent
    ax.set(xlim=(left, right), ylim=(bottom, top))
    ax.axis("off")


def draw_courses(
    ax: Axes, situation: rendering.JointSituation, end: float, view: rendering.Camera
) -> None:
    """Draw an arrow along the path of every body that moves until `end` [s]."""
    centres, _ = rendering.body_poses(situation, np.linspace(0.0, end, rendering.SAMPLES))
    for k, body in enumerate(situation.bodies):
        if np.ptp(centres[:, k], axis=0).max() < 0.05 * situation.arm.reach:
            continue
        path = view.see(centres[:, k])
        ax.plot(
            *path[:, :2].T, color=rendering.body_colour(body), lw=1.2, ls=(0, (2, 1.5)), zorder=4,
            path_effects=[style.HALO],
        )  # fmt: skip
        style.arrow(ax, path[-2, :2], path[-1, :2], rendering.body_colour(body))


class Scenery:
    """An arm among solids as seen by a camera that stays.

    The picture is the same at every instant, unless a target comes from far away: then it is
    larger until the target is near.

    Parameters
    ----------
    situation : Situation
        With an arm that moves in its joints.
    trajectory : Movement, optional
        Without one the arm rests.
    view : Camera, optional
        By default `view_of` them.  The camera is moved so that the picture holds the arm, the way
        of the target that is met, and obstacles near the arm.
    turns : bool
        The picture holds all this while the camera turns, too.
    catches : sequence of mapping
        Of the plan, whose holds are shown.
    """

    def __init__(
        self,
        situation: rendering.JointSituation,
        trajectory: Movement | None = None,
        view: rendering.Camera | None = None,
        *,
        turns: bool = False,
        catches: Sequence[Mapping[str, Any]] = (),
    ) -> None:
        self.situation, self.trajectory, self.catches = situation, trajectory, catches
        self.end = situation.horizon if trajectory is None else trajectory.duration
        self.way = self._way()
        held = [part for t in np.linspace(0.0, self.end, HELD) for part in self._held(t)]
        held.append(self.way.faces(self.way.near))
        seen = rendering.centred(situation, view or rendering.view_of(situation, trajectory), held)
        far = float(np.linalg.norm(self.way.corners - seen.centre, axis=-1).max())
        self.view = replace(seen, distance=max(seen.distance, EYES * far))
        views = [
            rendering.turned_view(self.view, turn) for turn in range(0, 360, 30 if turns else 360)
        ]
        half = max(rendering.window_of(situation, view, held).reach for view in views)
        self.window = rendering.Window(np.zeros(2), half)
        self.floor = rendering.floor_of(situation, [*held, self.way.faces()])
        self.held = held
        self._drawn: tuple[float, float, int, np.ndarray] = (-1.0, 0.0, 0, np.empty(0))

    def places(self, times: np.ndarray) -> np.ndarray:
        """Return the centres (m, k, 3) of the targets at times (k,) [s], in the world."""
        return rendering.target_paths(self.situation, times)

    def _way(self) -> rendering.TargetWay:
        """Return the way of the target to which the hand comes nearest."""
        times, arm = np.linspace(0.0, self.end, rendering.SAMPLES), self.situation.arm
        moves = self.trajectory
        hands = hands_along(arm, arm.joints)[0] if moves is None else moves.hand_at(times)
        return rendering.target_way(self.situation, times, self.places(times), hands)

    def _held(self, t: float) -> Iterator[rendering.Faces]:
        """Yield all things at time t [s]; whole things near the arm are marked `kept`."""
        arm = self.situation.arm
        base = np.asarray(arm.base.origin)
        for thing in self.at(t):
            away = np.linalg.norm(thing.corners - base, axis=2) / arm.reach
            yield thing._replace(kept=bool(away.min() < rendering.AWAY and away.max() < WHOLE))

    def window_at(self, t: float) -> rendering.Window:
        """Return the part of the picture at time t [s], larger while the target is far away."""
        ahead = self.way.reach_seen(self.view, t) + MARGIN * self.situation.arm.reach
        return rendering.Window(self.window.middle, max(self.window.half, ahead))

    def at(self, t: float) -> list[rendering.Faces]:
        """Return everything at time t [s], with the paths of hand and target until then."""
        things = list(rendering.body_faces(self.situation, t))
        if self.trajectory is None:
            return things + rendering.arm_faces(self.situation.arm, self.situation.arm.joints)
        things += rendering.arm_faces(self.situation.arm, self.trajectory.joints_at(t))
        if t > 0.0:
            things += rendering.path_faces(self.situation, self.trajectory, t)
        return things

    def show_world(self, ax: Axes, t: float) -> None:
        """Draw the bodies at time t [s], and the arm at t = 0."""
        arm = self.situation.arm
        things = [*rendering.body_faces(self.situation, t), *rendering.arm_faces(arm, arm.joints)]
        window = self.window_at(t)
        show_image(ax, rendering.staged(self.view, window, self.floor, things), window)

    def show(self, ax: Axes, t: float, turn: float = 0.0, pixels: int = rendering.PIXELS) -> None:
        """Draw time t [s], from a camera that is turned about the vertical [degrees]."""
        if self._drawn[:3] != (t, turn, pixels):
            view, things = rendering.turned_view(self.view, turn), self.at(t)
            image = rendering.staged(view, self.window_at(t), self.floor, things, pixels)
            self._drawn = (t, turn, pixels, image)
        show_image(ax, self._drawn[3], self.window_at(t))
        self._show_targets(ax, t, turn)
        view = rendering.turned_view(self.view, turn)
        draw_asked(ax, self.situation, view, self.trajectory, self.catches, t)

    def _show_targets(self, ax: Axes, t: float, turn: float) -> None:
        """Draw the rims of the targets over the image, so that they show; far targets as discs."""
        view, smallest = rendering.turned_view(self.view, turn), SEEN * self.window_at(t).half
        for body, place in zip(self.situation.targets, self.places(np.array([t])), strict=True):
            radius = rendering.drawn_scale(self.situation, body) * body.shape.bounding_radius
            (x, y, _), (side, _, _) = view.see(place[0] + np.outer((0.0, radius), view.right))
            far = side - x < smallest
            disc = Circle((x, y), max(side - x, smallest), fill=far, color=style.TARGET, lw=0.8)
            disc.set(alpha=1.0 if far else RIM, zorder=3)
            ax.add_patch(disc)


def draw_poses(
    ax: Axes,
    situation: rendering.JointSituation,
    trajectory: Movement,
    view: rendering.Camera | None = None,
    *,
    count: int = GHOSTS,
    pixels: int = rendering.PIXELS,
    catches: Sequence[Mapping[str, Any]] = (),
) -> Axes:
    """Draw a movement: the arm at several instants, later ones darker, with the hand's path.

    Bodies are as at the end; paler ones show where they were before.
    """
    view = view or rendering.view_of(situation, trajectory)
    end = trajectory.duration
    things = [*rendering.path_faces(situation, trajectory)]
    moments = _moments(situation, trajectory, count)
    for t, alpha in zip(moments, [*np.linspace(PALEST, 0.5, len(moments) - 1), 1.0], strict=True):
        things += rendering.body_faces(situation, t, alpha)
        things += rendering.arm_faces(situation.arm, trajectory.joints_at(t), alpha)
    window = rendering.window_of(situation, view, things)
    show_image(
        ax,
        rendering.staged(view, window, rendering.floor_of(situation, things), things, pixels),
        window,
    )
    show_through(ax, view, trajectory.hand_at(np.linspace(0.0, end, rendering.SAMPLES)))
    draw_asked(ax, situation, view, trajectory, catches)
    return ax


def draw_asked(
    ax: Axes,
    situation: rendering.JointSituation,
    view: rendering.Camera,
    trajectory: Movement | None,
    catches: Sequence[Mapping[str, Any]] = (),
    until: float = np.inf,
) -> None:
    """Draw the places of targets, and over the hand's path the holds until a time [s]."""
    for body in situation.targets:
        if body.place is not None:
            x, y, _ = view.see(np.array(body.place.position))
            ax.plot(x, y, zorder=17, path_effects=[style.HALO], **PLACED)
    for one in catches:
        assert trajectory is not None
        ends = one["time"], min(one.get("held_until", one["time"]), until)
        if ends[0] < ends[1]:
            path = view.see(trajectory.hand_at(np.linspace(*ends, GHOSTS**2)))
            ax.plot(*path[:, :2].T, **HELD_AS, path_effects=[style.HALO])


def _moments(situation: rendering.JointSituation, trajectory: Movement, count: int) -> np.ndarray:
    """Return instants evenly over the movement; fewer where the hand hardly moves."""
    arm = situation.arm
    thin = rendering.limb_along(arm, np.atleast_2d(arm.joints)).radii.min()
    fitting = 1 + int(trajectory.length / (3.0 * rendering.HAND * thin))
    return np.linspace(0.0, trajectory.duration, min(max(fitting, 2), count))


def show_through(ax: Axes, view: rendering.Camera, path: np.ndarray, alpha: float = 0.4) -> None:
    """Draw a path (k, 3) once more, faintly, over the image, so that its hidden parts show."""
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


def cloud_note(situation: rendering.JointSituation, of: int = rendering.FACES) -> str:
    """Return how many points of clouds are in a picture of so many faces; "" if all are."""
    drawn, there = rendering.points_drawn(situation.bodies, rendering.faces_each(situation, of))
    return f"{drawn:,} of {there:,} points drawn" if drawn < there else ""


def key_below(figure: Figure, situation: rendering.JointSituation) -> None:
    """Explain the colours below pictures of movements."""
    tint = TIME_COLOURS(0.65)
    handles: list[Patch | Line2D] = [
        Patch(color=style.ARM, label="arm"),
        Patch(color=style.TARGET, label="target"),
        Patch(color=style.OBSTACLE, label="obstacle"),
        Line2D([], [], color=tint, lw=2.5, label="hand's path"),
        Line2D([], [], color=tint, lw=2.0, ls=(0, (2, 1)), label="target's path"),
    ]
    if any(body.approach for body in situation.bodies):
        handles[2:2] = [Patch(color=rendering.APPROACH, label="approach")]
    if any(body.margin for body in situation.bodies):
        handles[-2:-2] = [Patch(color=style.OBSTACLE, alpha=2 * rendering.SHELL, label="margin")]
    if told := cloud_note(situation):
        handles[-2:-2] = [Line2D([], [], marker=".", ls="", color=style.OBSTACLE, label=told)]
    if any(body.hold for body in situation.bodies):
        handles.append(Line2D([], [], label="hold", **HELD_AS))
    if any(body.place for body in situation.bodies):
        handles.append(Line2D([], [], label="place", **PLACED))
    rows = 1 + (len(handles) > ABREAST)
    figure.legend(
        handles=handles, loc="outside lower center", ncols=-(-len(handles) // rows),
        fontsize=style.SMALL, frameon=False, labelcolor=style.INK, handlelength=1.6,
        columnspacing=1.4,
    )  # fmt: skip
