"""``gcm-learn example``: small files that come with the package, to begin with."""

from __future__ import annotations

import shutil
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from tyro.conf import Positional, arg

from gcm_learn.cli.failures import CommandFailure, why
from gcm_learn.errors import UnknownNameError

PLACES = {
    "configurations of train-policy": "experiments/04_policies/*.yml",
    "specifications of generate": "data/specs/*.toml",
    "what fields and columns mean": "data/README.md",
    "a dataset of 500 planar records": "data/sample",
    "situations": "data/suites/demo.jsonl",
    "notebooks, as scripts that jupytext opens": "docs/notebooks/*.py",
}


@dataclass(frozen=True)
class Example:
    """List the example files that come with the package, or copy one of them."""

    name: Annotated[
        Positional[str | None], arg(metavar="NAME", help_behavior_hint="(default: list all)")
    ] = None
    """one of the list, with or without its suffix"""

    out: Annotated[
        Path | None, arg(metavar="PATH", help_behavior_hint="(default: its name, in this folder)")
    ] = None
    """its copy; a file or folder that is there is left alone"""

    def run(self) -> int:
        """List or copy."""
        from gcm_learn import artifacts

        root = artifacts.source()
        found = {title: sorted(root.glob(pattern)) for title, pattern in PLACES.items()}
        if self.name is None:
            for title, paths in found.items():
                print(f"{title}:", *(path.name for path in paths))
            return 0
        known = {path.name: path for paths in found.values() for path in paths}
        source = known.get(self.name) or {p.stem: p for p in known.values()}.get(self.name)
        if source is None:
            raise UnknownNameError.among("example", self.name, known)
        target = self.out or Path(source.name)
        if target.exists():
            raise CommandFailure(f"--out {target}: is there already")
        try:
            (shutil.copytree if source.is_dir() else shutil.copyfile)(source, target)
        except OSError as error:
            raise CommandFailure(f"--out {target}: {why(error)}") from None
        print(target)
        return 0
