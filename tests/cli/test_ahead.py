"""Compiling ahead in another process."""

from __future__ import annotations

from gcm_learn.cli import ahead
from gcm_learn.cli.ahead import compile_ahead


def test_another_process_does_it_and_says_nothing(capfd):
    process = compile_ahead(["straight", "nobody"])
    if process is not None:
        process.join()
        assert process.exitcode == 0
    assert capfd.readouterr() == ("", "")


def test_not_where_it_would_be_in_the_way(monkeypatch):
    assert compile_ahead([]) is None
    monkeypatch.setattr(ahead, "cores", lambda: 1)
    assert compile_ahead(["straight"]) is None
