"""Pictures of the arena: as arrays, or in a window."""

from __future__ import annotations

from typing import Any

import numpy as np

from gcm_learn.arms import elbow_position
from gcm_learn.rendering import ARM, INK, PATH, body_colour
from gcm_learn.scene import outline
from gcm_learn.situation import Situation

SIZE_INCHES, DPI = 4.8, 100


class Viewer:
    """Draws the arm's plane with matplotlib."""

    def __init__(self, window: bool) -> None:
        from matplotlib.figure import Figure

        self._window = window
        if window:
            import matplotlib.pyplot as plt

            self._figure: Any = plt.figure(figsize=(SIZE_INCHES, SIZE_INCHES), dpi=DPI)
        else:
            from matplotlib.backends.backend_agg import FigureCanvasAgg

            self._figure = Figure(figsize=(SIZE_INCHES, SIZE_INCHES), dpi=DPI)
            FigureCanvasAgg(self._figure)
        self._axes = self._figure.add_axes((0.0, 0.0, 1.0, 1.0))

    def show(self, situation: Situation, time: float, path: np.ndarray) -> np.ndarray | None:
        """Draw a moment: a picture (480, 480, 3) uint8, or None in a window.

        Parameters
        ----------
        situation : Situation
            In its canonical form.
        time : float
            [s]
        path : (n, 2) ndarray
            Where the hand has been; it is at the last.
        """
        from matplotlib.patches import Circle

        ax, arm = self._axes, situation.arm
        ax.clear()
        ax.set_axis_off()
        limit = 1.15 * arm.reach
        ax.set_xlim(-limit, limit)
        ax.set_ylim(-limit, limit)
        ax.add_patch(Circle((0, 0), arm.reach, fill=False, ls="--", ec="#a0aec0"))
        self._bodies(situation, time)
        hand = path[-1]
        elbow = elbow_position(hand, arm.upper_arm, arm.elbow)
        ax.plot(path[:, 0], path[:, 1], color=PATH, lw=1.2)
        ax.plot(*np.array([(0.0, 0.0), elbow, hand]).T, color=ARM, lw=4, solid_capstyle="round")
        ax.add_patch(Circle(tuple(hand), max(arm.grasp, 0.02), color=ARM))
        ax.text(-0.98 * limit, 0.95 * limit, f"{time:.2f} s", va="top", color=INK)
        return self._picture()

    def _bodies(self, situation: Situation, time: float) -> None:
        """The bodies, or their cuts with the plane."""
        from matplotlib.patches import Polygon

        for index, body in enumerate(situation.bodies):
            corners = outline(situation, index, time)
            if corners is not None:
                self._axes.add_patch(Polygon(corners, closed=True, color=body_colour(body), lw=0))

    def _picture(self) -> np.ndarray | None:
        canvas = self._figure.canvas
        if self._window:
            import matplotlib.pyplot as plt

            canvas.draw_idle()
            plt.pause(1e-3)
            return None
        canvas.draw()
        return np.asarray(canvas.buffer_rgba())[..., :3].copy()

    def close(self) -> None:
        """Close the window."""
        if self._window:
            import matplotlib.pyplot as plt

            plt.close(self._figure)
