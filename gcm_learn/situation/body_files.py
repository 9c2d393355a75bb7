"""Bodies of arms in files: the exchange formats ``gcm-learn/body@1`` and ``gcm-learn/body@2``."""

from __future__ import annotations

from pathlib import Path
from typing import Any, NamedTuple

from gcm_learn.checks import quote, show
from gcm_learn.errors import SituationError
from gcm_learn.situation.arm_body import ArmBody, BoneMass, Motor
from gcm_learn.situation.chain_body import ChainBody, FrameMass
from gcm_learn.situation.json_records import (
    check_names,
    made_from,
    members_of,
    object_from,
    records_from,
)
from gcm_learn.situation.json_text import read_value

AnyArmBody = ArmBody | ChainBody
"""Body of an arm of any kind that has one."""


class _Layout(NamedTuple):
    """Record of a format, and the records in its lists."""

    record: type[Any]
    parts: dict[str, type[Any]]


_LAYOUTS = {
    layout.record.format: layout
    for layout in (
        _Layout(ArmBody, {"bones": BoneMass, "joints": Motor}),
        _Layout(ChainBody, {"frames": FrameMass, "joints": Motor}),
    )
}
"""By the name of the format."""


def read_arm_body(path: str | Path) -> AnyArmBody:
    """Read a file of one body.

    Raises
    ------
    FileFormatError
        One line: ``nao.json:7: joints[2].torque: must be positive (got 0)``.
    """
    return read_value(Path(path), str(path), arm_body_from_json)


def arm_body_from_json(obj: object) -> AnyArmBody:
    """Return the body that a parsed JSON value describes.

    Raises
    ------
    SituationError
        With the path of the offending field, e.g. ``"bones[1].mass"``.
    """
    members = object_from(obj, "")
    given = members.get("format")
    layout = _LAYOUTS.get(given) if isinstance(given, str) else None
    if layout is None:
        known = " or ".join(quote(name) for name in _LAYOUTS)
        raise SituationError("format", f"must be {known} (got {show(given)})")
    check_names(members, "", layout.record, extra=("format",))
    values: dict[str, Any] = {k: v for k, v in members.items() if k != "format"}
    for field, record in layout.parts.items():
        values[field] = records_from(record, values[field], field)
    made: AnyArmBody = made_from(layout.record, values, "")
    return made


def arm_body_to_json(body: AnyArmBody) -> dict[str, Any]:
    """Return the JSON object of a body; `arm_body_from_json` gives back an equal one."""
    return {"format": body.format, **members_of(body)}
