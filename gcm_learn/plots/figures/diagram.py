"""Pictures and films of a planar arm, drawn with lines and patches in the arm's plane."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from gcm_learn.arms import elbow_position
from gcm_learn.motion import collision_point
from gcm_learn.plots.figures import style, workspace
from gcm_learn.plots.figures.hand_space import (
    draw_hand,
    draw_hand_space,
    extended_image,
    show_image,
)
from gcm_learn.plots.figures.maps import draw_effective, draw_explored, plot_map, plot_plan
from gcm_learn.plots.figures.sheets import sheet_panels
from gcm_learn.plots.figures.solid_scene import SolidFilm, draw_scene
from gcm_learn.plots.figures.style import Panel, Scene
from gcm_learn.scene import outline
from gcm_learn.situation import Situation

if TYPE_CHECKING:
    from gcm_learn.maps import CognitiveMap
    from gcm_learn.motion import Movement
    from gcm_learn.planners import Plan

PANEL, MARGIN = 4.0, 0.6  # [inches] of a panel, and below all panels
LATER = 0.3  # strength of bodies at the end of a movement
BEFORE = 0.25  # strength of bodies at t = 0
DASHED, DOTTED = (0, (2, 1.5)), (0, (1, 1.5))  # paths of hands
COARSE = 240  # cells a side of the drawn extended obstacles
HELD = 25  # instants of a film at which targets are in its picture


class Diagram:
    """Pictures of a situation with a planar arm and of its plan.

    Parameters
    ----------
    situation : Situation
        With a planar arm.
    plan : Plan, optional
        Of this situation, whatever its status.
    """

    panel, margin = PANEL, MARGIN
    turns = False

    def __init__(self, situation: Situation, plan: Plan | None = None) -> None:
        self.situation, self.plan = situation, plan
        self.trajectory = None if plan is None else plan.trajectory

    @property
    def waiting(self) -> float:
        """Time that the hand rests [s]."""
        waits = [] if self.trajectory is None else workspace.notable_waits(self.trajectory)
        return sum(wait.duration for wait in waits)

    def panels(self) -> list[Panel]:
        """Return panels of the movement and the map, after a view of the scene if it is solid."""
        solid = [self._solid_panel()] if self.situation.is_solid else []
        return [*solid, self._movement_panel(), *self._hand_panels()]

    def key_below(self, figure: Figure) -> None:
        """Leave a figure without a key, as in the paper."""

    def _solid_panel(self) -> Panel:
        when = "start" if self.trajectory is None else "catch"
        t, hand = 0.0, None
        if self.trajectory is not None:
            t, hand = self.trajectory.duration, self.trajectory.hand[-1]
        return f"at the {when}", lambda ax: draw_scene(ax, self.situation, t, hand=hand)

    def _movement_panel(self) -> Panel:
        if self.trajectory is not None:
            return "work-space: movement (later is darker)", self.draw_movement
        return "work-space: start", lambda ax: self.draw_start(ax, self.situation.horizon)

    def _hand_panels(self) -> list[Panel]:
        """Return panels of the map's sheets or, without a map, of hand-space at the movement's end.

        Planners of straight lines make no map, and `layered` rarely; `mapped` adds one.
        """
        assert self.plan is not None
        if self.plan.map is None:
            when = "start" if self.plan.catch_time is None else "catch"
            return [(f"hand-space at the {when} (no map was made)", self._draw_hands)]
        panels = sheet_panels(self.situation, self.plan)
        if len(panels) == 1:
            return [("hand-space: cognitive map", panels[0][1])]
        return panels

    def _draw_hands(self, ax: Axes) -> None:
        end = 0.0 if self.trajectory is None else self.trajectory.duration
        draw_hand_space(ax, self.situation, end)
        self._draw_path(ax)

    def _draw_path(self, ax: Axes) -> None:
        if self.trajectory is not None:
            style.draw_path(ax, self.trajectory.hand)
            workspace.draw_waits(ax, self.trajectory)

    def draw_start(self, ax: Axes, end: float, pixels: int = 0) -> None:
        """Draw t = 0, and where bodies go until `end` [s]."""
        workspace.draw_workspace(ax, self.situation)
        workspace.draw_courses(ax, self.situation, end)

    def draw_movement(self, ax: Axes, pixels: int = 0) -> None:
        """Draw the arm and the bodies at several instants over each other."""
        assert self.plan is not None
        workspace.draw_movement(ax, self.situation, self.plan)

    def draw_record(
        self, above: Axes, below: Axes, known: CognitiveMap | None, end: float, pixels: int
    ) -> None:
        """Draw the start with the bodies at `end` [s] above, and the map with the path below."""
        above.axis("on")
        self.draw_start(above, end)
        workspace.draw_bodies(above, self.situation, end, LATER)
        if known is None:
            return
        below.axis("on")
        if self.plan is None or self.trajectory is None:
            plot_map(known, below)
        else:
            plot_plan(below, self.situation, self.plan, known, waits=False)

    def scenes(self, panels: Sequence[Axes], pixels: int) -> tuple[Scene, Scene]:
        """Return functions that draw work-space and hand-space at a time [s]."""
        work, hands = panels
        end = self.situation.horizon if self.trajectory is None else self.trajectory.duration
        style.frame(hands, self.situation.arm.upper_arm)
        style.title(hands, "hand-space")
        film = film_of(self.situation, end)
        film.frame(work)
        style.title(work, "work-space")

        def show(ax: Axes, t: float, turn: float) -> None:
            film.show(ax, t, self._hand_at(t), pixels)
            ax.plot(*film.seen(self._past(t)).T, color=style.PATH, lw=1.6, ls=DASHED, zorder=4)
            style.note_in_corner(ax, self._moment(t))

        return show, self._hand_space

    def _past(self, t: float) -> np.ndarray:
        """Return the hand's path (k, 2) until time t [s]."""
        moves = self.trajectory
        return np.empty((0, 2)) if moves is None else moves.hand[moves.time <= t]

    def _moment(self, t: float) -> str:
        waits = self.trajectory is not None and workspace.waiting_at(self.trajectory, t)
        return f"t = {t:.2f} s" + (", waiting" if waits else "")

    def _hand_space(self, ax: Axes, t: float, turn: float) -> None:
        assert self.plan is not None
        situation, known = self.situation, self.plan.map
        show_image(ax, extended_image(situation, t, n=COARSE), situation.arm, zorder=2.0)
        if known is not None:
            tau = t / known.kappa
            draw_explored(ax, known, tau)
            draw_effective(ax, known, tau)
            style.note_in_corner(ax, f"τ = {tau:.0f}")
        workspace.draw_bodies(ax, situation, t)
        if self.trajectory is not None and t >= self.trajectory.duration:
            self._draw_path(ax)
        draw_hand(ax, self._hand_at(t))

    def _hand_at(self, t: float) -> np.ndarray:
        if self.trajectory is None:
            return np.asarray(self.situation.arm.hand)
        return self.trajectory.hand_at(t)


