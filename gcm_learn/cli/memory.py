"""``gcm-learn memory``: memories of catches from datasets, and embeddings of catches."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from tyro.conf import Positional, arg

from gcm_learn.cli.failures import CommandFailure, dataset_package, why
from gcm_learn.cli.files import refuse_missing, require_suffix, staged
from gcm_learn.cli.options import All, Cluster, Folder, Number, Workers, given
from gcm_learn.cli.progress import Progress
from gcm_learn.errors import UnknownNameError

if TYPE_CHECKING:
    from gcm_learn.dataset import Dataset
    from gcm_learn.recall import LearnedIndex, Memory


@dataclass(frozen=True)
class Make:
    """Make a memory of the catches of a dataset, for the planners that recall."""

    dataset: Annotated[Positional[str], arg(metavar="DATASET")]
    """folder of a dataset, see gcm-learn generate"""

    out: Folder
    """folder for the memory"""

    index: Annotated[str, arg(metavar="NAME")] = "raw"
    """how memories are found again: raw, pca or random, or an encoder: a folder, or the name of one
    that ships, such as encoder-map"""

    planner: Annotated[str | None, given("NAME", "the earliest of all")] = None
    """whose catches are remembered"""

    synthetic: bool = False
    """take random movements to the targets in place of catches, as long as these: a control"""

    split: Annotated[str, arg(metavar="NAME")] = "train"
    """which records: a split's name, or all"""

    most: All = None
    """records that are read at most"""

    seed: Number = 0
    """of what is drawn"""

    workers: Workers = 1
    """processes on this machine"""

    cluster: Cluster = None
    """a Dask scheduler whose workers are used, tcp://HOST:PORT"""

    def run(self) -> int:
        """Make and save the memory; print its number of catches and its index."""
        refuse_missing(self.dataset)
        if self.synthetic and self.planner:
            raise CommandFailure("--planner: has no part in --synthetic")
        records = split_of(self.dataset, self.split)
        from gcm_learn.recall import LearnedIndex, remember

        folder = _encoder(self.index)
        index = LearnedIndex.load(folder) if folder.is_dir() else self.index
        total = len(records) if self.most is None else min(self.most, len(records))
        with Progress(total, "records") as progress:
            memory = remember(
                records, index, self.planner or "", synthetic=self.synthetic, seed=self.seed,
                most=self.most, workers=self.workers, cluster=self.cluster,
                progress=progress.advance,
            )  # fmt: skip
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


@dataclass(frozen=True)
class Embed:
    """Write the embeddings of a dataset's maps, or of the catches of a dataset or a memory.

    An encoder of maps embeds the map of every record. If the dataset holds no maps, or is a memory,
    the maps of its catches are made. The file holds `embeddings` (n, dim), the records' numbers as
    `index` (n,), and the names of `families` and `strata` (n,).
    """

    source: Annotated[Positional[Path], arg(metavar="DIR")]
    """folder of a dataset or of a memory"""

    out: Annotated[Path, arg(metavar="FILE")]
    """a .npz file"""

    encoder: Annotated[str | None, given("DIR", "the one that ships")] = None
    """folder of an encoder, see gcm-learn train encoder, or the name of one that ships, such as
    encoder-map"""

    split: Annotated[str, arg(metavar="NAME")] = "train"
    """which records of a dataset: a split's name, or all"""

    most: All = None
    """records that are read at most"""

    def run(self) -> int:
        """Embed and write."""
        require_suffix(self.out, (".npz",))
        refuse_missing(self.source)
        import numpy as np

        from gcm_learn.recall import LearnedIndex, Memory, is_memory, remember

        index = LearnedIndex.load(_encoder(self.encoder or "encoder"))
        if is_memory(self.source):
            rows = _rows(Memory.load(self.source).refiled(index))
        else:
            records = split_of(str(self.source), self.split)[: self.most]
            own = index.encoder.config.memory == "map" and records.spec.map != "none"
            rows = _own_maps(records, index) if own else _rows(remember(records, index))
        with staged(self.out) as place:
            np.savez_compressed(place, key=index.key, **rows)
        count = len(rows["embeddings"])
        print(f"{self.out}: {count} embeddings of {index.dim} numbers, key {index.key}")
        return 0


def _rows(memory: Memory) -> dict[str, Any]:
    """Return a memory's digest, and embedding, index, family and stratum of each catch."""
    return {
        "embeddings": memory.embeddings, "index": range(len(memory)),
        "families": memory.families, "strata": memory.strata, "memory": memory.digest,
    }  # fmt: skip


def _own_maps(records: Dataset, index: LearnedIndex) -> dict[str, Any]:
    """Return the embeddings of the records' maps, with index, family and stratum of each record."""
    from gcm_learn.recall import embed

    held = [record for record in records if record.map is not None]
    return {
        "embeddings": embed((made for record in held if (made := record.map)), index.encoder),
        "index": [record.index for record in held],
        "families": [record.family for record in held],
        "strata": [record.stratum for record in held],
    }


def split_of(folder: str, split: str) -> Dataset:
    """Return the records of a dataset's split, or all.

    Raises
    ------
    UnknownNameError
    """
    records = dataset_package().open(folder)
    known = [*sorted({str(name) for name in records.column("split")}), "all"]
    if split not in known:
        raise UnknownNameError.among("--split", split, known)
    return records if split == "all" else records.where(split=split)


def _encoder(name: str) -> Path:
    """Return the folder of an encoder that is given by its name or by its folder."""
    from gcm_learn import artifacts
    from gcm_learn.recall import CONFIG

    return Path(name) if Path(name).is_dir() else artifacts.model(name, CONFIG) or Path(name)
