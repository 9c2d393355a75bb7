"""``gcm-learn remember``: a memory from a dataset."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from tyro.conf import Positional, arg

from gcm_learn.cli.failures import CommandFailure, dataset_package, why
from gcm_learn.cli.progress import Cluster, Progress, check_workers
from gcm_learn.errors import UnknownNameError

if TYPE_CHECKING:
    from gcm_learn.recall import Index


@dataclass(frozen=True)
class Remember:
    """Make a memory of the catches of a dataset, for the planners that recall."""

    dataset: Annotated[Positional[str], arg(metavar="DATASET")]
    """folder of a dataset, see gcm-learn generate"""

    out: Annotated[Path, arg(metavar="DIR")]
    """folder for the memory; one that is there is replaced once the new one is complete"""

    index: Annotated[str, arg(metavar="NAME")] = "raw"
    """how memories are found again: raw, change, pca or random, or the folder of an encoder"""

    planner: Annotated[
        str | None, arg(metavar="NAME", help_behavior_hint="(default: the earliest of all)")
    ] = None
    """whose catches are remembered"""

    synthetic: bool = False
    """take random movements to the targets in place of catches, as long as these: a control"""

    split: Annotated[str | None, arg(metavar="NAME", help_behavior_hint="(default: train)")] = None
    """which records: a split's name, or all"""

    most: Annotated[int | None, arg(metavar="N", help_behavior_hint="(default: all)")] = None
    """records that are read at most"""

    seed: Annotated[int, arg(metavar="N")] = 0
    """of what is drawn"""

    workers: Annotated[int, arg(metavar="N")] = 1
    """processes on this machine"""

    cluster: Cluster = None
    """a Dask scheduler whose workers are used, tcp://HOST:PORT"""

    def run(self) -> int:
        """Make the memory and say what is in it."""
        if self.most is not None and self.most < 1:
            raise CommandFailure(f"--most {self.most}: must be at least 1")
        if self.seed < 0:
            raise CommandFailure(f"--seed {self.seed}: must not be negative")
        if self.synthetic and self.planner:
            raise CommandFailure("--planner: has no part in --synthetic")
        check_workers(self.workers)
        records = dataset_package().open(self.dataset)
        split = self.split or "train"
        known = [*sorted({str(name) for name in records.column("split")}), "all"]
        if split not in known:
            raise UnknownNameError.among("--split", split, known)
        if split != "all":
            records = records.where(split=split)
        from gcm_learn.recall import remember

        index = _index(self.index)
        total = len(records) if self.most is None else min(self.most, len(records))
        with Progress(total, "records") as progress:
            memory = remember(
                records,
                index,
                self.planner or "",
                synthetic=self.synthetic,
                seed=self.seed,
                most=self.most,
                workers=self.workers,
                cluster=self.cluster,
                progress=progress.advance,
            )
        if len(memory) == 0:
            raise CommandFailure(f"{self.dataset}: no catches among {total} records")
        try:
            memory.save(self.out)
        except OSError as error:
            raise CommandFailure(f"--out {self.out}: {why(error)}") from None
        print(
            f"{self.out}: {len(memory)} memories of {total} records, index {memory.index.name} "
            f"({memory.index.dim} numbers, key {memory.index.key})"
        )
        return 0


def _index(name: str) -> str | Index:
    """The trained index of a folder, or the name itself."""
    if not Path(name).is_dir():
        return name
    from gcm_learn.recall import LearnedIndex

    return LearnedIndex.load(Path(name))
