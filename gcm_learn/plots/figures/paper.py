"""The paper's figures, computed now."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from gcm_learn.charts import extended_obstacle
from gcm_learn.errors import UnknownNameError
from gcm_learn.execution import body_for, execute, with_motor_limits
from gcm_learn.families import CAPTION_INSTANTS, KAPPA, PAPER_SCENES, SPATIAL_SCENES
from gcm_learn.maps import build_map
from gcm_learn.planners import Plan, solve
from gcm_learn.plots.figures import style, workspace
from gcm_learn.plots.figures.execution import execution_figure
from gcm_learn.plots.figures.hand_space import draw_extended, draw_hand_space
from gcm_learn.plots.figures.maps import draw_snapshot, plot_plan
from gcm_learn.plots.figures.plan import plan_figure
from gcm_learn.plots.figures.solid_scene import draw_course, draw_scene, label_body, scene_window
from gcm_learn.scene import pose
from gcm_learn.situation import Situation
from gcm_learn.wave import WaveParams

PANEL = 3.1  # [inches]
FIG3_INSTANTS = (0, 60, 120, 180)  # [tau] the caption says tau_1 to tau_4


def draw_figure(name: str) -> Figure:
    """Draw one figure of the paper.

    Parameters
    ----------
    name : str
        A key of `FIGURES`.

    Returns
    -------
    Figure

    Raises
    ------
    UnknownNameError
    """
    if name not in FIGURES:
        raise UnknownNameError.among("figure", name, FIGURES)
    return FIGURES[name]()


def fig1() -> Figure:
    """Draw why the arm cannot stretch out straight, and the extended obstacle that says so."""
    situation = PAPER_SCENES["fig1"]()
    figure, (a, b) = _panels(1, 2, letters="AB", size=4.2)
    workspace.draw_workspace(a, situation, annulus=True)
    hand, goal, point = np.array(situation.arm.hand), _place(situation, 0), _place(situation, 1)
    straight = np.array([hand, goal])
    a.plot(*straight.T, color=style.TARGET, lw=1.6, ls=(0, (4, 2)), zorder=4)
    style.title(a, "work-space: the direct path is barred")
    style.label(a, (0.0, -0.22), "shoulder")
    style.label(a, hand + (-0.02, 0.2), "hand")
    style.label(a, goal + (0.12, -0.18), "target")
    style.label(a, point + (0.09, -0.15), "obstacle")
    _draw_sliding(b, situation)
    style.label(b, (1.3, 1.33), "extended obstacle")
    style.title(b, "hand-space: hands whose forearm touches it")
    return figure


def _draw_sliding(ax: Axes, situation: Situation) -> None:
    """Draw arms that touch a point, and the curve of all hands that do (Eq. 8)."""
    arm = situation.arm
    style.frame(ax, arm.upper_arm, annulus=True)
    point = _place(situation, 1)
    curve = extended_obstacle(point, arm.upper_arm, arm.elbow, 200)
    ax.plot(*curve.T, color=style.EXTENDED, lw=5, solid_capstyle="round", zorder=7)
    for share, shade in ((0.15, 0.45), (0.45, 0.7), (0.8, 1.0)):
        workspace.draw_arm(ax, arm, curve[int(share * len(curve))], shade)
    ax.plot(*point, "o", color=style.OBSTACLE, ms=8, zorder=9)


def _place(situation: Situation, index: int) -> np.ndarray:
    """Position (2,) of a planar body at t = 0."""
    return pose(situation, index, 0.0)[0][:2]


def fig2() -> Figure:
    """Draw two obstacles, their overlapping images and a path round them."""
    situation, plan = _solved("fig2")
    figure, (a, b) = _panels(1, 2, size=4.2)
    workspace.draw_movement(a, situation, plan, 5)
    style.title(a, "work-space (later is darker)")
    draw_hand_space(b, situation)
    if plan.trajectory is not None:
        style.draw_path(b, plan.trajectory.hand)
    style.title(b, "hand-space: images overlap")
    return figure


def fig3() -> Figure:
    """Draw the images of two movers at four instants."""
    situation = PAPER_SCENES["fig3"]()
    figure, panels = _panels(1, 4)
    for ax, tau in zip(panels, FIG3_INSTANTS, strict=True):
        style.frame(ax, situation.arm.upper_arm)
        draw_extended(ax, situation, tau * KAPPA)
        for index, body in enumerate(situation.bodies):
            if body.role == "obstacle":
                workspace.draw_body(ax, situation, index, tau * KAPPA)
        workspace.draw_courses(ax, situation, max(FIG3_INSTANTS) * KAPPA)
        style.title(ax, f"τ = {tau}")
    return figure


def fig4() -> Figure:
    """Draw a moving obstacle: both spaces, the wave, the map and the movement."""
    situation, plan = _solved("fig4")
    figure, panels = _panels(2, 4, letters="ABC  DE")
    workspace.draw_workspace(panels[0], situation)
    workspace.draw_courses(panels[0], situation, plan.catch_time or situation.horizon)
    style.title(panels[0], "work-space")
    draw_hand_space(panels[1], situation)
    style.title(panels[1], "hand-space, τ = 0")
    _draw_snapshots(panels[2:5], situation, plan)
    whole = build_map(situation, WaveParams(until="horizon"))
    plot_plan(panels[5], situation, plan, whole)
    style.title(panels[5], "cognitive map")
    workspace.draw_movement(panels[6], situation, plan, 3)
    style.title(panels[6], "work-space: movement")
    style.key(panels[7], style.KEY)
    return figure


def fig5() -> Figure:
    """Draw a falling ball: the 3D scene, the arm plane, the wave and the movement."""
    situation, plan = _solved("fig5")
    figure, panels = _panels(2, 3, letters="ABC  D")
    draw_scene(panels[0], situation)
    draw_course(panels[0], situation, 0, plan.catch_time or 0.5)
    style.title(panels[0], "3D scene and arm plane P")
    workspace.draw_workspace(panels[1], situation)
    style.title(panels[1], "plane P, t = 0")
    _draw_snapshots(panels[2:5], situation, plan)
    workspace.draw_movement(panels[5], situation, plan, 4)
    style.title(panels[5], "work-space: movement")
    return figure


def fig6() -> Figure:
    """Draw thrown objects: the 3D scene, the wave and the movement."""
    situation, plan = _solved("fig6")
    figure, panels = _panels(2, 4, letters="B   C")
    _draw_snapshots(panels[:4], situation, plan)
    _draw_views(panels[4:], situation, plan, [0.0, 60 * KAPPA, 100 * KAPPA])
    return figure


def fig7() -> Figure:
    """Draw the pendulum experiment before it starts."""
    situation, plan = _solved("fig8")
    figure, (a, b) = _panels(1, 2, letters="B ", size=4.4)
    draw_scene(a, situation)
    draw_course(a, situation, 0, plan.catch_time or 0.7)
    label_body(a, situation, 0, "ball on a cord", (0.1, -0.55))
    label_body(a, situation, 2, "box", (1.6, -2.2))
    style.title(a, "the ball is let go")
    workspace.draw_workspace(b, situation)
    style.title(b, "arm plane: only the box is in it")
    return figure


def fig8() -> Figure:
    """Draw the pendulum experiment: the wave and the movement."""
    situation, plan = _solved("fig8")
    figure, panels = _panels(2, 3, letters="B  C", heights=(1.0, 0.72))
    _draw_snapshots(panels[:3], situation, plan)
    _draw_views(panels[3:], situation, plan, [0.0, 120 * KAPPA])
    return figure


def _in_space(name: str) -> Figure:
    """Draw a scene without the arm's plane, and the catch that marching finds."""
    situation = SPATIAL_SCENES[name]()
    return plan_figure(situation, solve(situation, "marching"))


