"""Maps with waits: their sheets, and the marks of the hand's rests."""

from __future__ import annotations

import dataclasses
import itertools
import re

import numpy as np
import pytest
from matplotlib.text import Annotation

from gcm_learn.plots import plan_figure, style
from gcm_learn.plots.figures.maps import walls
from gcm_learn.plots.figures.sheets import MOST_SHEETS, sheet_of, sheets_figure
from gcm_learn.plots.figures.workspace import draw_waits, notable_waits, waiting_at


def titles(figure):
    return [ax.get_title() for ax in figure.axes]


def test_sheets_share_the_cells_target_and_walls_out(waiting_case):
    _, plan = waiting_case
    sheets = [sheet_of(plan.map, k) for k in range(len(plan.map.sheets))]
    assert len(sheets) > 1
    for earlier, later in itertools.pairwise(sheets):
        assert later.arrival.count() < earlier.arrival.count()
        assert (later.arrival > earlier.arrival).all()
    holding = [sheet for sheet in sheets if sheet.effective_target.any()]
    assert len(holding) == 1
    for sheet in sheets:
        assert sheet.arrival[sheet.effective_obstacles].count() == 0


def test_walls_of_the_papers_maps_are_their_effective_obstacles(planar_case):
    cognitive_map = planar_case[1].map
    assert cognitive_map.effective_obstacles.any()
    np.testing.assert_array_equal(walls(cognitive_map), cognitive_map.effective_obstacles)


def test_sheets_stand_side_by_side_in_one_scale(waiting_case, drawn):
    situation, plan = waiting_case
    figure = sheets_figure(situation, plan)
    drawn(figure)
    count = len(plan.map.sheets)
    panels = figure.axes[1 : 1 + count]
    assert [title.split(":")[0] for title in titles(figure)[1 : 1 + count]] == [
        f"sheet {k + 1}" for k in range(count)
    ]
    latest = plan.map.sheets.max() / plan.map.kappa
    shades = [
        c.norm.vmax for ax in panels for c in ax.collections if c.get_cmap() is style.MAP_COLOURS
    ]
    assert shades == pytest.approx([latest] * count)


def test_sheets_that_are_left_out_are_counted(waiting_case, drawn):
    situation, plan = waiting_case
    later = plan.map.sheets[-1:]
    many = np.ma.concatenate([plan.map.later, *[later] * MOST_SHEETS])
    full = dataclasses.replace(plan, map=dataclasses.replace(plan.map, later=many))
    figure = plan_figure(situation, full)
    drawn(figure)
    shown = [title for title in titles(figure) if title.startswith("sheet")]
    assert len(shown) == MOST_SHEETS
    assert f"({1 + len(many) - MOST_SHEETS} more not shown)" in shown[-1]


def test_waits_are_marked_in_both_spaces_and_told(waiting_case, drawn):
    situation, plan = waiting_case
    figure = plan_figure(situation, plan)
    drawn(figure)
    waits = notable_waits(plan.trajectory)
    longest = max(waits, key=lambda wait: wait.duration)
    for ax in figure.axes:
        marks = [line.get_xydata() for line in ax.lines if line.get_marker() == "o"]
        assert any(np.allclose(mark, [longest[:2]]) for mark in marks)
    total = sum(wait.duration for wait in waits)
    for ax in figure.axes[:2]:
        told = [t.get_text() for t in ax.texts if isinstance(t, Annotation)]
        lengths = [float(re.fullmatch(r"waits ([\d.]+) s", text)[1]) for text in told]
        assert longest.duration - 0.011 <= max(lengths) and sum(lengths) <= total + 0.02
    told = re.search(r"([\d.]+) s of it waiting", figure.get_suptitle())
    assert float(told[1]) == pytest.approx(total, abs=0.011)


def test_rests_close_together_share_a_mark(waiting_case):
    """A hand that halts twice within a step says how long it halts in all."""
    _, plan = waiting_case
    way = dataclasses.replace(
        plan.trajectory,
        time=np.array([0.0, 0.3, 0.5, 0.51, 0.71, 1.0]),
        path=np.array([[1.0, 0], [1.4, 0], [1.4, 0], [1.42, 0], [1.42, 0], [1.8, 0]]),
        joints=np.zeros((6, 2)),
    )
    assert len(notable_waits(way)) == 2
    ax = style.new_figure(3.0, 3.0).subplots()
    draw_waits(ax, way)
    assert [t.get_text() for t in ax.texts] == ["waits 0.40 s"]


def test_waiting_is_said_while_the_hand_rests_only(waiting_case):
    way = waiting_case[1].trajectory
    assert notable_waits(way)
    for wait in notable_waits(way):
        assert waiting_at(way, 0.5 * (wait.start + wait.end))
    times = np.linspace(0.01, way.duration - 0.01, 200)
    hands = [np.array([way.hand_at(t - 1e-3), way.hand_at(t + 1e-3)]) for t in times]
    speeds = np.array([np.hypot(*(b - a)) for a, b in hands])
    moving = times[speeds > 0.2 * speeds.max()]
    assert len(moving) > 50 and not any(waiting_at(way, t) for t in moving)


def test_a_plan_without_waits_has_no_marks(planar_case):
    ax = style.new_figure(3.0, 3.0).subplots()
    draw_waits(ax, planar_case[1].trajectory)
    assert not ax.lines and not ax.texts
