"""The pictures of the README and the documents can be drawn again."""

from __future__ import annotations

import pytest
from PIL import Image

from gcm_learn.families import family_names
from gcm_learn.planners import solve
from gcm_learn.plots import style
from gcm_learn.plots.reports import documents, solid_documents


def test_every_family_has_a_panel_or_a_sibling_with_one():
    shown = documents.shown_families()
    assert {name.removesuffix("-solid") for name in family_names("planar")} == {
        name.removesuffix("-solid") for name in shown
    }
    titles = [ax.get_title() for ax in documents.families_figure().axes]
    assert [title for title in titles if title] == shown


def test_a_shown_case_needs_more_than_a_straight_line():
    situation, plan = documents.first_case("gate", 5)
    assert plan.caught and plan.name == situation.name
    assert not solve(situation, "straight").caught
    ax = documents.draw_case(style.new_figure(2.0, 2.0).subplots(), situation, plan)
    bodies = len(situation.bodies)
    assert len(ax.patches) >= 4 * bodies  # at four instants


@pytest.mark.slow
@pytest.mark.parametrize("frames", [3, 24])
def test_gallery_writes_readable_pictures(frames, tmp_path, monkeypatch):
    monkeypatch.setattr(solid_documents, "FRAMES", frames)
    files = documents.write_gallery(tmp_path / "images")
    assert [f.name for f in files] == [
        "situation.png",
        "hand-space.png",
        "wave.png",
        "map.png",
        "catch.gif",
        "waiting.png",
        "families.png",
        "families-chain.png",
        "space-situation.png",
        "space-hand-space.png",
        "space-wave.png",
        "space-map.png",
        "space-catch.gif",
        "space-body.gif",
        "two-arms.gif",
    ]
    for file in files:
        with Image.open(file) as picture:
            assert min(picture.size) >= 280
        assert file.stat().st_size < (800_000 if file.name == "space-catch.gif" else 400_000)
