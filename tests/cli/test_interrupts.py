"""Ctrl-C ends a command in one line, wherever it falls."""

from __future__ import annotations

import ctypes
import signal
import sys
import time

import pytest

from gcm_learn.cli import main
from gcm_learn.cli.interrupts import Interrupts


@pytest.fixture(autouse=True)
def interrupts_count():
    """Ctrl-C raises, also where the tests were started in the background, which ignores it."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


def drop_an_interrupt() -> None:
    """Receive Ctrl-C inside a C callback, where Python ignores every exception."""
    ctypes.CFUNCTYPE(None)(lambda: signal.raise_signal(signal.SIGINT))()


def wait() -> None:
    deadline = time.monotonic() + 5.0
    while time.monotonic() < deadline:
        time.sleep(0.01)


def test_a_dropped_interrupt_comes_again(capsys):
    with pytest.raises(KeyboardInterrupt), Interrupts() as interrupts:
        drop_an_interrupt()
        assert interrupts.lost
        wait()
    assert capsys.readouterr().err == ""


def test_it_does_not_come_after_the_end():
    with Interrupts():
        drop_an_interrupt()
    time.sleep(0.15)


def test_an_error_that_follows_from_it_is_not_blamed(
    scene_file, scene, planner, capsys, monkeypatch
):
    def plan(situation):
        drop_an_interrupt()
        raise RuntimeError("no compiled object yet")

    monkeypatch.setattr(planner, "plan", plan)
    assert main(["solve", str(scene_file(scene()))]) == 130
    assert capsys.readouterr() == ("", "gcm-learn: interrupted\n")


def test_other_dropped_errors_are_reported_as_ever(monkeypatch):
    reported = []
    monkeypatch.setattr(sys, "unraisablehook", lambda dropped: reported.append(dropped.exc_type))
    with Interrupts() as interrupts:
        ctypes.CFUNCTYPE(None)(lambda: 1 / 0)()
    assert reported == [ZeroDivisionError] and not interrupts.lost
