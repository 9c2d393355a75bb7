"""Pictures of situations, maps, plans and comparisons, and the pages that show them.

Figures do without matplotlib's global state, so they need no display and may be drawn in threads.
"""

from __future__ import annotations

from gcm_learn.plots.figures import sheet as sheet_figures
from gcm_learn.plots.figures import style
from gcm_learn.plots.figures.arms import draw_arm
from gcm_learn.plots.figures.execution import animate_execution
from gcm_learn.plots.figures.failures import Failure, failure_figure
from gcm_learn.plots.figures.film import animate
from gcm_learn.plots.figures.kinds import DRAWN
from gcm_learn.plots.figures.maps import birth, plot_map, plot_plan
from gcm_learn.plots.figures.paper import FIGURES, draw_figure
from gcm_learn.plots.figures.plan import plan_figure
from gcm_learn.plots.figures.workspace import (
    draw_bodies,
    draw_courses,
    draw_targets,
    draw_waits,
    draw_workspace,
)
from gcm_learn.plots.reports import page as pages
from gcm_learn.plots.reports.dataset import write_dataset_page
from gcm_learn.plots.reports.demo import build_demo
from gcm_learn.plots.reports.film_page import write_film_page
from gcm_learn.plots.reports.memory import write_memory_page

__all__ = [
    "DRAWN",
    "FIGURES",
    "Failure",
    "animate",
    "animate_execution",
    "birth",
    "build_demo",
    "draw_arm",
    "draw_bodies",
    "draw_courses",
    "draw_figure",
    "draw_targets",
    "draw_waits",
    "draw_workspace",
    "failure_figure",
    "pages",
    "plan_figure",
    "plot_map",
    "plot_plan",
    "sheet_figures",
    "style",
    "write_dataset_page",
    "write_film_page",
    "write_memory_page",
]
