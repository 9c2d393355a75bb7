"""Says why the first command of a new installation takes so long."""

from __future__ import annotations

import sys

LINE = "compiling for this machine; later runs start at once"


def say_compiling() -> None:
    """Say it, on a terminal; a line of progress there is written anew."""
    if sys.stderr is not None and sys.stderr.isatty():
        print(f"\r\x1b[K{LINE}", file=sys.stderr, flush=True)
