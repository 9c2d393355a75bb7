"""Arm files that ship with the package, by name: data, not code."""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path
from typing import Any

from gcm_learn.referee.complaints import Unreadable

SHIPPED = Path(__file__).parents[1] / "arms" / "models"


@cache
def shipped_model(name: str) -> dict[str, Any]:
    """Return the object of a shipped arm file."""
    known = {path.stem: path for path in SHIPPED.glob("*.json")}
    if name not in known:
        raise Unreadable(f'arm.model: "{name}" is not a known arm')
    return json.loads(known[name].read_text("utf-8"))
