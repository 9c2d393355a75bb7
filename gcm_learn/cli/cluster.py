"""``gcm-learn cluster``: catches that are alike, as a page and a table."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal

from tyro.conf import Positional, arg

from gcm_learn.cli.failures import CommandFailure, dataset_package
from gcm_learn.cli.files import made_folder, refuse_missing, staged
from gcm_learn.cli.options import COUNT, All, Folder, Number, given
from gcm_learn.cli.progress import Progress

POINTS = 400  # catches that the page shows, besides the medoids


@dataclass(frozen=True)
class Cluster:
    """Put the catches of a memory or a dataset of planar arms into clusters.

    Writes a page, index.html, and a table of all catches, labels.parquet.
    """

    source: Annotated[Positional[Path], arg(metavar="DIR")]
    """folder of a memory or of a dataset"""

    out: Folder
    """folder for the page and the table"""

    by: Literal["map", "trace", "raw"] = "map"
    """embeddings of maps, embeddings of movements, or raw parameters of situations"""

    count: Annotated[int | None, COUNT, given("N", "that which separates them best")] = None
    """clusters"""

    most: All = None
    """records of a dataset that are read at most"""

    seed: Number = 0
    """of what is drawn"""

    def run(self) -> int:
        """Cluster the catches; write a page and a table with the cluster of every catch."""
        refuse_missing(self.source)
        dataset_package()  # the table needs pyarrow, too
        import pyarrow as pa
        import pyarrow.parquet as pq

        from gcm_learn.arms import PLANAR
        from gcm_learn.plots import write_memory_page
        from gcm_learn.recall import ASKED, cluster

        memory, numbers, maps = self._catches()
        if memory.kind != PLANAR:
            raise CommandFailure(f"{self.source}: pages show catches of planar arms only")
        with Progress(len(memory), "maps") as bar:
            found = cluster(memory, self.by, maps=maps, count=self.count, seed=self.seed,
                            progress=bar.advance)  # fmt: skip
        folder, medoids = made_folder(self.out, option="--out"), set(found.medoids.tolist())
        with Progress(POINTS + ASKED, "points and situations") as bar:
            page = write_memory_page(memory, folder, count=POINTS, found=found,
                                     seed=self.seed, progress=bar.advance)  # fmt: skip
        table = {
            "index": numbers, "family": memory.families, "stratum": memory.strata,
            "cluster": found.labels, "medoid": [k in medoids for k in range(len(numbers))],
        }  # fmt: skip
        with staged(folder / "labels.parquet") as place:
            pq.write_table(pa.table(table), place)
        print(f"{len(medoids)} clusters of {len(memory)} catches, silhouette "
              f"{found.silhouette:.2f}\nOpen {page.resolve().as_uri()} in a browser.")  # fmt: skip
        return 0

    def _catches(self) -> tuple[Any, list[int], list[Any] | None]:
        """Return the catches, their numbers in the source, and their maps or None."""
        from gcm_learn.recall import Memory, is_memory, remember

        if is_memory(self.source):
            memory = Memory.load(self.source)
            return memory, list(range(len(memory))), None
        records = dataset_package().open(self.source)[: self.most]
        caught = [record for record in records if record.earliest() is not None]
        if not caught:
            raise CommandFailure(f"{self.source}: no catches among {len(records)} records")
        maps = [record.map for record in caught] if self.by == "map" else [None]
        numbers = [record.index for record in caught]
        return remember(records), numbers, None if None in maps else maps
