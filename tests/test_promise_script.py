"""The script that counts broken promises: it can be stopped, goes on, and tells what is broken."""

from __future__ import annotations

import importlib.util
import json
import sys
from pathlib import Path

import pytest

from tests.referee import Verdict
from tests.spatial import EXAMPLES

SCRIPT = Path(__file__).parents[1] / "experiments" / "benchmarks" / "promise.py"
PLANE = ["plane", "--family", "static-clutter", "late-target", "--planner", "straight"]
FORCED = ["space", "--family", "bench-space", "--acceleration", "--planner", "layered"]
SPACE = ["space", "--file", str(EXAMPLES), "--planner", "straight"]


@pytest.fixture
def promise(monkeypatch, tmp_path):
    """The script as a function of its arguments; it returns the exit code and the account."""
    spec = importlib.util.spec_from_file_location("promise", SCRIPT)
    module = importlib.util.module_from_spec(spec)
    monkeypatch.setitem(sys.modules, "promise", module)  # its records look for their module
    spec.loader.exec_module(module)

    def call(*words, out="account.json"):
        path = tmp_path / out
        monkeypatch.setattr(sys, "argv", [str(SCRIPT), *map(str, words), "--out", str(path)])
        code = module.main()
        return code, json.loads(path.read_text()) if path.exists() else None

    call.module = module
    return call


def without(account, *names):
    return {name: value for name, value in account.items() if name not in names}


@pytest.mark.parametrize("words", [PLANE, SPACE], ids=["plane", "space"])
def test_what_is_stopped_goes_on_as_if_it_had_not_been(words, promise, monkeypatch):
    code, whole = promise(*words, "--catches", 12, out="whole.json")
    assert code == 0 and whole["claimed"] == 12 and whole["broken"] == []

    calls, judge = [], promise.module.judge

    def stopped(*args):
        calls.append(args)
        if len(calls) == 6:
            raise KeyboardInterrupt
        return judge(*args)

    monkeypatch.setattr(promise.module, "judge", stopped)
    code, half = promise(*words, "--catches", 12)
    assert code == 130 and half["claimed"] == 5
    monkeypatch.setattr(promise.module, "judge", judge)
    code, rest = promise(*words, "--catches", 12)
    assert code == 0
    assert without(rest, "slowest_ms") == without(whole, "slowest_ms")
    assert promise(*words, "--catches", 12)[1] == rest  # nothing is left to do


def test_what_is_broken_is_told_with_what_draws_it_again(promise, monkeypatch, capsys):
    monkeypatch.setattr(promise.module, "judge", lambda *_: Verdict(["is late"], 0.0))
    code, account = promise(*PLANE, "--catches", 2)
    assert code == 1
    first = account["broken"][0]
    assert first["complaints"] == ["is late"] and first["planner"] == "straight"
    again = ["--again", first["family"], str(first["index"])]
    assert f"broken: {' '.join(again)} --planner straight: is late" in capsys.readouterr().out
    assert promise(*PLANE, *again, out="other.json") == (1, None)
    assert capsys.readouterr().out == "is late\n"


def test_limits_of_acceleration_are_drawn_too(promise):
    module = promise.module
    for k in range(4):
        arm = module.forced(module.families.draw("bench-space", 1, k), 1, k).arm
        share = arm.max_joint_acceleration[2] / arm.max_joint_speed[2]
        assert 1 / 0.3 <= share <= 1 / 0.05
    code, account = promise(*FORCED, "--catches", 1)
    assert code == 0 and account["asked"]["acceleration"]


def test_an_account_of_something_else_is_left_alone(promise):
    _, before = promise(*PLANE, "--catches", 1)
    with pytest.raises(SystemExit, match="is about something else"):
        promise(*PLANE, "--catches", 1, "--seed", 3)
    assert promise(*PLANE, "--catches", 1) == (0, before)


def test_a_planner_that_claims_nothing_ends_it_with_a_line(promise, monkeypatch, capsys):
    monkeypatch.setattr(promise.module, "BARREN", 3)
    monkeypatch.setattr(promise.module, "complaints", lambda *_: (None, 0.0))
    code, account = promise(*PLANE, "--catches", 5)
    assert (code, account["claimed"], account["following"]) == (1, 0, 3)
    assert "no claim in 3 items in a row" in capsys.readouterr().out
