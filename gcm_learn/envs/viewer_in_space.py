"""Pictures of the arena in space: as arrays, or in a window."""

from __future__ import annotations

from typing import Any

import numpy as np

from gcm_learn.arms import SpatialArm
from gcm_learn.envs.viewer import DPI, SIZE_INCHES
from gcm_learn.motion import SpatialTrajectory
from gcm_learn.rendering import Spectator
from gcm_learn.situation import Situation

PIXELS = round(SIZE_INCHES * DPI)  # of a side


class ViewerInSpace:
    """Draws with the package's own renderer, which needs no graphics card."""

    def __init__(self, window: bool) -> None:
        self._seen: tuple[Any, Any] = (None, None)
        self._shown: Any = None
        if window:
            import matplotlib.pyplot as plt

            figure = plt.figure(figsize=(SIZE_INCHES, SIZE_INCHES), dpi=DPI)
            axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
            axes.set_axis_off()
            self._shown = axes.imshow(np.full((PIXELS, PIXELS, 3), 255, np.uint8))

    def show(self, situation: Situation[SpatialArm], way: SpatialTrajectory) -> np.ndarray | None:
        """Draw the end of a way: a picture (480, 480, 3) uint8, or None in a window."""
        seen, spectator = self._seen
        if seen is not situation:
            spectator = Spectator(situation)
            self._seen = (situation, spectator)
        picture: np.ndarray = spectator.picture(way, PIXELS)
        if self._shown is None:
            return picture
        import matplotlib.pyplot as plt

        self._shown.set_data(picture)
        self._shown.figure.canvas.draw_idle()
        plt.pause(1e-3)
        return None

    def close(self) -> None:
        """Close the window."""
        if self._shown is not None:
            import matplotlib.pyplot as plt

            plt.close(self._shown.figure)
