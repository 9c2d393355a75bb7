"""``gcm-learn gallery``: a page that shows what is in a dataset, or in a memory."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from tyro.conf import Positional, arg

from gcm_learn.cli.failures import CommandFailure, dataset_package
from gcm_learn.cli.files import made_folder


@dataclass(frozen=True)
class Gallery:
    """Draw situations of every stratum with their maps, and a page that shows them.

    Of a memory: its catches as points, each with its map.
    """

    folder: Annotated[Positional[str], arg(metavar="DIR")]
    """a dataset, or a memory of gcm-learn remember"""

    out: Annotated[Path, arg(metavar="DIR")] = Path("gallery")
    """folder for the page index.html and its pictures"""

    each: int = 8
    """situations of every stratum; of a memory a hundred times as many catches are shown"""

    split: Annotated[str | None, arg(metavar="NAME", help_behavior_hint="(default: all)")] = None
    """only of one split"""

    def run(self) -> int:
        """Build the page and say where it is."""
        if self.each < 1:
            raise CommandFailure(f"--each {self.each}: must be at least 1")
        from gcm_learn.recall import is_memory

        if is_memory(Path(self.folder)):
            return self._show_memory()
        records = dataset_package().open(self.folder)
        if self.split is not None:
            records = records.where(split=self.split)
        if len(records) == 0:
            raise CommandFailure(f"{self.folder}: has no such records")
        folder = made_folder(self.out, option="--out")
        from gcm_learn.plots import write_dataset_page

        page = write_dataset_page(records, folder, self.each)
        print(f"Open {page.resolve().as_uri()} in a browser.")
        return 0

    def _show_memory(self) -> int:
        from gcm_learn.arms import PLANAR
        from gcm_learn.recall import Memory

        memory = Memory.load(self.folder)
        if memory.kind != PLANAR:
            raise CommandFailure(f"{self.folder}: pages show memories of planar arms only")
        folder = made_folder(self.out, option="--out")
        from gcm_learn.plots import write_memory_page

        page = write_memory_page(memory, folder, count=100 * self.each)
        print(f"Open {page.resolve().as_uri()} in a browser.")
        return 0
