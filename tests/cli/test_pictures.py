"""``gcm-learn solve --film`` and ``--plot``: the plumbing around the plots."""

from __future__ import annotations

from pathlib import Path

import pytest

from gcm_learn.cli import main
from tests.panda import PANDA
from tests.spatial import EXAMPLES


@pytest.fixture(autouse=True)
def _in_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


def test_the_chosen_situation_is_filmed(scene_file, scene, planner, capsys, monkeypatch):
    def animate(situation, plan, path):
        Path(path).write_text(f"{situation.name} {plan.planner}")

    monkeypatch.setattr("gcm_learn.plots.animate", animate)
    path = str(scene_file(scene("a"), scene("b c")))
    assert main(["solve", path, "--index", "1", "--film", "out.gif"]) == 0
    assert Path("out.gif").read_text() == "b c quiet" and set(planner.asked) == {"b c"}
    assert capsys.readouterr().out.count("\n") == 1


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ("--index 2", "--index 2: "),
        ("--film a.gif", "--film: shows one of the 2 situations, see --index"),
        ("--index 1 --film a.png", "--film a.png: the name must end in .gif"),
        ("--index 1 --film a.html", ".gif"),  # a planar arm is not turned
        ("--index 1 --film a.gif --out a.gif", "--film a.gif: is the file of --out, too"),
    ],
)
def test_films_are_refused_before_planning(options, said, scene_file, scene, planner, capsys):
    path = scene_file(scene("a"), scene("b"))
    Path("a.gif").touch()
    assert main(["solve", str(path), *options.split()]) == 2
    stdout, stderr = capsys.readouterr()
    assert stdout == "" and stderr.count("\n") == 1 and said in stderr and planner.asked == []


@pytest.mark.parametrize(
    ("name", "begins", "file", "index"),
    [
        pytest.param("a.gif", b"GIF8", EXAMPLES, 3, marks=pytest.mark.slow),
        pytest.param("a.html", b"<!doctype html>", EXAMPLES, 3, marks=pytest.mark.slow),
        pytest.param("a.gif", b"GIF8", PANDA, 0, marks=pytest.mark.slow),
        ("a.html", b"<!doctype html>", PANDA, 0),
    ],
)
def test_arms_that_move_in_their_joints_are_filmed(name, begins, file, index, capsys):
    if name.endswith("html"):
        pytest.importorskip("plotly")
    argv = ["solve", str(file), "--planner", "straight", "--index", str(index), "--film", name]
    assert main(argv) == 0
    assert Path(name).read_bytes().startswith(begins)
    assert capsys.readouterr().out.count("\n") == 1


def test_solve_draws_chains(capsys):
    assert main(["solve", str(PANDA), "--planner", "straight", "--plot", "drawn"]) == 0
    assert Path("drawn/panda-bounce.png").read_bytes().startswith(b"\x89PNG")
