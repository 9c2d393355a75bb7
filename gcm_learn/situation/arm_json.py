"""Arms of situations to JSON values and back: one entry for each kind."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from gcm_learn.arms import CHAIN, OTHER_ARMS, PLANAR, Arm, Base, ByKind, Chain, Kind
from gcm_learn.errors import SituationError
from gcm_learn.situation import json_records
from gcm_learn.situation.arm_files import arm_to_json, model_from
from gcm_learn.situation.formats import Format


@dataclass(frozen=True)
class Reading:
    """Format and place of what is read.

    Parameters
    ----------
    format : Format
    folder : Path
        Folder to which paths of models are relative.
    """

    format: Format
    folder: Path

    def near(self, obj: object) -> object:
        """Return an object with its unit vectors normalised, where the format allows for it."""
        return json_records.normalised_units(obj) if self.format.normalises else obj


ArmReader = Callable[[type[Any], object, str, Reading], Any]


def arm_from(obj: object, path: str, reading: Reading) -> Any:
    """Return the arm of a situation."""
    kind = _kind_in(obj, path, reading.format.kinds)
    return _READ.of(kind)(kind.arm, obj, path, reading)


def arm_members(arm: Any) -> dict[str, Any]:
    """Return the JSON object of an arm."""
    return _WRITE.of(arm)(arm)


def _kind_in(obj: object, path: str, known: tuple[Kind, ...]) -> Kind:
    """Return the kind that an arm names; planar arms name none."""
    if known == (PLANAR,):
        return PLANAR
    name = json_records.kind_from(obj, path, [kind.name for kind in known])
    return next(kind for kind in known if kind.name == name)


def _planar(arm: type[Arm], obj: object, path: str, reading: Reading) -> Arm:
    for name in ("joints", "joint_range", "model"):
        if isinstance(obj, dict) and name in obj and "kind" not in obj:
            reason = f"is not for planar arms, which have a hand and 2 joints; {OTHER_ARMS}"
            raise SituationError(f"{path}.{name}", reason)
    return json_records.record_from(arm, obj, path)


def _on_base(arm: type[Any], obj: object, path: str, reading: Reading) -> Any:
    return json_records.made_from(arm, _based(arm, obj, path, reading), path)


def _chain(arm: type[Chain], obj: object, path: str, reading: Reading) -> Chain:
    values = _based(arm, obj, path, reading)
    values["model"] = model_from(values["model"], f"{path}.model", reading.folder)
    return json_records.made_from(arm, values, path)


def _based(record: type, obj: object, path: str, reading: Reading) -> dict[str, Any]:
    """Return the members of an arm on a base, `kind` aside."""
    members = json_records.object_from(obj, path)
    json_records.check_names(members, path, record, extra=("kind",))
    values = {name: value for name, value in members.items() if name != "kind"}
    if "base" in values:
        values["base"] = json_records.record_from(
            Base, reading.near(values["base"]), f"{path}.base"
        )
    return values


def _chain_members(arm: Chain) -> dict[str, Any]:
    return {**_members(arm), "model": arm_to_json(arm.model)}


def _members(arm: Any) -> dict[str, Any]:
    return {"kind": arm.kind, **json_records.members_of(arm)}


_READ: ByKind[ArmReader] = ByKind({PLANAR: _planar, CHAIN: _chain}, default=_on_base)
_WRITE: ByKind[Callable[[Any], dict[str, Any]]] = ByKind(
    {PLANAR: json_records.members_of, CHAIN: _chain_members}, default=_members
)
