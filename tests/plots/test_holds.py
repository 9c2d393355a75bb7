"""Pictures of holds: what is carried goes with the hand, places and holds are marked."""

from dataclasses import replace

import numpy as np
import pytest

from gcm_learn.arms import hands_along
from gcm_learn.families import draw
from gcm_learn.planners import solve
from gcm_learn.plots import plan_figure, write_film_page
from gcm_learn.plots.figures.scenery import Scenery
from gcm_learn.plots.reports.film_page import page_data
from gcm_learn.rendering import body_faces, body_poses, with_carries
from gcm_learn.situation import Cloud, Margin
from tests.judging import judge
from tests.plots.cases import plan_of


@pytest.fixture(scope="module")
def pick():
    """Return a situation with a bin, and a plan that puts the target there."""
    drawn = ((s, solve(s)) for s in (draw("panda-bin", 1, k) for k in range(6)))
    situation, plan = next(pair for pair in drawn if pair[1].placed is not None)
    assert not judge(situation, plan)
    return situation, plan


def test_a_carried_target_keeps_its_place_in_the_hand_and_ends_in_its_place(pick):
    situation, plan = pick
    k = situation.bodies.index(situation.targets[0])
    shown, moves = with_carries(situation, plan), plan.trajectory
    held = plan.held_until
    before = np.linspace(0.0, held, 20)
    law, drawn = (body_poses(s, before)[0][:, k] for s in (situation, shown))
    np.testing.assert_allclose(drawn, law, atol=2e-3)
    times = np.linspace(held, plan.placed, 30)
    centres = body_poses(shown, times)[0][:, k]
    apart = np.linalg.norm(centres - hands_along(situation.arm, moves.joints_at(times))[0], axis=1)
    np.testing.assert_allclose(apart, apart[0], atol=2e-3)
    assert np.linalg.norm(centres[0] - law[-1]) < 1e-6
    place = situation.targets[0].place
    assert np.linalg.norm(centres[-1] - place.position) <= place.within + 1e-6
    assert np.ptp(centres, axis=0).max() > 0.1


def test_hold_and_place_are_in_the_figure_and_its_key(pick):
    situation, plan = pick
    figure = plan_figure(situation, plan)
    words = {text.get_text() for text in figure.legends[0].get_texts()}
    assert {"hold", "place"} <= words
    assert "placed at" in figure.get_suptitle()
    crosses = [line for ax in figure.axes for line in ax.lines if line.get_marker() == "x"]
    assert len(crosses) == 2
    bare = replace(situation.targets[0], hold=None, place=None, ignore=(), ignore_for=None)
    touched = replace(situation, bodies=(bare, *situation.obstacles))
    figure = plan_figure(touched, solve(touched))
    assert not {"hold", "place"} & {text.get_text() for text in figure.legends[0].get_texts()}


def test_a_film_shows_a_hold_from_the_catch_on(pick):
    situation, plan = pick
    seen = Scenery(situation, plan.trajectory, catches=plan.catches)
    figure = plan_figure(situation, plan)
    counts = []
    for t in (0.5 * plan.catch_time, plan.held_until):
        ax = figure.add_subplot()
        seen.show(ax, t, pixels=60)
        counts.append(len(ax.lines))
    assert counts[1] == counts[0] + 1


def test_a_page_has_the_place_and_carries_the_target(pick):
    situation, plan = pick
    data = page_data(situation, plan)
    solids = {solid["name"]: solid for solid in data["solids"]}
    (hold,) = (way for way in data["ways"] if way["name"] == "hold of target")
    start, end = (plan.trajectory.hand_at(t) for t in (plan.catch_time, plan.held_until))
    held = [name == "target" for name in data["held"]]
    between = np.array(data["times"]) - plan.catch_time, plan.held_until - np.array(data["times"])
    assert held == (np.minimum(*between) >= 0.0).tolist() and any(held)
    np.testing.assert_allclose([hold[a][0] for a in "xyz"], start, atol=1e-4)
    np.testing.assert_allclose([hold[a][-1] for a in "xyz"], end, atol=1e-4)
    place = solids["place of target"]
    assert place["centre"][0] == pytest.approx(situation.targets[0].place.position, abs=1e-3)
    last = np.array(solids["target"]["centre"][-1])
    assert np.linalg.norm(last - place["centre"][0]) <= situation.targets[0].place.within + 1e-3


def test_margins_grow_in_pictures(pick):
    situation = pick[0]
    wall = replace(situation.obstacles[0], margin=Margin(0.0, 0.1))
    wide = replace(situation, bodies=(situation.targets[0], wall), end="free")
    widths = []
    for t in (0.0, 0.5, 1.0):
        shells = [faces for faces in body_faces(wide, t) if faces.alpha < 1.0]
        widths += [float(np.ptp(shell.corners[..., 2])) for shell in shells]
    assert len(widths) == 2 and widths[1] == pytest.approx(widths[0] + 0.1)


def test_margins_and_points_left_out_are_in_keys_and_margins_grow_on_the_page(pick, tmp_path):
    pytest.importorskip("plotly")
    situation, wall = pick[0], pick[0].obstacles[0]
    points = np.random.default_rng(3).uniform(-0.15, 0.15, (9_000, 3))
    dust = replace(wall, name="dust", shape=Cloud(points, 0.004), margin=Margin(0.03, 0.1))
    bodies = (situation.targets[0], replace(wall, margin=Margin(0.0, 0.1)), dust)
    wide = replace(situation, bodies=bodies, end="free")
    plan = plan_of(wide)
    words = {text.get_text() for text in plan_figure(wide, plan).legends[0].get_texts()}
    note = next(word for word in words if "points" in word)
    assert "margin" in words and note.endswith(" of 9,000 points drawn")
    text = write_film_page(wide, plan, tmp_path / "page.html").read_text("utf-8")
    assert "of 9,000 points drawn" in text and "margin</span>" in text and "hold</span>" in text
    data = page_data(wide, plan)
    solids, times = {solid["name"]: solid for solid in data["solids"]}, data["times"]
    for name, now in ((wall.name, 0.0), ("dust", 0.03)):
        margin, shape = solids[f"margin of {name}"], np.array(solids[name]["corners"])
        np.testing.assert_allclose(margin["wide"], now + 0.1 * np.array(times), atol=2e-4)
        for k in (0, len(times) // 2, -1):
            level = margin["levels"][margin["level"][k]]
            out = np.array(level["corners"]) + margin["wide"][k] * np.array(level["outward"])
            grown = 0.5 * (np.ptp(out, axis=0) - np.ptp(shape, axis=0))
            np.testing.assert_allclose(grown, margin["wide"][k], atol=0.006)
