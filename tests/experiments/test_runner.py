"""One command lists and runs all experiments."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from experiments import __main__ as runner

ROOT = Path(__file__).parents[2]
FOLDERS = sorted(path.parent for path in runner.HERE.glob("*/README.md"))
ANSWERED = sorted(path.parent for path in runner.HERE.glob("answered/*/README.md"))


def asked(*words):
    """Return what the command answers, from the repository's root."""
    environment = os.environ | {"PYTHONPATH": str(ROOT), "MPLBACKEND": "Agg"}
    command = [sys.executable, "-m", "experiments", *words]
    return subprocess.run(
        command, cwd=ROOT, env=environment, capture_output=True, text=True, check=False
    )


def test_every_experiment_is_listed_with_its_question(capsys):
    runner.main([])
    lines = capsys.readouterr().out.splitlines()
    for folder in FOLDERS:
        (line,) = [line for line in lines if line.split()[0] == folder.name]
        assert line.endswith("?"), folder.name
    assert len(lines) == len(runner.scripts()) + len(ANSWERED)


@pytest.mark.parametrize("words", [[], ["recompute"]], ids=["run", "recompute"])
def test_an_answered_experiment_names_the_commit_of_its_code(words):
    answer = asked(*words, "23_seeds")
    assert answer.returncode != 0
    last = answer.stderr.splitlines()[-1]
    assert re.search(r"23_seeds: answered; its code stands at commit [0-9a-f]{7}$", last)


def test_answered_experiments_keep_no_code():
    assert len(ANSWERED) == 14
    assert not [*runner.HERE.glob("answered/**/*.py")]


def test_every_folder_of_a_question_has_a_page_and_a_run():
    asking = {*runner.HERE.glob("[0-9]*"), runner.HERE / "benchmarks"}
    assert asking == set(FOLDERS)
    assert {path.name for path in asking} <= set(runner.scripts())


@pytest.mark.parametrize(
    ("name", "reason"),
    [("05_recal", "did you mean '05_recall'?"), ("11_comparison/spce", "'11_comparison/space'?")],
)
def test_a_wrong_name_is_one_line_that_names_the_nearest(name, reason):
    with pytest.raises(SystemExit) as stopped:
        runner.main([name])
    assert stopped.value.code.endswith(reason)
    assert "\n" not in stopped.value.code


def test_a_script_gets_the_words_after_its_name_and_finds_its_neighbours():
    answer = asked("11_comparison", "noise", "out", "--count", "few")
    assert answer.returncode == 2
    assert "argument --count: invalid int value: 'few'" in answer.stderr


def test_a_folder_without_a_dataset_is_one_line(tmp_path):
    answer = asked("10_map_embedding", str(tmp_path), str(tmp_path))
    assert answer.returncode == 1
    assert answer.stderr.splitlines()[-1].startswith(f"{tmp_path}: holds no dataset")
    assert "Traceback" not in answer.stderr


@pytest.mark.slow
@pytest.mark.parametrize("name", [name for name in runner.scripts() if "/" not in name])
def test_every_experiment_says_how_it_is_run(name):
    answer = asked(name, "--help")
    assert answer.returncode == 0, answer.stderr
    assert answer.stdout.startswith("usage:")


def test_only_the_runner_changes_where_modules_are_found():
    changing = [p.name for p in runner.HERE.rglob("*.py") if "sys.path" in p.read_text("utf-8")]
    assert changing == ["__main__.py"]


@pytest.mark.parametrize(
    "folder", [*(p for p in FOLDERS if p.name[0].isdigit()), *ANSWERED], ids=lambda p: p.name
)
def test_every_page_has_the_parts_of_an_experiment(folder):
    page = (folder / "README.md").read_text("utf-8")
    for part in ("Question", "Method", "Result", "What it means", "What it does not say"):
        assert f"**{part}" in page, part
    assert f"python -m experiments {folder.name}" in page
