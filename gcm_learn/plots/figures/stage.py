"""Pictures of an arm that moves in its joints, among solids."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure

from gcm_learn import rendering
from gcm_learn.arms import hands_along
from gcm_learn.plots.figures import style
from gcm_learn.plots.figures.hand_ball import HandBall, ball_window, fills_ball
from gcm_learn.plots.figures.scenery import (
    Scenery,
    draw_courses,
    draw_poses,
    draw_start,
    key_below,
    show_image,
    time_bar,
)
from gcm_learn.plots.figures.style import Panel, Scene

if TYPE_CHECKING:
    from gcm_learn.maps import CognitiveMap
    from gcm_learn.planners import Plan

PANEL, MARGIN = 4.6, 0.8  # [inches] of a panel, and below all panels
SIDES = ("work-space", "from above")
SWAY = 35.0  # [degrees] by which hand-space is turned to and fro
BEFORE = 0.25  # alpha of bodies where they were at t = 0
OTHER = 0.7  # alpha of the arm that catches


class JointPictures:
    """Pictures of a situation with an arm that moves in its joints, and of its plan.

    Parameters
    ----------
    situation : Situation
        With an arm that moves in its joints.
    plan : Plan, optional
        Of this situation, whatever its status.
    """

    panel, margin = PANEL, MARGIN
    turns = True
    waiting = 0.0

    def __init__(self, situation: rendering.JointSituation, plan: Plan | None = None) -> None:
        self.situation, self.plan = rendering.with_carries(situation, plan), plan
        self.catches = () if plan is None else plan.catches
        self.trajectory: Any = None if plan is None else plan.trajectory
        self.map = plan.map if plan is not None and fills_ball(plan.map) else None

    @cached_property
    def view(self) -> rendering.Camera:
        """Camera that sees arm and hand's path from the side."""
        return rendering.view_of(self.situation, self.trajectory)

    def panels(self) -> list[Panel]:
        """Return the movement from the side and from above, and the map."""
        panels = [
            self._side(view, name)
            for view, name in zip((self.view, rendering.from_above(self.view)), SIDES, strict=True)
        ]
        if self.map is not None:
            hands = HandBall(self.situation, self.map, self.trajectory, self.view)
            panels.append(("hand-space: cognitive map, cut open", hands.show_map))
        return panels

    def _side(self, view: rendering.Camera, name: str) -> Panel:
        if self.trajectory is not None:
            return name, lambda ax: self.draw_movement(ax, view=view)
        end = self.situation.horizon
        return f"{name}: start", lambda ax: self.draw_start(ax, end, view=view)

    def key_below(self, figure: Figure) -> None:
        """Explain the colours below the panels."""
        key_below(figure, self.situation)

    def draw_start(
        self,
        ax: Axes,
        end: float,
        pixels: int = rendering.PIXELS,
        *,
        view: rendering.Camera | None = None,
    ) -> None:
        """Draw t = 0, and where bodies go until `end` [s]."""
        view = view or self.view
        draw_start(ax, self.situation, view, pixels)
        draw_courses(ax, self.situation, end, view)

    def draw_movement(
        self, ax: Axes, pixels: int = rendering.PIXELS, *, view: rendering.Camera | None = None
    ) -> None:
        """Draw the arm and the bodies at several instants over each other."""
        draw_poses(
            ax, self.situation, self.trajectory, view or self.view, pixels=pixels,
            catches=self.catches,
        )  # fmt: skip
        time_bar(ax, self.trajectory.duration)

    def draw_record(
        self, above: Axes, below: Axes, known: CognitiveMap | None, end: float, pixels: int
    ) -> None:
        """Draw the start above, and the movement below."""
        self.draw_start(above, end, pixels)
        if self.trajectory is not None:
            draw_poses(below, self.situation, self.trajectory, self.view, pixels=pixels)

    def scenes(self, panels: Sequence[Axes], pixels: int) -> tuple[Scene, Scene]:
        """Return functions that draw a time [s], from a camera that turns by an angle [degrees].

        The second one shows hand-space where there is a map of it, else the arm from above.
        """
        shown, catches = (self.situation, self.trajectory), self.catches
        level = Scenery(*shown, turns=True, catches=catches)
        above = Scenery(*shown, view=rendering.from_above(level.view), catches=catches)
        charted = self.map is not None
        windows = (level.window, ball_window(self.situation) if charted else above.window)
        names = ("work-space", "hand-space" if charted else "from above")
        for ax, window, name in zip(panels, windows, names, strict=True):
            style.view_frame(ax, window.extent, name)

        def show(ax: Axes, t: float, turn: float) -> None:
            level.show(ax, t, turn, pixels)
            style.note_in_corner(ax, f"t = {t:.2f} s")

        if not charted:
            return show, lambda ax, t, _: above.show(ax, t, 0.0, pixels)
        return show, self._hand_scene(level, pixels)

    def _hand_scene(self, level: Scenery, pixels: int) -> Scene:
        assert self.map is not None
        hands = HandBall(self.situation, self.map, self.trajectory, level.view)
        caught, kappa = self.trajectory is not None, self.map.kappa

        def show(ax: Axes, t: float, turn: float) -> None:
            if t < level.end or not caught:
                sway = SWAY * np.sin(np.pi * (2.0 * t / level.end - 1.0))
                hands.show(ax, t, sway, pixels)
            else:
                hands.show_map(ax, SWAY * np.sin(np.radians(turn)), pixels)
            style.note_in_corner(ax, f"τ = {t / kappa:.0f}")

        return show


