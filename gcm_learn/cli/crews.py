"""Who does the work of a long command: options that several commands have."""

from __future__ import annotations

from typing import Annotated

from tyro.conf import arg

from gcm_learn.cli.failures import CommandFailure

AllCores = Annotated[int | None, arg(metavar="N", help_behavior_hint="(default: all cores)")]
Cluster = Annotated[
    str | None, arg(metavar="ADDRESS", help_behavior_hint="(default: this machine)")
]


def check_workers(workers: int | None) -> None:
    """Refuse what is no number of processes."""
    if workers is not None and workers < 1:
        raise CommandFailure(f"--workers {workers}: must be at least 1")
