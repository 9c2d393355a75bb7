"""Ctrl-C ends a command in one line, wherever it falls."""

from __future__ import annotations

import ctypes
import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from gcm_learn.cli import main
from gcm_learn.cli.interrupts import Interrupts

pytestmark = pytest.mark.usefixtures("interruptible")


def drop_an_interrupt() -> None:
    """Receive Ctrl-C inside a C callback, where Python ignores every exception."""
    ctypes.CFUNCTYPE(None)(lambda: signal.raise_signal(signal.SIGINT))()


def wait() -> None:
    deadline = time.monotonic() + 5.0
    while time.monotonic() < deadline:
        time.sleep(0.01)


def print_an_interrupt() -> None:
    """Do as PyErr_Print does, by which a library shows an interrupt and goes on."""
    sys.excepthook(KeyboardInterrupt, KeyboardInterrupt(), None)


@pytest.mark.parametrize("lose", [drop_an_interrupt, print_an_interrupt])
def test_a_lost_interrupt_comes_again(capsys, lose):
    with pytest.raises(KeyboardInterrupt), Interrupts() as interrupts:
        lose()
        assert interrupts.lost
        wait()
    assert capsys.readouterr().err == ""


def test_it_does_not_come_after_the_end():
    with Interrupts():
        drop_an_interrupt()
    time.sleep(0.15)


def err_after_it(situation):
    drop_an_interrupt()
    raise RuntimeError("no compiled object yet")


def err_as_compiled_code_does(situation):
    raise SystemError("returned a result with an exception set") from KeyboardInterrupt()


@pytest.mark.parametrize("plan", [err_after_it, err_as_compiled_code_does])
def test_an_error_that_follows_from_it_is_not_blamed(
    scene_file, scene, planner, capsys, monkeypatch, plan
):
    monkeypatch.setattr(planner, "plan", plan)
    assert main(["solve", str(scene_file(scene()))]) == 130
    assert capsys.readouterr() == ("", "gcm-learn: interrupted\n")


def test_other_dropped_errors_are_reported_as_ever(monkeypatch):
    reported = []
    monkeypatch.setattr(sys, "unraisablehook", lambda dropped: reported.append(dropped.exc_type))
    with Interrupts() as interrupts:
        ctypes.CFUNCTYPE(None)(lambda: 1 / 0)()
    assert reported == [ZeroDivisionError] and not interrupts.lost


ROOT = Path(__file__).parents[2]
SUITE = ROOT / "data" / "suites" / "demo.jsonl"
COMMANDS = {
    "solve": ("solve", "scenes.jsonl", "--out", "solutions.jsonl"),
    "generate": ("generate", ROOT / "data" / "specs" / "train.toml", "--out", "set"),
    "demo": ("demo", "--out", "demo"),
    "compare": ("compare", "layered,straight,gcm", "--on", "demo", "--out", "comparison"),
}


PROGRAM = """
import sys
from gcm_learn.cli import main
print("begins", flush=True)
sys.exit(main())
"""


def interrupted(command: str, moment: float, folder: Path) -> tuple[int, str]:
    """Exit code and complaint of a command whose processes all get Ctrl-C, as on a terminal."""
    scene = json.loads(SUITE.read_text("utf-8").splitlines()[0])["situation"]
    lines = [json.dumps(scene | {"name": f"scene-{k}"}) for k in range(5000)]
    (folder / "scenes.jsonl").write_text("\n".join(lines))
    run = subprocess.Popen(
        [sys.executable, "-c", PROGRAM, *map(str, COMMANDS[command])],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    assert run.stdout is not None and run.stdout.readline() == "begins\n"
    time.sleep(moment)
    os.killpg(run.pid, signal.SIGINT)
    _, error = run.communicate(timeout=60.0)
    return run.returncode, error


@pytest.mark.skipif(not hasattr(os, "killpg"), reason="no groups of processes")
@pytest.mark.parametrize(
    ("command", "moment"),
    [
        ("solve", 0.2), ("solve", 2.5), ("generate", 2.0), ("demo", 1.6), ("compare", 2.0),
    ],
)  # fmt: skip
def test_a_command_ends_in_one_line(command, moment, tmp_path):
    assert interrupted(command, moment, tmp_path) == (130, "gcm-learn: interrupted\n")


@pytest.mark.slow
@pytest.mark.parametrize("command", COMMANDS)
def test_a_command_ends_in_one_line_at_any_moment(command, tmp_path):
    for k in range(1, 20):
        ended = interrupted(command, 0.2 * k, tmp_path)
        assert ended == (130, "gcm-learn: interrupted\n"), f"after {k} fifths of a second"
