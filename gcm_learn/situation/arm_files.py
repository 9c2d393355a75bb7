"""Models of chains in files: the formats ``gcm-learn/arm@1`` and ``@2``, and those that ship."""

from __future__ import annotations

from functools import lru_cache
from importlib.resources import files
from importlib.resources.abc import Traversable
from pathlib import Path
from typing import Any

from gcm_learn.arms import ChainJoint, ChainModel, Hand, Link
from gcm_learn.checks import quote, show
from gcm_learn.errors import FileFormatError, SituationError
from gcm_learn.situation import json_records
from gcm_learn.situation.json_text import read_value

ARM_FORMATS = ("gcm-learn/arm@1", "gcm-learn/arm@2")
NEW: dict[type, tuple[str, ...]] = {
    Link: ("name",),
    ChainJoint: ("parent", "follows", "max_jerk"),
}
"""Fields of records that `@2` adds; each is None in a record where it is absent."""


def read_arm(path: str | Path) -> ChainModel:
    """Read a file of one arm.

    Raises
    ------
    FileFormatError
        One line: ``arm.json:7: joints[2].axis: must have length 1 (got 1.1)``.
    """
    return _read(Path(path), str(path))


def _read(path: Path | Traversable, name: str) -> ChainModel:
    return read_value(path, name, arm_from_json)


def arm_from_json(obj: object, path: str = "") -> ChainModel:
    """Return the model that a parsed JSON value describes.

    Parameters
    ----------
    obj : object
    path : str
        Path of the value in the file, for messages.

    Raises
    ------
    SituationError
        With the path of the offending field, e.g. ``"joints[1].max_speed"``.
    """
    members = json_records.object_from(obj, path)
    given = members.get("format")
    if given not in ARM_FORMATS:
        field = f"{path}.format" if path else "format"
        known = " or ".join(map(quote, ARM_FORMATS))
        raise SituationError(field, f"must be {known} (got {show(given)})")
    json_records.check_names(members, path, ChainModel, extra=("format",), optional=("name",))
    values: dict[str, Any] = {"name": "", **members}
    del values["format"]
    inside = f"{path}." if path else ""
    for field, record in (("joints", ChainJoint), ("links", Link)):
        absent = NEW[record] if given == ARM_FORMATS[0] else ()
        values[field] = json_records.records_from(record, values[field], f"{inside}{field}", absent)
    values["hand"] = json_records.record_from(Hand, values["hand"], f"{inside}hand")
    return json_records.made_from(ChainModel, values, path)


def arm_to_json(model: ChainModel) -> dict[str, Any]:
    """Return the JSON object of a model, in the oldest format that holds it.

    `arm_from_json` gives back an equal model.
    """
    newer = any(
        getattr(record, name) is not None
        for record in (*model.joints, *model.links)
        for name in NEW[type(record)]
    )
    return {"format": ARM_FORMATS[newer], **json_records.members_of(model)}


def arm_names() -> tuple[str, ...]:
    """Return the names of the arms that ship with the package."""
    return tuple(sorted(p.name.removesuffix(".json") for p in _folder().iterdir()))


@lru_cache(maxsize=32)
def shipped_arm(name: str) -> ChainModel:
    """Return an arm that ships with the package.

    Raises
    ------
    SituationError
        If there is no arm of that name; lists the known ones.
    """
    if name not in arm_names():
        known = ", ".join(arm_names())
        raise SituationError("", f"{quote(name)} is not the name of an arm (known: {known})")
    return _read(_folder() / f"{name}.json", f"{name}.json")


def _folder() -> Traversable:
    return files("gcm_learn.arms") / "models"


def model_from(value: object, path: str, folder: Path) -> ChainModel:
    """Return the model that a situation gives as an object, a path or a name.

    Parameters
    ----------
    value : object
        An arm file's object, a path that ends in ``.json`` or the name of an arm that ships.
    path : str
        Path of the value in the situation, for messages.
    folder : Path
        Folder to which paths are relative.
    """
    if not isinstance(value, str):
        return arm_from_json(value, path)
    try:
        if not value.endswith(".json"):
            return shipped_arm(value)
        return _unchanged(folder / value, value, _stamp(folder / value))
    except (FileFormatError, SituationError) as error:
        raise SituationError(path, str(error).removeprefix(": ")) from None


def _stamp(path: Path) -> tuple[int, int]:
    """Return time of change and size of a file, by which a change of it is noticed."""
    try:
        status = path.stat()
    except (OSError, ValueError):
        return (0, 0)
    return (status.st_mtime_ns, status.st_size)


@lru_cache(maxsize=32)
def _unchanged(path: Path, name: str, stamp: tuple[int, int]) -> ChainModel:
    """Read a file that many situations name, once."""
    return _read(path, name)
