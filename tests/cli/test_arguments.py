"""Arguments: help that helps, mistakes that end in one line."""

from __future__ import annotations

import pytest

import gcm_learn
from gcm_learn.cli import main
from gcm_learn.cli.arguments import COMMANDS

MISTAKES = [
    ([], "solve, demo, figure, animate"),
    (["fly"], "command: 'fly' is not one of solve, demo"),
    (["slove", "a.json"], "command: 'slove' is not known; did you mean 'solve'?"),
    (["solve", "a.json", "--planner", "layred"], "did you mean 'layered'?"),
    (["draw", "gat"], "family: 'gat' is not known; did you mean 'gate'?"),
    (["figure", "fgi8"], "fig8-body; did you mean 'fig8'?"),
    (["evaluate", "--policies", "layered,straigt"], "did you mean 'straight'?"),
    (["solve"], "FILE"),
    (["solve", "a.json", "--colour", "red"], "--colour"),
    (["solve", "a.json", "--planer", "gcm"], "did you mean --planner?"),
    (["solve", "a.json", "b.json"], "b.json"),
    (["draw", "gate", "--n", "3"], "Unrecognized options: --n, 3 (see gcm-learn draw --help)"),
    (["demo", "--count", "3"], "Unrecognized options: --count, 3 (see gcm-learn demo --help)"),
    (["solve", "a.json", "--deadline", "abc"], ": --deadline: no number: 'abc' (see"),
    (["execute", "a.json", "--noise", "abc"], ": --noise: no number: 'abc' (see"),
    (["draw", "gate", "--count", "1e3"], ": --count: no whole number: '1e3' (see"),
    (["solve", "a.json", "--planner"], "--planner"),
    (["demo", "--seed", "one"], "--seed"),
    (["demo", "--seed", "-1"], "--seed -1"),
    (["demo", "--random", "-1"], "--random -1"),
    (["warm-up", "--planners", "layerd"], "did you mean 'layered'?"),
    (["warm-up", "--planners", " ,"], "--planners: names no planner"),
    (["warm-up", "--workers", "0"], "--workers 0"),
]


@pytest.mark.parametrize(("argv", "said"), MISTAKES)
def test_a_mistake_is_one_line(argv, said, capsys):
    assert main(argv) == 2
    stdout, stderr = capsys.readouterr()
    assert stdout == "" and stderr.count("\n") == 1
    assert stderr.startswith("gcm-learn: ") and said in stderr


@pytest.mark.parametrize("command", COMMANDS)
def test_help_names_the_options(command, capsys):
    assert main([command, "--help"]) == 0
    stdout, stderr = capsys.readouterr()
    assert f"gcm-learn {command}" in stdout and "{None}" not in stdout and stderr == ""


def test_help_has_examples(capsys):
    assert main(["--help"]) == 0
    stdout = capsys.readouterr().out
    assert "gcm-learn solve scenes.jsonl --out solutions.jsonl" in stdout


def test_version(capsys):
    assert main(["--version"]) == 0
    assert capsys.readouterr().out == f"gcm-learn {gcm_learn.__version__}\n"


def test_kernels_are_compiled_for_every_kind_of_arm(capsys):
    assert main(["warm-up", "--planners", "straight", "--workers", "1"]) == 0
    assert capsys.readouterr() == ("compiled for straight\n", "")
