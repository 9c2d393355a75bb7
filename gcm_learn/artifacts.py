"""Where models, suites and samples are found, and where what is drawn is kept.

Things of a kind are looked for in three folders, one after the other: the one that an environment
variable names, the user's own, and what comes with the package. That is `models` and `data` of the
repository, or what a wheel carries of them.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import Literal

from gcm_learn.storage import user_data

Kind = Literal["models", "data"]
VARIABLES: dict[Kind, str] = {"models": "GCM_LEARN_MODELS", "data": "GCM_LEARN_DATA"}
"""Environment variables with a folder that is looked into first."""
PACKAGE = Path(__file__).parent
IN_WHEEL = "_shipped"  # the build puts it there, see setup.py


def own(kind: Kind) -> Path:
    """Where the user keeps things of a kind: the given folder, or the one for their data."""
    given = os.environ.get(VARIABLES[kind])
    return Path(given) if given else user_data(kind)


def shipped(kind: Kind) -> Path:
    """What comes with the package."""
    return (_checkout() or PACKAGE / IN_WHEEL) / kind


def folders(kind: Kind) -> list[Path]:
    """Where things of a kind are looked for, in this order."""
    return list(dict.fromkeys([own(kind), user_data(kind), shipped(kind)]))


def find(kind: Kind, name: str) -> Path | None:
    """A file or folder by its path below the folders of a kind, None if there is none."""
    places = (folder / name for folder in folders(kind))
    return next((place for place in places if place.exists()), None)


def models(file: str) -> dict[str, Path]:
    """Folders of all models that hold a file, by name and in order of names."""
    found: dict[str, Path] = {}
    for folder in reversed(folders("models")):
        found |= {path.parent.name: path.parent for path in folder.glob(f"*/{file}")}
    return dict(sorted(found.items()))


def model(name: str, file: str) -> Path | None:
    """The folder of a model that holds a file, None if there is none."""
    place = find("models", f"{name}/{file}")
    return None if place is None else place.parent


def kept(kind: Kind) -> Path:
    """Where what is drawn is kept: as `own`, but in a checkout if that can be written to."""
    checkout = _checkout()
    if checkout is None or os.environ.get(VARIABLES[kind]) or not os.access(checkout, os.W_OK):
        return own(kind)
    return checkout / kind


def missing(kind: Kind, what: str, command: str = "") -> str:
    """One line for what was not found: what, where, and how to get it.

    Parameters
    ----------
    kind : {"models", "data"}
    what : str
        What was looked for, e.g. ``"memory 'recall'"``.
    command : str
        What makes one.
    """
    looked = ", ".join(str(folder) for folder in folders(kind))
    made = f"make one with '{command}', or " if command else ""
    return f"no {what} in {looked}; {made}set {VARIABLES[kind]} to a folder that holds it"


def _checkout() -> Path | None:
    """The repository, if the package lies in it."""
    root = PACKAGE.parent
    return root if (root / "pyproject.toml").is_file() and (root / "models").is_dir() else None
