"""Folders of models, suites and samples, and of drawn situations.

Three folders are searched for things of a kind, one after the other: an environment variable's, the
user's own, and the package's. The package's folders are `models` and `data` of the repository, or
the parts of them that a wheel carries.
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
    """Return the user's folder for a kind: the environment variable's, or the default one."""
    given = os.environ.get(VARIABLES[kind])
    return Path(given) if given else user_data(kind)


def source() -> Path:
    """Return the folder with all shipped files: the repository, or its part in a wheel."""
    return _checkout() or PACKAGE / IN_WHEEL


def shipped(kind: Kind) -> Path:
    """Return the package's own folder for things of a kind."""
    return source() / kind


def folders(kind: Kind) -> list[Path]:
    """Return the folders that are searched for things of a kind, in this order."""
    return list(dict.fromkeys([own(kind), user_data(kind), shipped(kind)]))


def find(kind: Kind, name: str) -> Path | None:
    """Find a file or folder by its path below the folders of a kind; None if it is missing."""
    places = (folder / name for folder in folders(kind))
    return next((place for place in places if place.exists()), None)


def models(file: str) -> dict[str, Path]:
    """Folders of all models that hold a file, by name and in order of names."""
    found: dict[str, Path] = {}
    for folder in reversed(folders("models")):
        found |= {path.parent.name: path.parent for path in folder.glob(f"*/{file}")}
    return dict(sorted(found.items()))


def model(name: str, file: str) -> Path | None:
    """Find the folder of the model `name` that holds `file`; None if it is missing."""
    place = find("models", f"{name}/{file}")
    return None if place is None else place.parent


def kept(kind: Kind) -> Path:
    """Return the folder to draw to: a writable checkout's if no variable is set, else `own`."""
    checkout = _checkout()
    if checkout is None or os.environ.get(VARIABLES[kind]) or not os.access(checkout, os.W_OK):
        return own(kind)
    return checkout / kind


def missing(kind: Kind, what: str, command: str = "") -> str:
    """Return the message that a thing was not found: its name, the folders searched, the remedy.

    Parameters
    ----------
    kind : {"models", "data"}
    what : str
        Name of the thing, e.g. ``"memory 'recall'"``.
    command : str
        Command that makes one.
    """
    looked = ", ".join(str(folder) for folder in folders(kind))
    made = f"make one with '{command}', or " if command else ""
    return f"no {what} in {looked}; {made}set {VARIABLES[kind]} to a folder that holds it"


def _checkout() -> Path | None:
    """Return the repository's folder if the package lies in a checkout, else None."""
    root = PACKAGE.parent
    return root if (root / "pyproject.toml").is_file() and (root / "models").is_dir() else None
