"""The demo: one folder that tells the whole story."""

from __future__ import annotations

import re

import pytest

from gcm_learn.families.paper import PAPER_SCENES
from gcm_learn.motion import rules_of, verify
from gcm_learn.plots import FIGURES, build_demo
from gcm_learn.plots.reports.catches import NAMES, kept_catches, scene_of
from gcm_learn.scene import pack
from gcm_learn.situation import read_situations


@pytest.mark.slow
def test_demo_end_to_end(tmp_path):
    steps = []
    page = build_demo(tmp_path / "demo", 0, 3, steps.append)
    text = page.read_text("utf-8")
    assert page == tmp_path / "demo" / "index.html"
    images = re.findall(r'src="([^"]+)"', text)
    for name in (
        *(f"{figure}.png" for figure in FIGURES if not figure.endswith(("-space", "-body"))),
        "fig4.gif",
        "gate.gif",
        "gate.png",
        "fig5-space.gif",
        "fig8-space.gif",
        "thrown-ball.gif",
        "random.png",
    ):
        assert name in images
    for image in images:
        assert (page.parent / image).stat().st_size > 1000
    assert {s.name for s in read_situations(page.parent / "paper.jsonl")} == set(PAPER_SCENES)
    assert len(list(read_situations(page.parent / "space.jsonl"))) == 3
    assert len(steps) >= len(PAPER_SCENES)
    assert not re.search(r'(src|href)="(/|http)', text)


def test_kept_catches_are_those_of_the_scenes_and_hold():
    kept = kept_catches()
    assert [plan.name for _, plan in kept] == list(NAMES)
    for situation, plan in kept:
        assert situation == scene_of(plan.name)
        scene, names = pack(situation), [body.name for body in situation.bodies]
        verdict = verify(scene, rules_of(scene), plan.trajectory, names.index(plan.catch_body))
        assert verdict.reason is None


@pytest.mark.slow
def test_demo_without_random_situations(tmp_path):
    page = build_demo(tmp_path, 0, 0, lambda step: None)
    assert "random.png" not in page.read_text("utf-8")