def _in_a_body(name: str) -> Figure:
    """Draw how an arm with mass and motors executes the plan for a scene (extra ``sim``)."""
    scene = SPATIAL_SCENES[name]()
    situation = with_motor_limits(scene, body_for(scene.arm))
    plan: Plan = solve(situation)
    return execution_figure(situation, execute(plan, situation))


FIGURES: dict[str, Callable[[], Figure]] = {
    **{draw.__name__: draw for draw in (fig1, fig2, fig3, fig4, fig5, fig6, fig7, fig8)},
    **{name: partial(_in_space, name) for name in SPATIAL_SCENES},
    "fig8-body": partial(_in_a_body, "fig8-space"),
}


def _panels(
    rows: int,
    columns: int,
    *,
    letters: str = "",
    size: float = PANEL,
    heights: Sequence[float] | None = None,
) -> tuple[Figure, list[Axes]]:
    """Make a grid of panels; a letter of `letters` goes to each, rows may differ in height."""
    heights = [1.0] * rows if heights is None else heights
    figure = style.new_figure(size * columns, (size + 0.3) * sum(heights))
    grid = figure.subplots(rows, columns, squeeze=False, height_ratios=heights)
    panels = list(grid.ravel())
    for ax, letter in zip(panels, letters, strict=False):
        style.panel_letter(ax, letter)
    return figure, panels


def _solved(name: str) -> tuple[Situation, Plan]:
    situation = PAPER_SCENES[name]()
    return situation, solve(situation, "gcm")


def _draw_snapshots(panels: Sequence[Axes], situation: Situation, plan: Plan) -> None:
    """Draw the front at the caption's instants; the last panel shows our own contact."""
    if plan.map is None:
        return
    *early, caption = CAPTION_INSTANTS[situation.name]
    for ax, tau in zip(panels, early, strict=False):
        draw_snapshot(ax, situation, plan.map, tau)
    last, contact = panels[len(early)], plan.map.interception_tau
    path = None if plan.trajectory is None else plan.trajectory.hand
    draw_snapshot(last, situation, plan.map, caption if contact is None else contact, path)
    if contact is not None:
        style.title(last, f"τ = {contact:.0f}: contact (paper: {caption})")


def _draw_views(
    panels: Sequence[Axes], situation: Situation, plan: Plan, times: Sequence[float]
) -> None:
    """Draw the 3D scene at some instants and at the catch."""
    movement = plan.trajectory
    instants = [*times, max(times) if movement is None else movement.duration]
    window = scene_window(situation, instants)
    for ax, t in zip(panels, instants, strict=False):
        hand = situation.arm.hand if movement is None else movement.hand_at(t)
        draw_scene(ax, situation, t, hand=hand, window=window)
        style.title(ax, f"t = {t:.2f} s")