class MissedStage:
    """A missed catch: the arm at rest.

    Parameters
    ----------
    situation : Situation
        With an arm that moves in its joints.
    movement : None
        Movements that miss are not kept.
    example : Movement, optional
        Movement by which another method catches, in grey.
    touches : bool
        The movement ends in a collision.
    """

    def __init__(
        self, situation: rendering.JointSituation, movement: Any, example: Any, touches: bool
    ) -> None:
        self.situation, self.example = situation, example

    @cached_property
    def scenery(self) -> Scenery:
        """Camera, window and floor of all instants."""
        return Scenery(self.situation, self.example)

    @property
    def resting_until(self) -> float:
        """Time at which a target's centre is nearest to the hand of the resting arm [s]."""
        times = np.linspace(0.0, self.situation.horizon, rendering.SAMPLES)
        arm = self.situation.arm
        hand = hands_along(arm, arm.joints)[0]
        away = np.linalg.norm(rendering.target_paths(self.situation, times) - hand, axis=2).min(
            axis=0
        )
        return float(times[away.argmin()])

    def show(self, ax: Axes, t: float, pixels: int, end: float) -> None:
        """Draw time t [s] of a film until `end` [s]."""
        window = self.scenery.window_at(t)
        show_image(ax, self._image(self._at(t), pixels, window), window)

    def show_end(self, ax: Axes, t: float, pixels: int) -> None:
        """Draw time t [s], and where bodies come from."""
        before = list(rendering.body_faces(self.situation, 0.0, BEFORE))
        window = self.scenery.window
        show_image(ax, self._image([*before, *self._at(t)], pixels, window), window)
        draw_courses(ax, self.situation, t, self.scenery.view)

    def _image(
        self, things: list[rendering.Faces], pixels: int, window: rendering.Window
    ) -> np.ndarray:
        return rendering.staged(self.scenery.view, window, self.scenery.floor, things, pixels)

    def _at(self, t: float) -> list[rendering.Faces]:
        arm, example, grey = self.situation.arm, self.example, np.array(to_rgb(style.FAINT))
        things = [*rendering.body_faces(self.situation, t), *rendering.arm_faces(arm, arm.joints)]
        if example is None:
            return things
        path = example.hand_at(np.linspace(0.0, example.duration, rendering.SAMPLES))
        things.append(rendering.Faces(rendering.tube(path, rendering.LINE * arm.reach), grey))
        moved = rendering.arm_faces(arm, example.joints_at(t), OTHER)
        return things + [part._replace(colours=grey) for part in moved]
