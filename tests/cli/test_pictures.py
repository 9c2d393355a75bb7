"""``gcm-learn demo``, ``figure`` and ``animate``: the plumbing around the plots."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from gcm_learn.cli import main
from gcm_learn.recall import Memory, RandomIndex
from tests.panda import PANDA
from tests.spatial import EXAMPLES


class Picture:
    """Stands for a matplotlib figure."""

    def savefig(self, place: Path) -> None:
        Path(place).write_text("picture")


@pytest.fixture
def _in_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


@pytest.mark.usefixtures("_in_folder")
def test_demo_says_where_its_page_is(tmp_path, capsys, monkeypatch):
    asked = []

    def build_demo(out, seed, n_random, progress, beside):
        asked.append((out, seed, n_random))
        assert beside == []
        progress("fig1")
        return out / "index.html"

    monkeypatch.setattr("gcm_learn.plots.build_demo", build_demo)
    assert main(["demo", "--out", "a/b", "--seed", "3", "--random", "7", "--compare", "0",
                 "--memory", "0"]) == 0  # fmt: skip
    assert asked == [(Path("a/b"), 3, 7)]
    out = capsys.readouterr().out
    assert "fig1\n" in out and (tmp_path / "a/b/index.html").as_uri() in out


@pytest.mark.usefixtures("_in_folder")
def test_figure_goes_to_a_file_of_its_name(capsys, monkeypatch):
    monkeypatch.setattr("gcm_learn.plots.draw_figure", lambda name: Picture())
    assert main(["figure", "fig4"]) == 0
    assert os.listdir() == ["fig4.png"] and capsys.readouterr().out == "fig4.png\n"


@pytest.mark.usefixtures("_in_folder")
@pytest.mark.parametrize(
    ("argv", "said"),
    [
        (["fig99"], "fig4"),
        (["fig4", "--out", "a.doc"], ".png"),
        (["fig4", "--out", "x/a.png"], "x/a.png"),
    ],
)
def test_figure_refuses(argv, said, capsys):
    assert main(["figure", *argv]) == 2
    stdout, stderr = capsys.readouterr()
    assert stdout == "" and stderr.count("\n") == 1 and said in stderr and os.listdir() == []


@pytest.mark.usefixtures("_in_folder")
def test_animate_shows_the_chosen_situation(scene_file, scene, planner, capsys, monkeypatch):
    def animate(situation, plan, path):
        Path(path).write_text(f"{situation.name} {plan.planner}")

    monkeypatch.setattr("gcm_learn.plots.animate", animate)
    path = scene_file(scene("a"), scene("b c"))
    assert main(["animate", str(path), "--index", "1"]) == 0
    assert Path("b_c.gif").read_text() == "b c quiet" and planner.asked == ["b c"]
    assert capsys.readouterr().out == "b_c.gif\n"


@pytest.mark.usefixtures("_in_folder")
@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--index", "2"], "--index 2"),
        (["--index", "-1"], "--index -1"),
        (["--out", "a.png"], ".gif"),
        (["--out", "a.html"], ".gif"),  # a planar arm is not turned
    ],
)
def test_animate_refuses(options, said, scene_file, scene, planner, capsys):
    path = scene_file(scene("a"), scene("b"))
    assert main(["animate", str(path), *options]) == 2
    stdout, stderr = capsys.readouterr()
    assert stdout == "" and stderr.count("\n") == 1 and said in stderr and planner.asked == []


@pytest.mark.usefixtures("_in_folder")
@pytest.mark.parametrize(("name", "begins"), [("a.gif", b"GIF8"), ("a.html", b"<!doctype html>")])
@pytest.mark.parametrize(("file", "index"), [(EXAMPLES, 3), (PANDA, 0)])
def test_animate_shows_arms_that_move_in_their_joints(name, begins, file, index, capsys):
    if name.endswith("html"):
        pytest.importorskip("plotly")
    argv = ["animate", str(file), "--planner", "straight", "--index", str(index), "--out", name]
    assert main(argv) == 0
    assert Path(name).read_bytes().startswith(begins)
    assert capsys.readouterr().out == f"{name}\n"


@pytest.mark.usefixtures("_in_folder")
def test_solve_draws_chains(capsys):
    assert main(["solve", str(PANDA), "--planner", "straight", "--plot", "drawn"]) == 0
    assert Path("drawn/panda-bounce.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.usefixtures("_in_folder")
def test_gallery_shows_a_memory_as_points(tmp_path, capsys, monkeypatch):
    asked = []

    def write_memory_page(memory, out, *, count):
        asked.append((memory.index.name, len(memory), out, count))
        return out / "index.html"

    monkeypatch.setattr("gcm_learn.plots.write_memory_page", write_memory_page)
    Memory(RandomIndex()).save(tmp_path / "m")
    assert main(["gallery", "m", "--out", "page", "--each", "3"]) == 0
    assert asked == [("random", 0, Path("page"), 300)]
    assert (tmp_path / "page/index.html").as_uri() in capsys.readouterr().out
    (tmp_path / "m" / "manifest.json").write_text('{"format": "gcm-learn/memory@1"}')
    assert main(["gallery", "m"]) == 2  # it says that it is a memory, and is damaged
    assert "m/manifest.json" in capsys.readouterr().err
