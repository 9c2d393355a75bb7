"""Pictures of every kind of arm: figures of plans, films and records."""

from __future__ import annotations

import itertools
from types import SimpleNamespace

import numpy as np
import pytest
from PIL import Image

from gcm_learn.arms import kinds
from gcm_learn.plots import animate, plan_figure, style
from gcm_learn.plots.figures.film import ROUND
from gcm_learn.plots.figures.kinds import DRAWN, pictures_of
from gcm_learn.plots.figures.scenery import Scenery
from gcm_learn.plots.reports.dataset import draw_record
from tests.plots.cases import AMONG_SOLIDS, CASES, FAR, params, plan_of
from tests.rendering.test_rendering import near

TITLES = {
    "planar": ["work-space: movement (later is darker)", "hand-space: cognitive map"],
    "spatial": ["work-space", "from above"],
    "chain": ["work-space", "from above"],
}
KEY = ["arm", "target", "obstacle", "hand's path", "target's path"]
KEYS = {"planar": [], "spatial": KEY, "chain": ["arm", "target", "approach", *KEY[2:]]}


@pytest.fixture(scope="module", params=params(CASES))
def case(request):
    return request.param, *CASES[request.param]()


@pytest.fixture(scope="module", params=params(AMONG_SOLIDS))
def solid_case(request):
    return AMONG_SOLIDS[request.param]()


def test_every_kind_of_arm_is_drawn():
    assert all(DRAWN.takes(kind) for kind in kinds())


def test_plan_figure_of_a_catch(case, drawn):
    name, situation, plan = case
    figure = plan_figure(situation, plan)
    drawn(figure)
    assert [ax.get_title() for ax in figure.axes] == TITLES[name]
    headline = figure.get_suptitle()
    assert f"caught {situation.targets[0].name!r} after {plan.catch_time:.3f} s" in headline
    labels = [text.get_text() for legend in figure.legends for text in legend.get_texts()]
    assert labels == KEYS[name]


def test_plan_figure_without_a_catch_shows_why_and_the_courses(case, drawn):
    _, situation, _ = case
    figure = plan_figure(situation, plan_of(situation))
    drawn(figure)
    assert figure.get_suptitle().endswith("it has no way")
    assert ": start" in figure.axes[0].get_title() and figure.axes[0].lines


@pytest.mark.parametrize("caught", [True, False])
def test_records_are_shown_with_their_answers(case, drawn, caught):
    name, situation, plan = case
    answered = plan if caught else plan_of(situation)
    record = SimpleNamespace(
        situation=situation, plans={"p": answered}, map=plan.map, family="swarm", index=7
    )
    figure, (above, below) = style.panel_grid(2, 2, (2.0, 2.0))
    draw_record(above, below, record)
    drawn(figure)
    assert above.get_title() == "swarm 7"
    assert above.images or above.patches
    assert bool(below.images) == (caught or name == "planar")
    assert below.get_title().startswith(plan.planner if caught else "no catch")


@pytest.mark.parametrize("caught", [True, False])
def test_films_move_and_look_around_a_catch_where_they_can(case, tmp_path, caught):
    _, situation, plan = case
    path = tmp_path / "film.gif"
    animate(situation, plan if caught else plan_of(situation), path, frames=3)
    around = ROUND if caught and pictures_of(situation).turns else 0
    with Image.open(path) as film:
        assert film.n_frames == 3 + around
        frames = []
        for k in range(film.n_frames):
            film.seek(k)
            frames.append(np.asarray(film.convert("RGB"), dtype=int))
    assert all(np.abs(b - a).max() > 50 for a, b in itertools.pairwise(frames))
    assert path.stat().st_size < 900_000


@pytest.mark.parametrize("name", params(FAR))
def test_films_show_arm_and_target_from_the_start_until_just_before_the_catch(name, tmp_path):
    situation, plan = FAR[name]()
    animate(situation, plan, tmp_path / "film.gif", frames=5)
    with Image.open(tmp_path / "film.gif") as film:
        for k in range(4):
            film.seek(k)
            work_space = np.asarray(film.convert("RGB"), dtype=float)[:, : film.width // 2] / 255
            for colour in (style.ARM, style.TARGET):
                assert near(work_space, colour) > 5 / work_space[..., 0].size


@pytest.mark.parametrize("name", ["spatial", "chain"])
def test_the_picture_is_larger_while_a_target_is_far_away(name):
    situation, plan = FAR[name]()
    scenery = Scenery(situation, plan.trajectory)
    halves = [scenery.window_at(t).half for t in np.linspace(0.0, scenery.end, 9)]
    assert halves[0] > 1.5 * halves[-1] == pytest.approx(1.5 * scenery.window.half)
    assert (np.diff(halves) <= 1e-12).all()


def test_a_picture_shows_arm_target_and_obstacles(solid_case):
    situation, plan = solid_case
    scenery = Scenery(situation, plan.trajectory)
    ax = style.new_figure(3.0, 3.0).subplots()
    scenery.show(ax, 0.0, pixels=150)
    image = np.asarray(ax.images[0].get_array())
    for colour in (style.ARM, style.TARGET, style.OBSTACLE):
        assert near(image, colour) > 0.0005


def test_the_camera_holds_the_arm_and_the_whole_path_of_the_target(solid_case):
    situation, plan = solid_case
    scenery = Scenery(situation, plan.trajectory, turns=True)
    left, right, bottom, top = scenery.window.extent
    for t in np.linspace(0.0, scenery.end, 7):
        things = [thing for thing in scenery.at(t) if thing.alpha == 1.0]
        arm_and_target = [thing for thing in things if near_purple_or_red(thing)]
        assert arm_and_target
        for thing in arm_and_target:
            x, y, _ = scenery.view.see(thing.corners).reshape(-1, 3).T
            assert left <= x.min() and x.max() <= right
            assert bottom <= y.min() and y.max() <= top


def near_purple_or_red(thing) -> bool:
    """Return whether faces are those of the arm or of a target."""
    colours = np.atleast_2d(np.asarray(thing.colours).reshape(-1, 3))[0]
    wanted = (style.ARM, style.TARGET)
    return any(np.allclose(colours, [int(c[k : k + 2], 16) / 255 for k in (1, 3, 5)])
               for c in wanted)  # fmt: skip
