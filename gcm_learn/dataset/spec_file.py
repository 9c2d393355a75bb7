"""Files of specifications, TOML or JSON: read strictly, wrong ones refused in one line."""

from __future__ import annotations

import dataclasses
import json
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any, TypeVar

from gcm_learn.dataset.spec import FORMAT, DatasetSpec, FamilyShare
from gcm_learn.dataset.splits import Holdout, Split
from gcm_learn.errors import FileFormatError, SpecError

_Record = TypeVar("_Record")


def read_spec(path: str | Path) -> DatasetSpec:
    """Read a specification from a ``.toml`` or ``.json`` file.

    Raises
    ------
    FileFormatError
        One line: ``spec.toml: families[1].share: must be positive (got -1)``.
    """
    path = Path(path)
    if path.suffix.lower() not in (".toml", ".json"):
        raise FileFormatError(f"{path}: a specification ends in .toml or .json")
    try:
        text = path.read_bytes().decode("utf-8")
        toml = path.suffix.lower() == ".toml"
        return spec_from_json(tomllib.loads(text) if toml else json.loads(text))
    except OSError as error:
        raise FileFormatError(f"{path}: cannot be read ({error.strerror or error})") from None
    except UnicodeDecodeError as error:
        raise FileFormatError(f"{path}: is not UTF-8 text ({error.reason})") from None
    except SpecError as error:
        raise FileFormatError(f"{path}: {error}") from None
    except (tomllib.TOMLDecodeError, json.JSONDecodeError) as error:
        raise FileFormatError(f"{path}: {error}") from None


def spec_from_json(obj: object) -> DatasetSpec:
    """Return the specification that parsed TOML or JSON describes.

    Raises
    ------
    SpecError
        With the path of the offending field.
    """
    members = dict(_table(obj, ""))
    if members.pop("format", None) != FORMAT:
        raise SpecError("format", f"must be {FORMAT!r}")
    parts: dict[str, Any] = {}
    if "families" in members:
        parts["families"] = _records(FamilyShare, members.pop("families"), "families")
    if "holdouts" in members:
        parts["holdouts"] = _records(Holdout, members.pop("holdouts"), "holdouts")
    if "split" in members:
        parts["split"] = _record(Split, members.pop("split"), "split")
    if isinstance(members.get("planners"), list):
        members["planners"] = tuple(members["planners"])
    return _record(DatasetSpec, members, "", parts)


def _records(record: type[_Record], obj: object, path: str) -> tuple[_Record, ...]:
    if not isinstance(obj, list):
        raise SpecError(path, f"must be a list of tables (got {obj!r})")
    return tuple(_record(record, entry, f"{path}[{k}]") for k, entry in enumerate(obj))


def _record(
    record: type[_Record], obj: object, path: str, parts: Mapping[str, Any] | None = None
) -> _Record:
    """Return a record of a table's members and of parts that are records already."""
    members = {**_table(obj, path), **(parts or {})}
    fields = dataclasses.fields(record)  # type: ignore[arg-type]
    known = {f.name: f for f in fields}
    for name in members:
        if name not in known:
            raise SpecError(_join(path, name), f"is not a known field (known: {', '.join(known)})")
    for name, f in known.items():
        needed = f.default is dataclasses.MISSING and f.default_factory is dataclasses.MISSING
        if needed and name not in members:
            raise SpecError(_join(path, name), "is missing")
    try:
        return record(**members)
    except SpecError as error:
        raise SpecError(_join(path, error.field), error.reason) from None


def _table(obj: object, path: str) -> Mapping[str, Any]:
    if not isinstance(obj, Mapping):
        raise SpecError(path, f"must be a table (got {obj!r})")
    return obj


def _join(path: str, name: str) -> str:
    return f"{path}.{name}" if path and name else path or name
