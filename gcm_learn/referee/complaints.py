"""Complaints about solutions, and the error of files that cannot be judged."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from typing import Any


@dataclass(frozen=True)
class Complaint:
    """A promise of the exchange contract that a solution breaks."""

    field: str
    """Field of the solution, e.g. ``trajectory.joints``."""
    what: str
    at: float | None = None
    """Time at which the promise is broken [s]; None if no single instant is."""
    name: str = ""
    """Name of the situation."""

    def __str__(self) -> str:
        """Return the complaint as one line."""
        when = "" if self.at is None else f", at {self.at:.6g} s"
        line = f"{self.name}: {self.field}: {self.what}{when}"
        return line if line.isprintable() else json.dumps(line)[1:-1]

    def as_json(self) -> dict[str, Any]:
        """Return the complaint as an object for machines."""
        return asdict(self)


class Unreadable(ValueError):
    """A situation or a file that cannot be judged; the message is one line."""
