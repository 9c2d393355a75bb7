"""The page of a memory: what it tells is what is remembered."""

from __future__ import annotations

import base64
import io
import json
import re

import numpy as np
import pytest
from PIL import Image

from gcm_learn.planners import solve
from gcm_learn.plots.reports import memory as memory_page
from gcm_learn.plots.reports.memory import UNIT, principal_places, write_memory_page
from gcm_learn.recall import Memory, RawIndex, waypoints_of


@pytest.fixture
def memory(planar_case, solid_case, waiting_case):
    """Three catches: planar, in space, and with a wait."""
    cases = [planar_case, solid_case, waiting_case]
    memory = Memory(RawIndex.fit([s for s, _ in cases]))
    traces = [waypoints_of(s, solve(s, "layered")) for s, _ in cases]
    memory.add([s for s, _ in cases], traces, ["a", "b", "</script>"], ["W", "W", "Q"])
    return memory


def told(page):
    text = page.read_text("utf-8")
    assert "http:" not in text and "https:" not in text and 'src="' not in text
    assert len(re.findall("</script>", text)) == 2  # the data closes no script
    found = re.search(r'<script id="data"[^>]*>(.*?)</script>', text, re.S)
    return json.loads(found.group(1))


def test_points_are_the_memories(memory, tmp_path):
    data = told(write_memory_page(memory, tmp_path / "page", groups={"x": ["p", "q", "r"]}))
    assert [p["words"]["family"] for p in data["points"]] == ["a", "b", "</script>"]
    assert [p["words"]["x"] for p in data["points"]] == ["p", "q", "r"]
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