class MissedDiagram:
    """A missed catch of a planar arm.

    Parameters
    ----------
    situation : Situation
        With a planar arm.
    movement : Movement, optional
        Movement that misses; the arm rests without one.
    example : Movement, optional
        Movement by which another method catches.
    touches : bool
        The movement ends in a collision.
    """

    def __init__(
        self,
        situation: Situation,
        movement: Movement | None,
        example: Movement | None,
        touches: bool,
    ) -> None:
        self.situation, self.movement, self.example = situation, movement, example
        self.touches = touches and movement is not None
        self.resting_until = situation.horizon
        self._film: Film | None = None

    def show_end(self, ax: Axes, t: float, pixels: int) -> None:
        """Draw time t [s], and where bodies come from."""
        style.frame(ax, self.situation.arm.upper_arm)
        workspace.draw_bodies(ax, self.situation, 0.0, alpha=BEFORE)
        workspace.draw_courses(ax, self.situation, t)
        self._draw(ax, PlaneFilm(self.situation, t), t, pixels)

    def show(self, ax: Axes, t: float, pixels: int, end: float) -> None:
        """Draw time t [s] of a film until `end` [s]."""
        if self._film is None:
            self._film = film_of(self.situation, end)
        self._film.frame(ax)
        self._draw(ax, self._film, t, pixels)

    def _draw(self, ax: Axes, film: Film, t: float, pixels: int) -> None:
        """Draw time t [s], with the path of a method that catches in grey."""
        moves, example = self.movement, self.example
        hand = np.asarray(self.situation.arm.hand) if moves is None else moves.hand_at(t)
        other = None if example is None or t > example.duration else example.hand_at(t)
        film.show(ax, t, hand, pixels, other)
        if example is not None:
            ax.plot(*film.seen(example.hand).T, color=style.FAINT, lw=1.4, ls=DOTTED, zorder=3)
        if moves is None:
            return
        past = np.vstack([moves.hand[moves.time <= t], hand])
        ax.plot(*film.seen(past).T, color=style.PATH, lw=1.4, zorder=4)
        if t >= film.end and self.touches:
            point = np.asarray(collision_point(self.situation, moves))
            (place,) = film.seen(point[None])
            ax.plot(*place, "o", mfc="none", mec=style.EFFECTIVE, ms=16, mew=1.8, zorder=12)


