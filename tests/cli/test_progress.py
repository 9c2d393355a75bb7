"""The line that shows how far a long command is, and kernels compiled ahead of it."""

from __future__ import annotations

import io

import pytest

from gcm_learn import processes
from gcm_learn.cli.demo import compile_ahead
from gcm_learn.cli.progress import Progress


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def run(stream: io.StringIO, seconds_each: float, *, quiet: bool = False) -> str:
    now = [0.0]
    with Progress(10, "situations", quiet=quiet, stream=stream, clock=lambda: now[0]) as progress:
        for _ in range(9):
            now[0] += seconds_each
            progress.advance()
    return stream.getvalue()


def test_a_long_job_shows_count_rate_and_time_left():
    text = run(Terminal(), 1.0)
    assert "9/10 situations, 1/s, 1 s left" in text
    assert text.startswith("\r2/10") and text.endswith("\r\x1b[K") and "\n" not in text


def test_nothing_is_said_of_short_jobs_and_to_files_or_quiet_terminals():
    assert run(Terminal(), 0.1) == ""
    assert run(io.StringIO(), 1.0) == ""
    assert run(Terminal(), 1.0, quiet=True) == ""


@pytest.mark.parametrize(
    ("seconds_each", "left"), [(50.0, "50 s"), (600.0, "10 min"), (9000.0, "2.5 h")]
)
def test_time_left_is_said_in_a_fitting_unit(seconds_each, left):
    assert f"9/10 situations, {1 / seconds_each:.3g}/s, {left} left" in run(
        Terminal(), seconds_each
    )


def test_another_process_does_it_and_says_nothing(capfd):
    process = compile_ahead(["straight", "nobody"])
    if process is not None:
        process.join()
        assert process.exitcode == 0
    assert capfd.readouterr() == ("", "")


def test_not_where_it_would_be_in_the_way(monkeypatch):
    assert compile_ahead([]) is None
    monkeypatch.setattr(processes, "cores", lambda: 1)
    assert compile_ahead(["straight"]) is None
