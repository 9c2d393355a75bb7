"""``gcm-learn compare``: answers of planners and policies to the same situations, with a page."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import Annotated, Any

from tyro.conf import Positional, arg

from gcm_learn.cli.failures import CommandFailure
from gcm_learn.cli.files import made_folder
from gcm_learn.cli.options import COUNT, TIME, WHOLE, Cluster, Workers, given, seconds
from gcm_learn.cli.progress import Progress


@dataclass(frozen=True)
class Compare:
    """Let entrants answer the same situations; write a sheet of answers and its page.

    Stopped by Ctrl-C, the same command goes on.
    """

    entrants: Annotated[Positional[str], arg(metavar="A,B,C")]
    """planners, recall@DIR with a memory, trained policies by name or folder, NAME@20 for one whose
    path is tried out and verified first, and your own: mine.py:Mine, module:name, model.zip"""

    on: Annotated[str, arg(metavar="FILE|SUITE|FAMILY")]
    """situations: a .json or .jsonl file, a suite (plane, panda-easy, W), a family or preset;
    several with commas"""

    out: Annotated[Path, arg(metavar="DIR")] = Path("comparison")
    """folder for sheet.parquet and index.html"""

    count: Annotated[int | None, COUNT, given("N", "all, of draws 50")] = None
    """number of situations of each source"""

    seed: Annotated[int | None, WHOLE, given("N", "0")] = None
    """root of what is drawn from families; with it L, W, Q, U and natural are drawn
    anew, and panda-easy means the preset"""

    thinking: Annotated[str, arg(metavar="T,T")] = "0"
    """times that the world goes on before the arm moves, such as 0,20ms,own; own is the processor
    time of each answer"""

    noise: Annotated[str, arg(metavar="S,S")] = ""
    """standard deviations of perceived places [forearm lengths], such as 0.01,0.05"""

    limit: Annotated[float, TIME] = 60.0
    """time on the clock for each answer; a later one is an error"""

    reference: Annotated[str, given("NAME", "who catches most")] = ""
    """entrant with which the others are compared"""

    workers: Workers = 1
    """processes on this machine; several disturb each other's times"""

    cluster: Cluster = None
    """a Dask scheduler whose workers are used, tcp://HOST:PORT; times are theirs then"""

    def run(self) -> int:
        """Ask, and say where sheet and page are."""
        names = list(dict.fromkeys(name for name in self.entrants.split(",") if name))
        sources = list(dict.fromkeys(source for source in self.on.split(",") if source))
        if not names or not sources:
            raise CommandFailure(f"{'--on' if names else 'A,B,C'}: names at least one")
        if self.reference and self.reference not in names:
            raise CommandFailure(f"--reference {self.reference}: is not among {self.entrants}")
        under = self._conditions()
        from gcm_learn.planners import check_name

        for name in names:
            check_name(name, "entrant")
        from gcm_learn.evaluation import check_sources

        check_sources(sources)
        from gcm_learn.evaluation import Condition, ask, asked_for, cases, page, shares
        from gcm_learn.processes import crew_of

        conditions = [Condition(*one) for one in under]
        with Progress(self.count or 0, "situations") as bar:
            found = cases(
                *sources, count=self.count, seed=self.seed, workers=self.workers,
                cluster=self.cluster, progress=bar.advance,
            )  # fmt: skip
        total = asked_for(len(names), found, len(conditions))
        folder = made_folder(self.out, option="--out")
        with Progress(total, "answers") as bar, crew_of(self.workers, self.cluster) as crew:
            sheet = ask(names, found, conditions, keep=folder, crew=crew, progress=bar.advance)
        written = sheet.save(folder / "sheet.parquet")
        print(shares(sheet, ("suite", "entrant")))
        print(f"The sheet is {written}. Several in one page: gcm-learn report {written} OTHERS")
        shown = page(sheet, folder, reference=self.reference)
        print(f"Open {shown.resolve().as_uri()} in a browser.")
        return 0

    def _conditions(self) -> list[tuple[Any, float, float]]:
        """Return thinking, noise and limit of the conditions that the options name."""
        told = [part.strip() for part in self.thinking.split(",")]
        try:
            thinking: list[Any] = [part if part == "own" else seconds(part) for part in told]
        except ValueError as error:
            raise CommandFailure(f"--thinking {self.thinking}: {error}") from None
        noise = [0.0, *_deviations(self.noise)]
        return [(t, n, self.limit) for n, t in product(noise, thinking)]


def _deviations(text: str) -> list[float]:
    """Return numbers with commas between them."""
    try:
        found = [float(part) for part in text.split(",") if part]
    except ValueError:
        raise CommandFailure(f"--noise {text}: must be numbers with commas between") from None
    if any(not 0.0 < number <= 1.0 for number in found):
        raise CommandFailure(f"--noise {text}: must be above 0, and at most 1")
    return found