class PlaneFilm:
    """An arm's plane in a picture that holds the whole way of the targets.

    Parameters
    ----------
    situation : Situation
        With a planar arm.
    end : float
        Of the film [s].
    """

    def __init__(self, situation: Situation, end: float) -> None:
        self.situation, self.end = situation, end

    def frame(self, ax: Axes) -> None:
        """Frame the disc in reach, and the targets at all times."""
        situation = self.situation
        style.frame(ax, situation.arm.upper_arm)
        targets = [k for k, body in enumerate(situation.bodies) if body.role == "target"]
        times = np.linspace(0.0, self.end, HELD)
        shapes = [outline(situation, k, t) for k in targets for t in times]
        rim = np.array([ax.get_xlim(), ax.get_ylim()]).T
        held = np.concatenate([rim, *(corners for corners in shapes if corners is not None)])
        low, high = held.min(axis=0), held.max(axis=0)
        half, (x, y) = 0.5 * float((high - low).max()), 0.5 * (low + high)
        ax.set(xlim=(x - half, x + half), ylim=(y - half, y + half))

    def seen(self, points: np.ndarray) -> np.ndarray:
        """Return points (k, 2) of the arm's plane, which are the picture's."""
        return points

    def show(
        self, ax: Axes, t: float, hand: np.ndarray, pixels: int, other: np.ndarray | None = None
    ) -> None:
        """Draw time t [s] with the hand (2,), and an arm with another hand in grey."""
        arm = self.situation.arm
        workspace.draw_bodies(ax, self.situation, t)
        if other is not None:
            elbow = elbow_position(other, arm.upper_arm, arm.elbow)
            limb = np.array([(0.0, 0.0), elbow, other])
            ax.plot(*limb.T, "o-", color=style.FAINT, lw=3.0, ms=6.0, alpha=0.7, zorder=5.5)
        workspace.draw_arm(ax, arm, hand)


Film = PlaneFilm | SolidFilm
_FILMS: dict[bool, type[Film]] = {False: PlaneFilm, True: SolidFilm}


def film_of(situation: Situation, end: float) -> Film:
    """Return the film of a planar arm until `end` [s], in the arm plane or among the solids."""
    return _FILMS[situation.is_solid](situation, end)
