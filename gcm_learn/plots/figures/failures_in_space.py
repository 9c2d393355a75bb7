"""A catch in space that a planner misses: its arm at rest, and in grey how another one catches."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import to_rgb

from gcm_learn.arms import forward_in_space
from gcm_learn.plots.figures import style
from gcm_learn.plots.figures.space import Scenery, draw_courses_in_space, show_image
from gcm_learn.rendering import (
    LINE,
    SAMPLES,
    Faces,
    SpatialSituation,
    arm_faces,
    body_faces,
    body_poses,
    staged,
    tube,
)

if TYPE_CHECKING:
    from gcm_learn.motion import SpatialTrajectory

BEFORE = 0.25  # alpha of bodies where they were at t = 0
OTHER = 0.7  # alpha of the arm that catches


def closest_moment(situation: SpatialSituation) -> float:
    """When a target's centre is nearest to the hand of the resting arm [s]."""
    times = np.linspace(0.0, situation.horizon, SAMPLES)
    centres, _ = body_poses(situation, times)
    targets = [body.role == "target" for body in situation.bodies]
    hand = forward_in_space(situation.arm, situation.arm.joints)[1]
    away = np.linalg.norm(centres[:, targets] - hand, axis=2).min(axis=1)
    return float(times[away.argmin()])


class MissedCatch:
    """A missed catch, in the same picture at every instant.

    Parameters
    ----------
    situation : Situation
        With a spatial arm.
    example : SpatialTrajectory, optional
        How another method catches.
    """

    def __init__(self, situation: SpatialSituation, example: SpatialTrajectory | None) -> None:
        self.situation, self.example = situation, example
        self.scenery = Scenery(situation, example)

    def show(self, ax: Axes, t: float, pixels: int) -> None:
        """Draw time t [s]."""
        show_image(ax, self._image(self._at(t), pixels), self.scenery.window)

    def show_end(self, ax: Axes, t: float, pixels: int) -> None:
        """Draw time t [s], and where bodies come from."""
        before = list(body_faces(self.situation, 0.0, BEFORE))
        show_image(ax, self._image([*before, *self._at(t)], pixels), self.scenery.window)
        draw_courses_in_space(ax, self.situation, t, self.scenery.view)

    def _image(self, things: list[Faces], pixels: int) -> np.ndarray:
        stage = self.scenery
        return staged(stage.view, stage.window, stage.floor, things, pixels)

    def _at(self, t: float) -> list[Faces]:
        arm, example, grey = self.situation.arm, self.example, np.array(to_rgb(style.FAINT))
        things = [*body_faces(self.situation, t), *arm_faces(arm, arm.joints)]
        if example is None:
            return things
        way = example.hand_at(np.linspace(0.0, example.duration, SAMPLES))
        things.append(Faces(tube(way, LINE * arm.reach), grey))
        moved = arm_faces(arm, example.joints_at(t), OTHER)
        return things + [part._replace(colours=grey) for part in moved]
