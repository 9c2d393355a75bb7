"""Seeds of fresh situations: the hash of the commit that froze code and generator."""

from __future__ import annotations

import json
from pathlib import Path


def frozen_seed(file: Path, world: str) -> int:
    """Return the seed of a world's fresh situations.

    Parameters
    ----------
    file : Path
        A ``frozen.json`` with `commit` and `seed`. Worlds that were added later have their own
        below `later`, by name.
    world : str
    """
    frozen = json.loads(file.read_text("utf-8"))
    return int(frozen.get("later", {}).get(world, frozen)["seed"])
