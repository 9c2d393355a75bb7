"""``gcm-learn benchmark``: a method on frozen suites, by a fixed protocol."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from tyro.conf import Positional, arg

from gcm_learn.cli.failures import CommandFailure
from gcm_learn.cli.files import refuse_same, staged
from gcm_learn.cli.progress import Progress

if TYPE_CHECKING:
    from gcm_learn.benchmark import Loaded, Standing

SHORTEST, LONGEST = 1e-3, 60.0  # of an answer; the longest by the protocol [s]


@dataclass(frozen=True)
class Benchmark:
    """Ask a method about frozen situations, one after the other; write a result file.

    After Ctrl-C the same command goes on where it stopped.
    """

    method: Annotated[Positional[str], arg(metavar="METHOD")]
    """a planner's name, an actor as clone@20, or your own: module:name, path.py:name, model.zip"""

    suite: Annotated[str, arg(metavar="NAME")] = "plane"
    """plane, plane-held-out, space, space-accelerated, space-sequences, panda-easy, panda-crowded,
    panda-crowded-accelerated, panda-sequences, or a .jsonl file of situations; several with
    commas"""

    out: Annotated[Path, arg(metavar="FILE")] = Path("result.json")
    """the result file; a name that ends in .gz packs it"""

    name: Annotated[str, arg(metavar="NAME", help_behavior_hint="(default: METHOD)")] = ""
    """name of the method in tables"""

    limit: Annotated[float, arg(metavar="S")] = 60.0
    """seconds on the clock for each answer; longer is an error"""

    def run(self) -> int:
        """Ask, write the file and print the measures."""
        if not SHORTEST <= self.limit <= LONGEST:
            told = f"must be from {SHORTEST:g} to {LONGEST:g}"
            raise CommandFailure(f"--limit {self.limit:g}: {told}")
        names = list(dict.fromkeys(name for name in self.suite.split(",") if name))
        if not names:
            raise CommandFailure("--suite: names at least one")
        if not self.out.name or self.out.is_dir():
            raise CommandFailure(f"--out {self.out}: is a folder")
        from gcm_learn import benchmark

        for name in names:
            refuse_same({"--suite": Path(name), "--out": self.out})
        suites = [benchmark.load_suite(name) for name in names]
        part = self.out.with_name(self.out.name + ".part")
        count = sum(len(suite.cases) for suite in suites)
        with staged(self.out) as place, Progress(count, "answers") as bar:
            result = benchmark.run(
                self.method, suites, name=self.name, limit=self.limit, part=part,
                progress=bar.advance,
            )  # fmt: skip
            benchmark.write_result(place, result)
        part.unlink(missing_ok=True)
        factor = result["calibration"]["factor"]
        print(f"calibration: processor times x {factor:.3f}")
        runs = benchmark.runs_by_suite([result])
        for suite in suites:
            _print(suite, benchmark.standings(suite, runs[suite.name])[0])
        print(f"Compare with others: gcm-learn leaderboard {self.out} OTHERS --out page.html")
        return 0


def _print(suite: Loaded, found: Standing) -> None:
    """Print the measures of a suite in one line."""
    from gcm_learn.benchmark import BUDGETS_MS

    share, low, high = (100.0 * value for value in found.caught)
    within = ", ".join(
        f"{100 * share:.0f} % in {budget:g} ms"
        for share, budget in zip(found.within, BUDGETS_MS, strict=True)
    )
    told = f"{suite.name}: caught {share:.1f} % ({low:.0f} to {high:.0f}); {within}"
    if math.isnan(share):
        told = f"{suite.name}: nothing can be caught"
    faults = f"broken promises: {found.broken}, errors: {found.errors}"
    print(f"{told}; {faults}; {found.answers} answers")
