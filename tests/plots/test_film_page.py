"""Pages on which movements are turned: they need no other files, and draw the movement."""

from __future__ import annotations

import json
import re

import numpy as np
import pytest
from scipy.spatial import cKDTree

from gcm_learn.arms import hands_along, links_along
from gcm_learn.families import draw, thrown_scene
from gcm_learn.planners import solve
from gcm_learn.plots import write_film_page
from gcm_learn.plots.figures.hand_ball import frozen_cells, places_of
from gcm_learn.plots.reports.film_page import MISSED, page_data
from gcm_learn.rendering import body_poses
from tests.plots.cases import AMONG_SOLIDS, FAR, params, plan_of


@pytest.fixture(scope="module", params=params(AMONG_SOLIDS))
def case(request):
    return AMONG_SOLIDS[request.param]()


def test_the_page_needs_nothing_else(case, tmp_path):
    pytest.importorskip("plotly")
    path = write_film_page(*case, tmp_path / "page.html")
    text = path.read_text("utf-8")
    own = re.sub(r"<script>.*?</script>", "", text, count=1, flags=re.S)  # without the library
    assert len(own) < 0.1 * len(text)
    assert "http:" not in own and "https:" not in own
    assert not re.search(r'(src|href)\s*=\s*"', text[: text.index("<script>")])
    found = re.search(r'<script id="data"[^>]*>(.*?)</script>', own, re.S)
    assert json.loads(found.group(1)) == page_data(*case)


def test_without_plotly_it_says_what_to_install(case, tmp_path, monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "plotly.offline", None)
    with pytest.raises(ImportError, match=r"needs plotly: pip install 'gcm_learn\[plots\]'"):
        write_film_page(*case, tmp_path / "page.html")
    assert not (tmp_path / "page.html").exists()


def test_solids_are_where_the_arm_and_the_bodies_are(case):
    situation, plan = case
    data = page_data(*case)
    named = {solid["name"]: solid for solid in data["solids"]}
    for k in (0, -1):
        t = plan.trajectory.duration if k else 0.0
        joints = plan.trajectory.joints_at(t)
        hand, ends = hands_along(situation.arm, joints)[0][0], links_along(situation.arm, joints)[0]
        np.testing.assert_allclose(named["hand"]["centre"][k], hand, atol=2e-3)
        for i, middle in enumerate(ends[0].mean(axis=1)):
            np.testing.assert_allclose(named[f"link {i}"]["centre"][k], middle, atol=2e-3)
    places = body_poses(situation, [0.0])[0][0]
    for body, place in zip(situation.bodies, places, strict=True):
        np.testing.assert_allclose(named[body.name]["centre"][0], place, atol=1e-4)
        assert (f"approach of {body.name}" in named) == bool(body.approach)
    way = data["ways"][0]
    assert [way["x"][0], way["y"][0], way["z"][0]] == pytest.approx(named["hand"]["centre"][0])


def test_several_catches_are_marked_in_order_and_what_is_caught_is_gone():
    situation = draw("sequence-chain", 10, 0)
    plan = solve(situation, "search")
    data = page_data(situation, plan)
    assert [(c["name"], c["time"]) for c in data["catches"]] == [
        (c["body"], pytest.approx(c["time"], abs=1e-4)) for c in plan.catches
    ]
    targets = {target.name for target in situation.targets}
    named = {solid["name"]: solid for solid in data["solids"] if solid["name"] in targets}
    for name, time in ((c["body"], c["time"]) for c in plan.catches):
        assert named.pop(name)["until"] == time
    assert all(s["colour"] == MISSED and "until" not in s for s in named.values())
    for caught in data["catches"]:
        middle = body_poses(situation, [caught["time"]])[0][0]
        k = [body.name for body in situation.bodies].index(caught["name"])
        most = situation.arm.grasp + situation.bodies[k].shape.radius + 1e-3
        assert np.linalg.norm(middle[k] - caught["place"]) <= most


def test_one_catch_is_not_marked(case):
    assert page_data(*case)["catches"] == []


@pytest.mark.parametrize("name", ["spatial", "chain"])
def test_the_box_holds_the_target_that_comes_from_far_away(name):
    situation, plan = FAR[name]()
    data = page_data(situation, plan)
    box, zoom = np.array(data["box"]), np.array(data["zoom"])
    assert zoom[0] > 1.5 and zoom[-1] == 1.0 and (np.diff(zoom) <= 0.0).all()
    target = next(s for s in data["solids"] if s["name"] == situation.targets[0].name)
    away = np.abs(np.array(target["centre"]) - box.mean(axis=1))
    assert (away < zoom[:, None] * 0.5 * np.ptp(box, axis=1)).all()


def test_solids_are_closed(case):
    """Every edge of a solid belongs to two triangles, once in either sense."""
    for solid in page_data(*case)["solids"]:
        triangles = np.array(solid["triangles"])
        edges = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
        there, count = np.unique(edges, axis=0, return_counts=True)
        assert (count == 1).all()
        assert {*map(tuple, there.tolist())} == {(b, a) for a, b in there.tolist()}


def test_a_plan_without_a_catch_shows_an_arm_at_rest(case):
    situation, _ = case
    data = page_data(situation, plan_of(situation))
    assert data["ways"] == [] and data["times"][-1] == pytest.approx(situation.horizon, abs=1e-3)
    hand = next(solid for solid in data["solids"] if solid["name"] == "hand")
    assert hand["centre"][0] == hand["centre"][-1]


CHARTED = pytest.mark.slow  # compiles a march for spatial arms


@pytest.fixture(scope="module")
def charted():
    situation = thrown_scene()
    return situation, solve(situation, "marching")


@CHARTED
def test_effective_obstacles_grow_where_the_front_froze(charted):
    situation, plan = charted
    hands = page_data(situation, plan)["hands"]
    counts, corners = np.array(hands["counts"]), np.array(hands["corners"])
    assert len(counts) == len(page_data(situation, plan)["times"])
    assert counts[0] < counts[len(counts) // 2] < counts[-1] <= len(hands["triangles"])
    assert (np.diff(counts) >= 0).all() and np.max(hands["triangles"]) < len(corners)
    chart = plan.map.chart
    frozen = places_of(chart, np.argwhere(frozen_cells(plan.map)))
    away = cKDTree(frozen).query(corners)[0]
    assert away.max() < 3.0 * chart.spacing
    early = corners[np.unique(np.array(hands["triangles"])[: counts[len(counts) // 3]])]
    start = hands_along(situation.arm, situation.arm.joints)[0][0]
    late = corners[np.unique(np.array(hands["triangles"])[counts[-1] - 200 : counts[-1]])]
    assert (
        np.linalg.norm(early - start, axis=1).mean() < np.linalg.norm(late - start, axis=1).mean()
    )


@CHARTED
def test_in_hand_space_the_arm_is_a_point_among_targets(charted, case):
    solids = page_data(*charted)["solids"]
    targets = {body.name for body in charted[0].targets}
    assert {solid["name"] for solid in solids if solid["hands"]} == {"hand", *targets}
    assert page_data(*case)["hands"] is None  # without a map


@CHARTED
def test_hand_space_can_be_switched_on_where_there_is_a_map(charted, case, tmp_path):
    pytest.importorskip("plotly")
    for (situation, plan), there in ((charted, True), (case, False)):
        text = write_film_page(situation, plan, tmp_path / "page.html").read_text("utf-8")
        assert ('<input id="hands" type="checkbox">' in text) == there
        assert ("effective obstacle, in hand-space" in text) == there
