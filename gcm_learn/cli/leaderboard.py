"""``gcm-learn leaderboard``: result files as one page."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from tyro.conf import Positional, arg

from gcm_learn.cli.failures import CommandFailure
from gcm_learn.cli.files import refuse_same, staged


@dataclass(frozen=True)
class Leaderboard:
    """Judge the answers of result files again; write one page that needs no other file."""

    files: Annotated[Positional[tuple[Path, ...]], arg(metavar="FILE")]
    """result files of gcm-learn benchmark"""

    out: Annotated[Path, arg(metavar="FILE")] = Path("leaderboard.html")
    """the page"""

    ours: bool = False
    """add the results of this package's methods on the same suites, or on all without FILE;
    a checkout has them, a wheel does not"""

    suite: Annotated[str, arg(metavar="FILE", help_behavior_hint="(default: none)")] = ""
    """files of situations that results name and the package does not ship; several with commas"""

    def run(self) -> int:
        """Judge and write."""
        if not self.files and not self.ours:
            raise CommandFailure("FILE is missing: a result file of gcm-learn benchmark")
        for file in self.files:
            refuse_same({"FILE": file, "--out": self.out})
        from gcm_learn.benchmark import load_suite, our_results, read_result
        from gcm_learn.plots import write_leaderboard

        results = [read_result(file) for file in self.files]
        marked = [str(result["method"]) for result in results] if self.ours else []
        if self.ours:
            results += our_results({run["suite"] for result in results for run in result["runs"]})
        given = [load_suite(name) for name in self.suite.split(",") if name]
        with staged(self.out) as place:
            write_leaderboard(results, place, given, marked)
        print(f"Open {self.out.resolve().as_uri()} in a browser.")
        return 0
