"""Work in a copy of the process: what it tells arrives, whatever becomes of it."""

from __future__ import annotations

import os
import signal
import threading

import pytest

from gcm_learn.planners.baselines.isolation import told

LONG = 20.0  # [s]


def test_what_is_told_arrives_in_order():
    large = os.urandom(300_000)  # more than a pipe holds

    def work(tell):
        tell(1)
        tell({"large": large})

    assert told(work, LONG) == ([1, {"large": large}], True)


def test_the_original_keeps_its_own_memory():
    seen = []
    assert told(lambda tell: (seen.append(1), tell(len(seen))), LONG) == ([1], True)
    assert seen == []


def test_a_crash_leaves_what_was_told_before(capfd):
    def work(tell):
        tell("before")
        os.kill(os.getpid(), signal.SIGSEGV)
        tell("after")

    assert told(work, LONG) == (["before"], False)
    assert capfd.readouterr() == ("", "")


def test_half_a_thing_does_not_count(monkeypatch):
    write = os.write

    def cut(fd, data):
        write(fd, bytes(data)[: len(data) // 2])
        os.kill(os.getpid(), signal.SIGKILL)

    def work(tell):
        tell("whole")
        monkeypatch.setattr(os, "write", cut)
        tell("cut")

    assert told(work, LONG) == (["whole"], False)


def test_what_hangs_is_ended():
    def work(tell):
        tell("before")
        while True:
            pass

    assert told(work, 0.05) == (["before"], False)


def test_an_exception_comes_back_with_its_place():
    def work(tell):
        tell(1)
        raise KeyError("lost")

    with pytest.raises(RuntimeError, match=r"(?s)in work.*KeyError: 'lost'"):
        told(work, LONG)


def test_threads_may_do_it_side_by_side():
    results = {}

    def ask(k):
        results[k] = told(lambda tell: tell(k), LONG)

    threads = [threading.Thread(target=ask, args=(k,)) for k in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert results == {k: ([k], True) for k in range(8)}
