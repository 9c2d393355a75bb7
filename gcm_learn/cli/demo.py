"""``gcm-learn demo``: the paper's results as a web page, a memory, and a comparison."""

from __future__ import annotations

import contextlib
from collections.abc import Sequence
from dataclasses import dataclass
from multiprocessing.context import SpawnProcess
from pathlib import Path
from typing import Annotated

from tyro.conf import arg

from gcm_learn.cli.failures import CommandFailure
from gcm_learn.cli.files import made_folder


@dataclass(frozen=True)
class Demo:
    """Solve the paper's scenes and random ones; write figures, films and a page that shows them."""

    out: Annotated[Path, arg(metavar="DIR")] = Path("demo")
    """folder for the page index.html and its pictures"""

    seed: int = 0
    """root of the random situations"""

    random: int = 200
    """number of random situations"""

    compare: int = 30
    """number of situations on which planners and trained policies are compared; 0 for none"""

    memory: int = 400
    """number of memories that are shown, with what is recalled of them; 0 for none"""

    def run(self) -> int:
        """Build the page and say where it is."""
        if self.seed < 0:
            raise CommandFailure(f"--seed {self.seed}: must not be negative")
        if self.random < 0:
            raise CommandFailure(f"--random {self.random}: must not be negative")
        if not 0 <= self.compare <= 50:
            raise CommandFailure(f"--compare {self.compare}: must be from 0 to 50")
        if not 0 <= self.memory <= 2000:
            raise CommandFailure(f"--memory {self.memory}: must be from 0 to 2000")
        folder = made_folder(self.out, option="--out")
        from gcm_learn.plots import RECALLING, build_comparison, build_demo, shipped_methods
        from gcm_learn.recall import has_memory

        remembers = self.memory > 0 and has_memory()
        wanted = {"memory": remembers, "comparison": self.compare > 0}
        beside = [name for name, shown in wanted.items() if shown]
        later = shipped_methods() if self.compare > 0 else list(RECALLING) if remembers else []
        ahead = compile_ahead(later[::-1])  # planners last: they are compiled here meanwhile
        page = build_demo(folder, self.seed, self.random, _say, beside)
        if ahead is not None:
            ahead.join()
        recalled = self._recalled(folder)
        report = None
        if self.compare > 0:
            report = build_comparison(
                folder / "comparison", self.compare, _say, back="../index.html"
            )
        print(f"Open {page.resolve().as_uri()} in a browser.")
        if recalled is not None:
            print(f"What is remembered, and how it is recalled: {recalled.resolve().as_uri()}.")
        if report is not None:
            print(f"The comparison is {report.resolve().as_uri()}.")
        return 0

    def _recalled(self, folder: Path) -> Path | None:
        """The page of the shipped memory, None if it is not wanted or there is none."""
        if self.memory == 0:
            return None
        from gcm_learn.plots import write_shipped_page

        _say(f"Recalling; drawing {self.memory} memories")
        return write_shipped_page(folder / "memory", self.memory, back="../index.html")


def _say(step: str) -> None:
    print(step, flush=True)


def compile_ahead(names: Sequence[str]) -> SpawnProcess | None:
    """Start compiling what methods run; join the process before they are needed.

    Start nothing for an empty list, or on a single core.
    """
    from gcm_learn.processes import Context, cores

    if not names or cores() < 2:
        return None
    process = Context().Process(target=_compile, args=(tuple(names),), daemon=True)
    process.start()
    return process


def _compile(names: Sequence[str]) -> None:
    """Let methods answer once; what goes wrong here is said by whoever needs them."""
    from gcm_learn import compiled
    from gcm_learn.evaluation import entrants_of, warmed

    compiled.on_compile.clear()  # the first process says it
    for entrant in entrants_of(names):
        with contextlib.suppress(Exception):
            warmed(entrant)
