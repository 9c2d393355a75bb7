"""``gcm-learn cover``: stored catches with proven cells, for a family with few parameters."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from tyro.conf import Positional, arg

from gcm_learn.cli.failures import CommandFailure, why
from gcm_learn.cli.files import made_folder
from gcm_learn.cli.options import COUNT, TIME, Folder, Number, Workers, given, ranged
from gcm_learn.cli.progress import Progress

if TYPE_CHECKING:
    from gcm_learn.cover import Cover as Grown, ParametricFamily

PARTS = 1000  # of the box, in which the bar counts
SHARE = ranged(float, "SHARE", 0, 1, above=True)


@dataclass(frozen=True)
class Cover:
    """Cut the box of a family's parameters into cells, and prove one stored catch for each.

    Ctrl-C keeps what has been saved; the same command goes on from there.
    """

    family: Annotated[Positional[str], arg(metavar="FAMILY")]
    """belt (in the plane), belt-space (a spatial arm), belt-chain (a Panda), held-belt (it holds a
    box and stops); obstacles' places vary in belt-varied, belt-space-varied, held-belt-varied"""

    out: Folder
    """folder for the cover; one that is there is enlarged"""

    free: Number = 3
    """parameters that are free, in their order; the others are in the middle of their ranges"""

    share: Annotated[float, SHARE] = 0.95
    """share of the box that is to be covered"""

    time: Annotated[float | None, TIME, given("TIME", "no limit")] = None
    """for this run, such as 30min"""

    cells: Annotated[int | None, COUNT, given("N", "no limit")] = None
    """cells that are examined in all runs, in batches of 16"""

    workers: Workers = 1
    """processes on this machine"""

    check: Number = 0
    """situations of proven cells that are drawn and verified afterwards"""

    seed: Number = 0
    """of these draws"""

    def run(self) -> int:
        """Enlarge the cover; print the covered share of the box, and the reasons for the rest."""
        from gcm_learn.cover import Budget, grow, parametric_family
        from gcm_learn.processes import crew_of

        cover = self._begun(parametric_family(self.family).free(self.free))
        made_folder(self.out, option="--out")
        minutes = None if self.time is None else self.time / 60.0
        budget = Budget(self.share, minutes, self.cells)
        with crew_of(self.workers) as crew, Progress(round(PARTS * self.share), "‰") as bar:

            def note(share: float) -> None:
                bar.advance(round(PARTS * share) - bar.done)

            try:
                grow(cover, budget, crew, keep=lambda cover: cover.save(self.out), progress=note)
            except OSError as error:
                raise CommandFailure(f"--out {self.out}: {why(error)}") from None
        print(summary(self.out, cover))
        return self._checked(cover) if self.check else 0

    def _begun(self, family: ParametricFamily) -> Grown:
        """Return the cover in the folder, or an empty cover of the family."""
        from gcm_learn.cover import Cover, is_cover, load_cover

        if not is_cover(self.out):
            return Cover(family)
        cover = load_cover(self.out)
        if cover.family.digest != family.digest:
            had = f"{cover.family.name} with {len(cover.family.parameters)} free parameters"
            raise CommandFailure(f"--out {self.out}: holds a cover of {had}")
        return cover

    def _checked(self, cover: Grown) -> int:
        """Verify draws, say how many broke a promise, and return the exit code."""
        from gcm_learn.cover import broken_of

        with Progress(self.check, "draws") as bar:
            broken, drawn = broken_of(cover, self.check, self.seed, bar.advance)
        print(f"{self.out}: {broken} of {drawn} draws from proven cells break a promise")
        return 1 if broken else 0


def summary(out: Path, cover: Grown) -> str:
    """Return lines on the covered share of the box, and on the reasons for the rest."""
    lines = [
        f"{out}: {100.0 * cover.share:.1f} % of {cover.family.name} with "
        f"{len(cover.family.parameters)} free parameters, {len(cover.used)} stored catches, "
        f"{cover.examined} cells examined in {cover.seconds:.0f} s"
    ]
    for reason, share in cover.missing().items():
        lines.append(f"  not covered: {100.0 * share:.2f} %, {reason}")
    return "\n".join(lines)
