"""Arms as JSON objects, and models of chains in files: ``gcm-learn/arm@1`` and ``@2``."""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import dataclass
from functools import lru_cache
from importlib.resources import files
from importlib.resources.abc import Traversable
from pathlib import Path
from typing import Any

from gcm_learn import arms
from gcm_learn.checks import quote, show
from gcm_learn.errors import FileFormatError, SituationError
from gcm_learn.situation import json_records
from gcm_learn.situation.json_records import read_value
from gcm_learn.situation.laws import Format

ARM_FORMATS = ("gcm-learn/arm@1", "gcm-learn/arm@2")
NEW: dict[type, tuple[str, ...]] = {
    arms.Link: ("name",),
    arms.ChainJoint: ("parent", "follows", "max_jerk"),
}
"""Fields of records that `@2` adds; each is None in a record where it is absent."""


def read_arm(path: str | Path) -> arms.ChainModel:
    """Read the model of an arm from a file.

    Raises
    ------
    FileFormatError
        One line: ``arm.json:7: joints[2].axis: must have length 1 (got 1.1)``.
    """
    return _read(Path(path), str(path))


def _read(path: Path | Traversable, name: str) -> arms.ChainModel:
    return read_value(path, name, arm_from_json)


def arm_from_json(obj: object, path: str = "") -> arms.ChainModel:
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
    json_records.check_names(members, path, arms.ChainModel, extra=("format",), optional=("name",))
    values: dict[str, Any] = {"name": "", **members}
    del values["format"]
    inside = f"{path}." if path else ""
    for field, record in (("joints", arms.ChainJoint), ("links", arms.Link)):
        absent = NEW[record] if given == ARM_FORMATS[0] else ()
        values[field] = json_records.records_from(record, values[field], f"{inside}{field}", absent)
    values["hand"] = json_records.record_from(arms.Hand, values["hand"], f"{inside}hand")
    return json_records.made_from(arms.ChainModel, values, path)


def arm_to_json(model: arms.ChainModel) -> dict[str, Any]:
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
def shipped_arm(name: str) -> arms.ChainModel:
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


def model_from(value: object, path: str, folder: Path) -> arms.ChainModel:
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
        return _unchanged(folder / value, value, stamp_of(folder / value))
    except (FileFormatError, SituationError) as error:
        raise SituationError(path, str(error).removeprefix(": ")) from None


def stamp_of(path: Path) -> tuple[int, int]:
    """Return the time of change and size of a file, which show if the file has changed."""
    try:
        status = path.stat()
    except (OSError, ValueError):
        return (0, 0)
    return (status.st_mtime_ns, status.st_size)


@lru_cache(maxsize=32)
def _unchanged(path: Path, name: str, stamp: tuple[int, int]) -> arms.ChainModel:
    """Read a file that many situations name, once."""
    return _read(path, name)


@dataclass(frozen=True)
class Reading:
    """Format of the text being read, and the folder of its paths.

    Parameters
    ----------
    format : Format
    folder : Path
        Folder to which paths of models are relative.
    """

    format: Format
    folder: Path

    def near(self, obj: object) -> object:
        """Return an object, with its unit vectors normalised if the format allows that."""
        return json_records.normalised_units(obj) if self.format.normalises else obj


ArmReader = Callable[[type[Any], object, str, Reading], Any]


def arm_from(obj: object, path: str, reading: Reading) -> Any:
    """Return the arm of a situation."""
    kind = _kind_in(obj, path, reading.format.kinds)
    return _READ.of(kind)(kind.arm, obj, path, reading)


def arm_members(arm: Any, version: Format) -> dict[str, Any]:
    """Return the JSON object of an arm in a format of situations."""
    return _WRITE.of(arm)(arm, version.absent["arm"])


def _kind_in(obj: object, path: str, known: tuple[arms.Kind, ...]) -> arms.Kind:
    """Return the kind that an arm names; planar arms name none."""
    if known == (arms.PLANAR,):
        return arms.PLANAR
    name = json_records.kind_from(obj, path, [kind.name for kind in known])
    return next(kind for kind in known if kind.name == name)


def _planar(arm: type[arms.Arm], obj: object, path: str, reading: Reading) -> arms.Arm:
    for name in ("joints", "joint_range", "model"):
        if isinstance(obj, dict) and name in obj and "kind" not in obj:
            reason = f"is not for planar arms, which have a hand and 2 joints; {arms.OTHER_ARMS}"
            raise SituationError(f"{path}.{name}", reason)
    return json_records.record_from(arm, obj, path)


def _on_base(arm: type[Any], obj: object, path: str, reading: Reading) -> Any:
    return json_records.made_from(arm, _based(arm, obj, path, reading), path)


def _chain(arm: type[arms.Chain], obj: object, path: str, reading: Reading) -> arms.Chain:
    values = _based(arm, obj, path, reading)
    values["model"] = model_from(values["model"], f"{path}.model", reading.folder)
    return json_records.made_from(arm, values, path)


def _based(record: type, obj: object, path: str, reading: Reading) -> dict[str, Any]:
    """Return the members of an arm on a base, `kind` aside."""
    members = json_records.object_from(obj, path)
    absent = reading.format.absent["arm"]
    json_records.check_names(members, path, record, extra=("kind",), absent=absent)
    values = {name: value for name, value in members.items() if name != "kind"}
    if "base" in values:
        values["base"] = json_records.record_from(
            arms.Base, reading.near(values["base"]), f"{path}.base"
        )
    return values


def _chain_members(arm: arms.Chain, absent: Collection[str]) -> dict[str, Any]:
    return {**_members(arm, absent), "model": arm_to_json(arm.model)}


def _members(arm: Any, absent: Collection[str]) -> dict[str, Any]:
    return {"kind": arm.kind, **json_records.members_of(arm, absent)}


_READ: arms.ByKind[ArmReader] = arms.ByKind(
    {arms.PLANAR: _planar, arms.SPATIAL: _on_base, arms.CHAIN: _chain}, default=_on_base
)
_WRITE: arms.ByKind[Callable[[Any, Collection[str]], dict[str, Any]]] = arms.ByKind(
    {arms.PLANAR: json_records.members_of, arms.SPATIAL: _members, arms.CHAIN: _chain_members},
    default=_members,
)
