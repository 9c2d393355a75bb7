"""The page of a memory: what it tells is what is remembered."""

from __future__ import annotations

import base64
import io
import json
import re

import numpy as np
import pytest
from PIL import Image

from gcm_learn import recall
from gcm_learn.planners import solve
from gcm_learn.plots.reports import clusters as cluster_page, memory as memory_page
from gcm_learn.plots.reports.memory import UNIT, principal_places, write_memory_page
from tests.recall.conftest import memory_by


@pytest.fixture
def memory(planar_case, solid_case, waiting_case):
    """Three catches: planar, in space, and with a wait."""
    cases = [planar_case, solid_case, waiting_case]
    memory = recall.Memory(recall.RawIndex.fit([s for s, _ in cases]))
    traces = [recall.waypoints_of(s, solve(s, "layered")) for s, _ in cases]
    memory.add([s for s, _ in cases], traces, ["a", "b", "</script>"], ["W", "W", "Q"])
    return memory


def told(page):
    text = page.read_text("utf-8")
    assert "http:" not in text and "https:" not in text and 'src="' not in text
    assert len(re.findall("</script>", text)) == 2  # the data closes no script
    found = re.search(r'<script id="data"[^>]*>(.*?)</script>', text, re.S)
    return json.loads(found.group(1))


def test_points_are_the_memories(memory, tmp_path):
    data = told(write_memory_page(memory, tmp_path / "page"))
    assert [p["words"]["family"] for p in data["points"]] == ["a", "b", "</script>"]
    for k, point in enumerate(data["points"]):
        entry = memory[k]
        assert point["end"] == pytest.approx(1e3 * entry.waypoints.catch_time, abs=1)
        hand = np.reshape(point["hand"], (-1, 2)) / UNIT
        np.testing.assert_allclose(hand[0], entry.situation.arm.hand, atol=1e-3)
        assert len(point["time"]) == len(hand) and len(point["bodies"]) == len(
            entry.situation.bodies
        )
        image = Image.open(io.BytesIO(base64.b64decode(point["map"])))
        assert image.size == (memory_page.N, memory_page.N) and len(image.getcolors()) > 5


def test_a_body_is_where_it_is_at_the_catch(memory, tmp_path):
    """The hand ends within grasp of a target's outline."""
    data = told(write_memory_page(memory, tmp_path))
    for k, point in enumerate(data["points"]):
        hand, arm = np.reshape(point["hand"], (-1, 2))[-1], memory[k].situation.arm
        gaps = []
        for body in point["bodies"]:
            if body["target"] and "cuts" in body:
                corners = np.reshape(body["cuts"][-1], (-1, 2))
                gaps.append(np.hypot(*(corners - hand).T).min())
            elif body["target"]:
                size = body.get("radius") or np.abs(body["shape"]).max()
                gaps.append(np.hypot(*(np.array(body["at"][-2:]) - hand)) - size)
        assert min(gaps) <= UNIT * arm.grasp + (200 if "cuts" in point["bodies"][0] else 2)


def test_directions_of_one_line_lie_on_one_line():
    rng = np.random.default_rng(0)
    rows = rng.standard_normal((50, 2)) @ rng.standard_normal((2, 7))
    places = principal_places(rows)
    assert places.shape == (50, 2) and places[:, 0].var() >= places[:, 1].var() > 0.0
    np.testing.assert_allclose(places, principal_places(3.0 * rows), atol=1e-6)


def test_a_page_of_clusters_tells_of_each(memory, tmp_path):
    pytest.importorskip("sklearn")
    found = recall.cluster(memory, "raw", count=2)
    page = write_memory_page(memory, tmp_path, count=1, found=found)
    data, text = told(page), page.read_text("utf-8")
    assert {p["words"]["cluster"] for p in data["points"]} == {"cluster 1", "cluster 2"}
    shown = [int(k) for k in re.findall(r'data-point="(\d+)"', text)]
    assert [data["points"][k]["words"]["cluster"] for k in shown] == ["cluster 1", "cluster 2"]
    assert "Cluster 1</b></a>, 2 catches" in text and "2 clusters of their raw parameters" in text


def test_the_page_says_whether_maps_cluster_by_movement():
    """Shares within clusters of maps, within those of movements, and among all."""
    hardly, well = (cluster_page.verdict("maps", own, 0.7, 0.4) for own in (0.5, 0.6))
    assert "maps do not cluster by movement: they give 33% of that gain" in hardly
    assert "maps cluster by movement, too: they give 67% of that gain" in well
    assert "themselves" not in cluster_page.verdict("movements", 0.7, 0.7, 0.4)


def test_traits_are_those_of_the_movement():
    """Straight outwards, round by the left, and a wait before the hand turns to the right."""
    share = np.linspace(0.0, 1.0, 24)
    knots = np.zeros((3, 24, 4))
    knots[:, :, 2] = np.array([[0.2], [0.5], [0.9]]) * share
    knots[0, :, 1], knots[1, :, 1], knots[2, :, 1] = 0.2 + 0.7 * share, 0.5, 0.8
    knots[1, :, 0], knots[2, :, 0] = 2.0 * share, -0.6 * share
    knots[2, 4, 3] = 0.3
    memory = memory_by(recall.RandomIndex(), np.zeros((3, 16)), knots, np.zeros((3, 2)))
    told = [{n for n, has in cluster_page.traits(memory).items() if has[k]} for k in range(3)]
    assert told[0] == {"straight", "outwards", "early"}
    assert told[1] == {"makes a detour", "to the left"}
    assert told[2] == {"straight", "waits", "to the right", "late"}
