"""A memory's folder: written whole or not at all, and read on demand.

A folder holds a manifest and the folder of data that it names. Saving writes new data beside the
old, then replaces the manifest by renaming, then removes the old data. A reader in between, or
after a crash, finds the one or the other.
"""

from __future__ import annotations

import json
import shutil
import uuid
import zlib
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from gcm_learn.errors import RecallError
from gcm_learn.recall.kinds import FORMATS, kind_of_format
from gcm_learn.situation import AnySituation, situation_from_json, situation_to_json
from gcm_learn.storage import to_disk, write_whole

MANIFEST = "manifest.json"
DATA = "data-"


def write_memory(
    folder: Path,
    arrays: Mapping[str, np.ndarray],
    about: Mapping[str, Any],
    extra: Callable[[Path], None] | None = None,
) -> None:
    """Write a memory.

    Parameters
    ----------
    folder : Path
        Made if there is none; a memory in it is replaced.
    arrays : mapping
        Columns by name.
    about : mapping
        What the manifest says, as JSON values: its format, and more.
    extra : callable, optional
        Writes more files into the folder of data that it is given.
    """
    folder.mkdir(parents=True, exist_ok=True)
    data = folder / f"{DATA}{uuid.uuid4().hex[:12]}"
    data.mkdir()
    try:
        for name, array in arrays.items():
            np.save(data / f"{name}.npy", array)
        if extra is not None:
            extra(data)
        sizes = {path.name: path.stat().st_size for path in sorted(data.iterdir())}
        for path in data.iterdir():
            to_disk(path)
        manifest = {**about, "data": data.name, "bytes": sizes}
        write_whole(folder / MANIFEST, json.dumps(manifest, indent=1) + "\n", durable=True)
    except BaseException:
        shutil.rmtree(data, ignore_errors=True)
        raise
    for old in folder.glob(f"{DATA}*"):
        if old != data:
            shutil.rmtree(old, ignore_errors=True)


def read_manifest(folder: Path) -> dict[str, Any]:
    """Read a memory's manifest, checked against the files that there are."""
    path = folder / MANIFEST
    try:
        manifest = json.loads(path.read_text("utf-8"))
        kind_of_format(path, manifest["format"])
        for name, size in manifest["bytes"].items():
            found = (folder / manifest["data"] / name).stat().st_size
            if found != size:
                raise RecallError(f"{path}: {name} has {found} bytes, expected {size}")
    except FileNotFoundError as error:
        missing = Path(error.filename).name
        raise RecallError(f"{folder}: no memory there ({missing} is missing)") from None
    except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
        raise RecallError(f"{path}: not a memory's manifest ({error})") from None
    return dict(manifest)


def is_memory(folder: Path) -> bool:
    """Return whether a folder has the manifest of a memory, be the memory whole or not."""
    try:
        manifest = json.loads((folder / MANIFEST).read_text("utf-8"))
    except (OSError, ValueError):
        return False
    return isinstance(manifest, dict) and manifest.get("format") in FORMATS


def read_arrays(folder: Path, manifest: Mapping[str, Any], mmap: bool) -> dict[str, np.ndarray]:
    """Columns of a memory, left on disk until they are read if `mmap`."""
    data = folder / str(manifest["data"])
    return {
        path.stem: np.asarray(np.load(path, mmap_mode="r" if mmap else None))
        for path in sorted(data.glob("*.npy"))
    }


def packed(situation: AnySituation) -> bytes:
    """A situation as compressed JSON text."""
    text = json.dumps(situation_to_json(situation), separators=(",", ":"), allow_nan=False)
    return zlib.compress(text.encode(), 6)


def unpacked(text: bytes) -> Any:
    """The situation of a compressed text."""
    return situation_from_json(json.loads(zlib.decompress(text)))
