"""Complaints of the referee, and tolerances of all promises by version of the exchange format.

Numbers marked *contract* are given by the exchange contract.  The others allow for rounding, or for
numbers that are information and no promise.  Nothing else in this folder grants anything.
"""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from typing import Any

ROUNDING = 1e-14
"""Of differences of joints and of times, relative to their size."""
AT_LIMIT = 1e-5
"""Share of the larger of 1 and a bound by which a posture beyond it is the bound; *contract*."""
MOMENT = 1e-9
"""By which times of catches may miss samples [s], and ends relative to their size; *contract*."""
AFTERWARDS = 600.0
"""Time after the horizon at which a trajectory ends at the latest [s]; *contract*."""
SHORTEST = 1e-5
"""Length of a piece under limits of jerk [s]; *contract*."""
JERK = 1e-4
"""Of limits of jerk, and of jumps of acceleration by its limit, relative; *contract*."""
RESTING = (1e-6, 1e-4)
"""Rate and acceleration of a joint at rest, as shares of their limits; *contract*."""
NEAR = 1e-6
"""Of margins, places and relative speeds, absolute, and of relative speeds; *contract*."""
WORK = 400_000
"""Intervals that are examined for one promise of one solution; more is a complaint."""
WORK_BROKEN = 10_000
"""The same for contacts of a movement that breaks other promises anyway."""
INTERPOLATION = 1e-3
"""Distance between hands of planar arms by `hand` and by `joints` between samples [forearms]."""
SIDE = 1e-6
"""Sine of the elbow of planar arms on the wrong side."""
EDGE = 1e-12
"""Distance to a solid at which a point of the plane is on its cut."""
LEAP = 3.0
"""Change of a planar arm's joint between samples that is a jump [rad]."""


@dataclass(frozen=True)
class Tolerances:
    """Tolerances of one version; lengths marked (size) are relative to the length of the arm."""

    limit: float = 1e-6
    """Of speeds, accelerations and hand speed, relative; *contract*."""
    start: float = 1e-9
    """Of posture, hand and rates at t = 0, absolute."""
    agreement: float = 1e-6
    """Of hand and elbow with the joints, absolute; *contract* of versions 2 and 3."""
    range_relative: float = 1e-6
    """Of the ends of joint ranges; *contract*."""
    range_absolute: float = 1e-12
    """Of joint ranges; *contract* of version 3."""
    touch: float = 1e-9
    """Depth of a contact that is allowed (size)."""
    touch_absolute: float = 0.0
    """Depth of a contact that is allowed; *contract* of version 3."""
    grasp: float = 1e-9
    """Of the distance at a catch (size)."""
    grasp_absolute: float = 0.0
    """Of the distance at a catch, and of the angle of approach; *contract* of version 3."""
    blocked: float = 1e-6
    """Distance to contact at t = 0 within which either status is right; *contract* of version 3."""
    clearance: float = 1e-3
    """Of the reported clearance (size)."""
    compares_clearance: bool = True
    """False if a reported clearance is information only; *contract* of version 3."""


TOLERANCES = {
    1: Tolerances(grasp=1e-7, clearance=2.5e-4),
    2: Tolerances(clearance=5e-4),
    3: Tolerances(
        range_absolute=1e-6, touch_absolute=1e-6, grasp_absolute=1e-6, compares_clearance=False
    ),
}
TOLERANCES[4] = TOLERANCES[3]
"""By version of the exchange format."""


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
