"""The demo: one folder that tells the whole story."""

from __future__ import annotations

import re

import pytest

from gcm_learn.families.paper import PAPER_SCENES
from gcm_learn.plots import FIGURES, build_demo
from gcm_learn.situation import read_situations


@pytest.mark.slow
def test_demo_end_to_end(tmp_path):
    steps = []
    page = build_demo(tmp_path / "demo", 0, 3, steps.append)
    text = page.read_text("utf-8")
    assert page == tmp_path / "demo" / "index.html"
    images = re.findall(r'src="([^"]+)"', text)
    for name in (
        *(f"{figure}.png" for figure in FIGURES if not figure.endswith("-space")),
        "fig4.gif",
        "gate.gif",
        "gate.png",
        "random.png",
    ):
        assert name in images
    for image in images:
        assert (page.parent / image).stat().st_size > 1000
    assert {s.name for s in read_situations(page.parent / "paper.jsonl")} == set(PAPER_SCENES)
    assert len(steps) >= len(PAPER_SCENES)
    assert not re.search(r'(src|href)="(/|http)', text)


@pytest.mark.slow
def test_demo_without_random_situations(tmp_path):
    page = build_demo(tmp_path, 0, 0, lambda step: None)
    assert "random.png" not in page.read_text("utf-8")
