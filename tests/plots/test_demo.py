"""The demo: one page that tells the whole story, and what it links to."""

from __future__ import annotations

import re

import pytest

from gcm_learn.families.paper import PAPER_SCENES
from gcm_learn.maps import build_map
from gcm_learn.planners import broken_promise, solve
from gcm_learn.plots import build_demo
from gcm_learn.plots.reports import demo
from gcm_learn.scene import TOP_SPEED, pack_bodies
from gcm_learn.situation import read_situations

SCREENS, SCREEN = 4, 900  # [CSS pixels]


def test_twins_are_caught_by_one_movement():
    plan, (moving, resting) = demo.twins()
    speeds = [pack_bodies(one).rows[:, TOP_SPEED].max() for one in (moving, resting)]
    assert speeds[0] > 0.0 == speeds[1]
    assert build_map(resting, demo.FRONT).effective_obstacles.any()
    assert plan.caught and not solve(moving, "straight").caught
    assert broken_promise(moving, plan) is None and broken_promise(resting, plan) is None


@pytest.mark.slow
@pytest.mark.parametrize("n_random", [0, 3])
def test_demo_end_to_end(n_random, tmp_path, browser, monkeypatch):
    monkeypatch.setattr(demo, "MEMORIES", 5)
    steps = []
    page = build_demo(tmp_path / "demo", 0, n_random, steps.append)
    text = page.read_text("utf-8")
    assert page == tmp_path / "demo" / "index.html" and len(steps) >= len(PAPER_SCENES)
    images = re.findall(r'src="([^"]+)"', text)
    films = ("fig3.gif", "gate.gif", "thrown-ball.gif")
    assert sorted(images) == sorted(
        [*films, "twins.png", *(f"{figure}.png" for figure in demo.SHOWN)]
    )
    for image in images:
        assert (page.parent / image).stat().st_size > 1000
    assert {s.name for s in read_situations(page.parent / "paper.jsonl")} == set(PAPER_SCENES)
    assert len(list(read_situations(page.parent / "beyond.jsonl"))) == 2
    assert (page.parent / "memory" / "index.html").exists()
    assert not re.search(r'(src|href)="(/|http)', text)
    assert ("random situations" in text) == (n_random > 0)
    shown = browser.new_page(viewport={"width": 1200, "height": SCREEN})
    shown.goto(page.as_uri())
    assert shown.evaluate("document.documentElement.scrollHeight") <= SCREENS * SCREEN
    shown.close()
