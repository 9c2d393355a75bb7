"""Pictures of arms in space: what is painted, where, and that nothing is too wild to be drawn."""

from __future__ import annotations

import itertools
from types import SimpleNamespace

import numpy as np
import pytest
from PIL import Image

from gcm_learn.planners import Plan
from gcm_learn.plots import animate, plan_figure, style
from gcm_learn.plots.figures import space
from gcm_learn.plots.figures.film import ROUND
from gcm_learn.plots.reports.dataset import draw_record
from gcm_learn.situation import read_situations
from tests.rendering.test_rendering import near, turning
from tests.spatial import EXAMPLES


def plan_of(situation, trajectory=None):
    caught = trajectory is not None
    return Plan(
        situation.name, "straight", "caught" if caught else "unreachable", "told", 1.0,
        trajectory.duration if caught else None, situation.targets[0].name if caught else None,
        0.1 if caught else None, trajectory,
    )  # fmt: skip


@pytest.fixture(scope="module")
def case():
    situation = read_situations(EXAMPLES)[0]
    return situation, turning(situation)


def test_a_picture_shows_arm_target_and_obstacles(case):
    situation, trajectory = case
    scenery = space.Scenery(situation, trajectory)
    ax = style.new_figure(3.0, 3.0).subplots()
    scenery.show(ax, 0.0, pixels=150)
    image = np.asarray(ax.images[0].get_array())
    for colour in (style.ARM, style.TARGET, style.OBSTACLE):
        assert near(image, colour) > 0.003


def test_plan_figure_of_a_catch_in_space(case, drawn):
    situation, trajectory = case
    figure = plan_figure(situation, plan_of(situation, trajectory))
    drawn(figure)
    assert [ax.get_title() for ax in figure.axes] == ["work-space", "from above"]
    assert "caught 'ball'" in figure.get_suptitle()
    labels = [text.get_text() for text in figure.legends[0].get_texts()]
    assert labels == ["arm", "target", "obstacle", "hand's way", "target's way"]


def test_plan_figure_in_space_without_a_catch_shows_the_courses(case, drawn):
    situation, _ = case
    figure = plan_figure(situation, plan_of(situation))
    drawn(figure)
    assert figure.get_suptitle().endswith("told")
    assert all(ax.lines for ax in figure.axes)


@pytest.mark.parametrize("caught", [True, False])
def test_gallery_shows_records_in_space(case, drawn, caught):
    situation, trajectory = case
    plan = plan_of(situation, trajectory if caught else None)
    record = SimpleNamespace(
        situation=situation, plans={"straight": plan}, map=None, family="swarm-space", index=7
    )
    figure, (above, below) = style.panel_grid(2, 2, (2.0, 2.0))
    draw_record(above, below, record)
    drawn(figure)
    assert above.images and bool(below.images) == caught
    assert above.get_title() == "swarm-space 7"
    assert below.get_title().startswith("straight" if caught else "no catch")


@pytest.mark.parametrize("caught", [True, False])
def test_film_in_space_moves_and_looks_around_a_catch(case, tmp_path, caught):
    situation, trajectory = case
    path = tmp_path / "film.gif"
    animate(situation, plan_of(situation, trajectory if caught else None), path, frames=3)
    with Image.open(path) as film:
        assert film.n_frames == (3 + ROUND if caught else 3)
        frames = []
        for k in range(film.n_frames):
            film.seek(k)
            frames.append(np.asarray(film.convert("RGB"), dtype=int))
    assert all(np.abs(b - a).max() > 50 for a, b in itertools.pairwise(frames))
    assert path.stat().st_size < 900_000
