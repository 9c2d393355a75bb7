"""``gcm-learn evaluate``: planners and policies on the same situations."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from tyro.conf import arg

from gcm_learn.cli.failures import CommandFailure
from gcm_learn.cli.files import made_folder, staged
from gcm_learn.cli.options import AllCores, Cluster
from gcm_learn.cli.progress import Progress
from gcm_learn.errors import MissingExtraError

if TYPE_CHECKING:
    from gcm_learn.evaluation import Entry, Results


@dataclass(frozen=True)
class Evaluate:
    """Let planners and policies answer the same situations; write a table and a report."""

    policies: Annotated[str, arg(metavar="A,B,C", aliases=["--planners"])]
    """planners by name, trained actors by their folder in models/, NAME@20 for an actor whose
    path is tried out and verified first, and your own: module:name, path.py:name, model.zip"""

    suite: Annotated[str, arg(metavar="NAME")] = "demo"
    """frozen situations: demo, natural, L, W, Q, U (of a stratum, as families in turn yield
    them), families, faster, long-arm, space and space-demo (spatial arms), chains, or a family's
    name; several with commas"""

    out: Annotated[Path, arg(metavar="DIR")] = Path("comparison")
    """folder for report.html, results.parquet and figures"""

    count: Annotated[int, arg(metavar="N")] = 50
    """situations of each suite, at most 1000"""

    charge: Annotated[int, arg(metavar="N")] = 100
    """situations of each stratum for which thinking is charged"""

    limit: Annotated[float, arg(metavar="S")] = 60.0
    """seconds on the clock for each answer of your own methods; longer is an error"""

    noise: Annotated[str, arg(metavar="S,S")] = ""
    """also let the planners among them see bodies with errors of these standard deviations
    [forearms], 50 times a second, and plan anew in the closed loop"""

    reference: Annotated[
        str | None, arg(metavar="NAME", help_behavior_hint="(default: who catches most)")
    ] = None
    """whom the others are compared with"""

    suites: Annotated[
        Path | None, arg(metavar="DIR", help_behavior_hint="(default: see README)")
    ] = None
    """where drawn suites are kept"""

    workers: AllCores = None
    """processes on this machine"""

    cluster: Cluster = None
    """a Dask scheduler whose workers are used, tcp://HOST:PORT; latencies are theirs then"""

    def run(self) -> int:
        """Compare, and say where the report is."""
        if self.charge < 0:
            raise CommandFailure(f"--charge {self.charge}: must not be negative")
        if not 0.0 < self.limit <= 1e6:
            raise CommandFailure(f"--limit {self.limit:g}: must be above 0")
        names = list(dict.fromkeys(n for n in self.policies.split(",") if n))
        if not names:
            raise CommandFailure("--policies: names at least one")
        if self.reference is not None and self.reference not in names:
            raise CommandFailure(f"--reference {self.reference}: is not one of --policies")
        deviations = _deviations(self.noise)
        from gcm_learn.evaluation import check_suite, compare, draw_suite, get_method
        from gcm_learn.planners import FAULTS
        from gcm_learn.plots import write_report

        suites = list(dict.fromkeys(self.suite.split(",")))
        for suite in suites:
            check_suite(suite, self.count)
        for name in names:
            get_method(name)  # refused before anything is drawn or written
        folder = made_folder(self.out, option="--out")
        entries = []
        for suite in suites:
            try:
                with Progress(self.count, f"situations of {suite}") as progress:
                    entries += draw_suite(
                        suite,
                        self.count,
                        self.suites,
                        self.workers,
                        cluster=self.cluster,
                        progress=progress.advance,
                    )
            except ModuleNotFoundError as error:
                raise MissingExtraError("drawing a suite", str(error.name), "data") from None
        with Progress(len(names) * len(entries), "answers") as progress:
            results = compare(
                names,
                entries,
                charge=self.charge,
                limit=self.limit,
                workers=self.workers,
                cluster=self.cluster,
                progress=progress.advance,
            )
        _save(results, folder / "results.parquet")
        seen = self._under_noise(names, entries, deviations, folder) if deviations else None
        page = write_report(results, entries, folder, self.reference, seen)
        for name in names:
            mine = results.of_method(name)
            reachable = mine["stratum"] != "U"
            share = (mine["outcome"][reachable] == "caught").mean() if reachable.any() else 0.0
            faults = [(k, int((mine["outcome"] == k).sum())) for k in FAULTS]
            told = "".join(f", {count} {kind}" for kind, count in faults if count)
            print(f"{name:16} caught {share:6.1%} of {int(reachable.sum())} reachable{told}")
        print(f"Open {page.resolve().as_uri()} in a browser.")
        return 0

    def _under_noise(
        self, names: list[str], entries: list[Entry], deviations: list[float], folder: Path
    ) -> Results:
        """Compare the planners again, under inexact perception."""
        from gcm_learn.evaluation import (
            ActorMethod,
            compare_under_noise,
            get_method,
            noise_episodes,
        )

        planners = [name for name in names if not isinstance(get_method(name), ActorMethod)]
        with Progress(noise_episodes(planners, entries, deviations), "episodes") as progress:
            seen = compare_under_noise(
                planners,
                entries,
                deviations,
                limit=self.limit,
                workers=self.workers,
                cluster=self.cluster,
                progress=progress.advance,
            )
        _save(seen, folder / "noise.parquet")
        return seen


def _save(results: Results, path: Path) -> None:
    """Write a table, or print why it is missing; the report does without."""
    try:
        with staged(path) as place:
            results.save(place)
    except ModuleNotFoundError as error:
        print(f"No table: {MissingExtraError(path.name, str(error.name), 'data')}")


def _deviations(text: str) -> list[float]:
    """Numbers with commas between them."""
    try:
        found = [float(part) for part in text.split(",") if part]
    except ValueError:
        raise CommandFailure(f"--noise {text}: must be numbers with commas between") from None
    if any(not 0.0 < number <= 1.0 for number in found):
        raise CommandFailure(f"--noise {text}: must be above 0, and at most 1")
    return found
