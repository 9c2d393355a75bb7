"""The bar that shows how far a long command is."""

from __future__ import annotations

import io
import re
import subprocess
import sys

import pytest

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


@pytest.fixture
def terminal(monkeypatch) -> Terminal:
    """Return a terminal of 100 columns that knows colours."""
    monkeypatch.setenv("TERM", "xterm-256color")
    monkeypatch.setenv("COLUMNS", "100")
    return Terminal()


@pytest.mark.parametrize(
    ("seconds_each", "rate", "left"),
    [(1.0, "1", "0:00:01"), (50.0, "0.02", "0:00:50"), (9000.0, "0.000111", "2:30:00")],
)
def test_a_long_job_shows_count_rate_and_time_left(terminal, seconds_each, rate, left):
    bars = re.sub(r"\x1b\[[0-9;?]*[a-zA-Z]", "", run(terminal, seconds_each))
    first, *_, last = [bar for bar in re.split(r"[\r\n]+", bars) if bar.strip()]
    assert re.fullmatch(rf" 9/10 situations ━+[╸╺]?━* +{rate}/s +{left} left *", last)
    assert first.startswith(f" {2 if seconds_each < 2 else 1}/10")
    assert terminal.getvalue().count("\n") <= 1  # one line, which is wiped
    assert terminal.getvalue().endswith("\x1b[2K")


def test_nothing_is_said_of_short_jobs_and_to_files_or_quiet_terminals(terminal, monkeypatch):
    monkeypatch.setenv("FORCE_COLOR", "1")
    assert run(io.StringIO(), 1.0) == ""
    assert run(terminal, 0.1) == ""
    assert run(terminal, 1.0, quiet=True) == ""


def test_rich_is_imported_with_the_first_bar():
    code = (
        "import sys; from gcm_learn.cli.progress import Progress\n"
        "with Progress(2, 'situations') as p: p.advance()\n"
        "sys.exit('rich.progress' in sys.modules)"
    )
    subprocess.run([sys.executable, "-c", code], check=True)
