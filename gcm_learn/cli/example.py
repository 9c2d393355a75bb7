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
        Positional[str], arg(metavar="NAME", help_behavior_hint="(default: list all)")
    ] = ""
    """one of the list, with or without its suffix"""

    out: Annotated[Path | None, arg(metavar="PATH", help_behavior_hint="(default: its name)")] = (
        None
    )
    """its copy; a file or folder that is there is left alone"""

    def run(self) -> int:
        """List or copy."""
        from gcm_learn.artifacts import source

        found = {title: sorted(source().glob(place)) for title, place in PLACES.items()}
        if not self.name:
            for title, paths in found.items():
                print(f"{title}:", *(path.name for path in paths))
            return 0
        known = {path.name: path for paths in found.values() for path in paths}
        chosen = known.get(self.name) or {p.stem: p for p in known.values()}.get(self.name)
        if chosen is None:
            raise UnknownNameError.among("example", self.name, known)
        target = self.out or Path(chosen.name)
        if target.exists():
            raise CommandFailure(f"--out {target}: is there already")
        try:
            print((shutil.copytree if chosen.is_dir() else shutil.copyfile)(chosen, target))
        except OSError as error:
            raise CommandFailure(f"--out {target}: {why(error)}") from None
        return 0
