"""The paper's figures and the picture of any plan."""

from __future__ import annotations

import dataclasses

import pytest

from gcm_learn.errors import UnknownNameError
from gcm_learn.plots import FIGURES, draw_figure, plan_figure

PANELS = {
    **{"fig1": 2, "fig2": 2, "fig3": 4, "fig4": 8, "fig5": 6, "fig6": 8, "fig7": 2, "fig8": 6},
    **{"fig5-space": 3, "fig8-space": 3, "fig8-body": 6},
}


@pytest.mark.parametrize("name", FIGURES)
def test_every_panel_of_a_figure_is_filled(name, drawn):
    figure = draw_figure(name)
    drawn(figure)
    assert len(figure.axes) == PANELS[name]
    for ax in figure.axes:
        assert ax.lines or ax.patches or ax.collections or ax.images


@pytest.mark.parametrize(("name", "caption"), [("fig4", 180), ("fig5", 220), ("fig6", 160)])
def test_last_snapshot_names_both_instants(name, caption):
    titles = [ax.get_title() for ax in draw_figure(name).axes]
    (contact,) = [title for title in titles if "contact" in title]
    assert contact.endswith(f"(paper: {caption})")
    assert abs(float(contact.split()[2].rstrip(":")) / caption - 1) < 0.15


def test_unknown_figure_names_the_known_ones():
    with pytest.raises(UnknownNameError, match=r"'fig9'.* fig1, fig2.* did you mean 'fig8'"):
        draw_figure("fig9")


def test_plan_figure_of_a_3d_catch_has_a_view(solid_case, drawn):
    figure = plan_figure(*solid_case)
    drawn(figure)
    assert figure.axes[0].get_title() == "at the catch"
    assert len(figure.axes) == 3


def test_plan_figure_without_a_map_shows_hand_space(planar_case, drawn):
    situation, plan = planar_case
    figure = plan_figure(situation, dataclasses.replace(plan, map=None))
    drawn(figure)
    assert figure.axes[1].get_title() == "hand-space at the catch (no map was made)"


def test_plan_figure_without_obstacles_has_no_clearance(planar_case, drawn):
    situation, plan = planar_case
    alone = dataclasses.replace(situation, bodies=situation.targets)
    figure = plan_figure(alone, dataclasses.replace(plan, clearance=float("inf")))
    drawn(figure)
    assert "clearance" not in figure.get_suptitle()
