"""Processes beside this one: their number, their beginning and their end."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from functools import partial

import pytest

from gcm_learn import compiled, processes
from gcm_learn.errors import PlatformError
from gcm_learn.planners import get_planner
from gcm_learn.planners.baselines import isolation
from gcm_learn.processes import local
from tests.processes.work import compile_something, say

NOT_EVERYWHERE = [
    (os, "sched_getaffinity"), (os, "fork"), (signal, "pthread_sigmask"), (signal, "setitimer"),
]  # fmt: skip


@pytest.fixture
def elsewhere(monkeypatch):
    """A system that lacks what macOS or Windows lack."""
    for module, name in NOT_EVERYWHERE:
        monkeypatch.delattr(module, name)
    monkeypatch.setattr(local.resource_tracker, "_HAVE_SIGMASK", False)


def test_cores_are_those_that_this_process_may_use(monkeypatch):
    monkeypatch.setattr(os, "sched_getaffinity", lambda process: {3, 5}, raising=False)
    assert processes.cores() == 2


def test_cores_where_nobody_can_tell(elsewhere, monkeypatch):
    monkeypatch.setattr(os, "cpu_count", lambda: 6)
    assert processes.cores() == 6
    monkeypatch.setattr(os, "cpu_count", lambda: None)
    assert processes.cores() == 1


def test_a_pool_works_elsewhere_too(elsewhere):
    with processes.pool(1) as executor:
        assert executor.submit(os.getpid).result() != os.getpid()


def test_what_forks_says_that_it_cannot_elsewhere(monkeypatch):
    monkeypatch.setattr(isolation, "POSSIBLE", False)
    with pytest.raises(PlatformError, match=r"^st-rrt-star needs a POSIX system, such as"):
        get_planner("st-rrt-star")


def test_nothing_asks_for_what_is_not_everywhere_while_it_is_imported():
    names = [f"{module.__name__}.{name}" for module, name in NOT_EVERYWHERE]
    code = (
        "import os, signal, sys\nsys.modules['resource'] = None\n"
        + "".join(f"del {name}\n" for name in names)
        + "import gcm_learn.cli.arguments, gcm_learn.dataset, gcm_learn.evaluation.asking\n"
        + "from gcm_learn.cli import demo\nfrom gcm_learn.evaluation import turns, entrants\n"
        + "from gcm_learn.dataset import generation, verifying, item\n"
        + "sys.exit(gcm_learn.cli.main(['draw', '--list']))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0 and done.stderr == "", done.stderr


def test_a_process_has_one_thread_and_no_interrupts(monkeypatch):
    monkeypatch.setenv("OMP_NUM_THREADS", "7")
    with processes.pool(1) as executor:
        assert executor.submit(os.getenv, "OMP_NUM_THREADS").result() == "1"
        assert executor.submit(signal.getsignal, signal.SIGINT).result() == signal.SIG_IGN
        if hasattr(signal, "pthread_sigmask"):
            blocked = executor.submit(signal.pthread_sigmask, signal.SIG_BLOCK, ()).result()
            assert signal.SIGINT in blocked
    assert os.environ["OMP_NUM_THREADS"] == "7"


def test_leaving_a_pool_by_an_error_ends_its_processes():
    with pytest.raises(KeyboardInterrupt), processes.pool(1) as executor:
        busy = executor.submit(os.getpid).result()
        executor.submit(time.sleep, 600.0)
        raise KeyboardInterrupt
    wait_until(partial(is_gone, busy))


def wait_until(over) -> None:
    deadline = time.monotonic() + 20.0
    while not over() and time.monotonic() < deadline:
        time.sleep(0.02)
    assert over()


def is_gone(process: int) -> bool:
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return True
    return False


@pytest.fixture
def heard():
    """The interrupts that come to this process."""
    came = []
    before = signal.signal(signal.SIGINT, lambda number, frame: came.append(number))
    yield came
    signal.signal(signal.SIGINT, before)


def test_an_interrupt_waits_until_it_may_come(heard):
    with processes.interrupts_held():
        os.kill(os.getpid(), signal.SIGINT)
        time.sleep(0.01)
        assert heard == []
    assert heard == [signal.SIGINT]


def test_of_many_processes_that_compile_one_says_so(monkeypatch, capfd):
    monkeypatch.setattr(compiled, "on_compile", [say])
    with processes.pool(2) as executor:
        list(executor.map(compile_something, [0.2] * 4))
    assert capfd.readouterr().err == "compiling\n"
    assert compiled.on_compile == []  # and this one need not say it again
