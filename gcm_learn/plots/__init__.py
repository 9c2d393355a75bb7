"""Pictures of situations, maps, plans and comparisons, and the pages that show them.

Figures do without matplotlib's global state, so they need no display and may be drawn in threads.
"""

from __future__ import annotations

from gcm_learn.plots.figures import sheet, style as style
from gcm_learn.plots.figures.arms import draw_arm as draw_arm
from gcm_learn.plots.figures.execution import animate_execution as animate_execution
from gcm_learn.plots.figures.film import animate as animate
from gcm_learn.plots.figures.kinds import DRAWN as DRAWN
from gcm_learn.plots.figures.maps import (
    birth as birth,
    plot_map as plot_map,
    plot_plan as plot_plan,
)
from gcm_learn.plots.figures.paper import FIGURES as FIGURES, draw_figure as draw_figure
from gcm_learn.plots.figures.plan import (
    MissedCatch as MissedCatch,
    failure_figure as failure_figure,
    plan_figure as plan_figure,
)
from gcm_learn.plots.figures.workspace import (
    draw_bodies as draw_bodies,
    draw_courses as draw_courses,
    draw_targets as draw_targets,
    draw_waits as draw_waits,
    draw_workspace as draw_workspace,
)
from gcm_learn.plots.reports import page
from gcm_learn.plots.reports.dataset import write_dataset_page as write_dataset_page
from gcm_learn.plots.reports.demo import build_demo as build_demo
from gcm_learn.plots.reports.film_page import write_film_page as write_film_page
from gcm_learn.plots.reports.memory import write_memory_page as write_memory_page

pages, sheet_figures = page, sheet
