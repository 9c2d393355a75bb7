"""``gcm-learn demo``: the page, figures and files to begin with."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from gcm_learn import artifacts, plots
from gcm_learn.cli import main
from gcm_learn.cli.demo import FIGURES, PLACES


class Picture:
    """Stands for a matplotlib figure."""

    def savefig(self, place: Path) -> None:
        Path(place).write_text("picture")


@pytest.fixture(autouse=True)
def _in_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


def test_demo_says_where_its_page_is(tmp_path, capsys, monkeypatch):
    asked = []

    def build_demo(out, seed, n_random, progress):
        asked.append((out, seed, n_random))
        progress("fig1")
        return out / "index.html"

    monkeypatch.setattr("gcm_learn.plots.build_demo", build_demo)
    assert main(["demo", "--out", "a/b", "--seed", "3", "--random", "7"]) == 0
    assert asked == [(Path("a/b"), 3, 7)]
    out = capsys.readouterr().out
    assert "fig1\n" in out and (tmp_path / "a/b/index.html").as_uri() in out


def test_a_figure_goes_to_a_file_of_its_name(capsys, monkeypatch):
    monkeypatch.setattr("gcm_learn.plots.draw_figure", lambda name: Picture())
    assert main(["demo", "--figure", "fig4"]) == 0
    assert os.listdir() == ["fig4.png"] and capsys.readouterr().out == "fig4.png\n"


def test_all_are_listed_by_names_of_their_own(capsys):
    assert main(["demo", "--list"]) == 0
    listed = capsys.readouterr().out
    paths = [path for pattern in PLACES.values() for path in artifacts.source().glob(pattern)]
    assert all(path.name in listed for path in paths) and list(FIGURES) == list(plots.FIGURES)
    assert len({path.name for path in paths}) == len({path.stem for path in paths}) == len(paths)


def test_a_file_is_copied(tmp_path, capsys):
    assert main(["demo", "--copy", "ppo"]) == 0
    assert capsys.readouterr().out == "ppo.yml\n"
    original = artifacts.source() / "experiments" / "04_policies" / "ppo.yml"
    assert (tmp_path / "ppo.yml").read_bytes() == original.read_bytes()


def test_the_sample_is_copied_whole():
    dataset = pytest.importorskip("gcm_learn.dataset")
    assert main(["demo", "--copy", "sample", "--out", "mine"]) == 0
    assert len(dataset.open("mine")) == 500
