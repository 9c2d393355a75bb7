"""Pictures: functions that take records and return matplotlib axes or figures.

Nothing here uses matplotlib's global state, so it works without a display and in threads.
"""

from __future__ import annotations

from gcm_learn.plots.animation import animate
from gcm_learn.plots.maps import plot_map
from gcm_learn.plots.overview import plan_figure

__all__ = ["animate", "plan_figure", "plot_map"]
