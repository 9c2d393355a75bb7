"""The table of kinds of arms: all that differs between them, beyond their own files."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Set
from typing import Any, Protocol

from gcm_learn.referee.catching import Catch
from gcm_learn.referee.contact import Motion, Watched
from gcm_learn.referee.joint_arms import Models, asked, read_chain, read_spatial
from gcm_learn.referee.motions import Body
from gcm_learn.referee.planar_arm import read_planar
from gcm_learn.referee.rotations import Array
from gcm_learn.referee.situations import check_situation
from gcm_learn.referee.tolerances import Complaint, Tolerances, Unreadable

Columns = Mapping[str, Array]
FORMAT = "gcm-learn/situation@"


class Arm(Protocol):
    """Interface of an arm in its situation."""

    @property
    def granted(self) -> Tolerances:
        """Tolerances of the version of the format."""
        ...

    @property
    def columns(self) -> Mapping[str, int]:
        """Width of each column of a trajectory, besides `time`."""
        ...

    @property
    def grasp(self) -> float:
        """Distance at which the hand catches."""
        ...

    @property
    def size(self) -> float:
        """Length with which errors of distances are compared."""
        ...

    @property
    def ignored(self) -> Set[tuple[int, str]]:
        """Links and obstacles that are not checked."""
        ...

    def readings(self, columns: Columns) -> list[Motion]:
        """Return the movement; several if the contract can be read in several ways."""
        ...

    def resting(self) -> Motion:
        """Return the arm at t = 0."""
        ...

    def complaints(self, columns: Columns) -> list[Complaint]:
        """Return complaints about the movement itself."""
        ...

    def carried(self, columns: Columns, body: Body, catch: Catch) -> list[Watched]:
        """Return the movement of a carried target, in parts with the obstacles ignored in each."""
        ...

    def missed(self, columns: Columns, body: Body, catch: Catch) -> list[Complaint]:
        """Return complaints about a catch of a body, its hold and its placing."""
        ...


KINDS: dict[tuple[int, str], Callable[[Mapping[str, Any], Models], Arm]] = {
    (1, "planar"): lambda situation, models: read_planar(situation),
    (2, "spatial"): lambda situation, models: read_spatial(2, situation["arm"]),
    (3, "spatial"): lambda situation, models: read_spatial(3, situation["arm"]),
    (3, "chain"): lambda situation, models: read_chain(situation["arm"], models),
    (4, "spatial"): lambda situation, models: asked(situation, read_spatial(4, situation["arm"])),
    (4, "chain"): lambda situation, models: asked(
        situation, read_chain(situation["arm"], models, 4)
    ),
}
"""Readers by version of the format and kind of arm."""


def version_of(situation: Mapping[str, Any]) -> int:
    """Return the version of a situation's format."""
    if not isinstance(situation, Mapping):
        raise Unreadable("situation: is not an object")
    known = {f"{FORMAT}{version}": version for version, _ in KINDS}
    given = str(situation.get("format"))
    if given not in known:
        raise Unreadable(f'format: "{given}" is not a format of situations')
    return known[given]


def arm_of(situation: Mapping[str, Any], models: Models) -> Arm:
    """Return the arm of a situation, which is checked first."""
    version, kind = checked(situation)
    return KINDS[version, kind](situation, models)


def ended(situation: Mapping[str, Any], end: str | None) -> Mapping[str, Any]:
    """Return a situation of version 2 to 4 as one of version 4 with another `end`, if given."""
    if end is None:
        return situation
    if checked(situation)[0] < 2:
        raise Unreadable("end: planar arms have no limits of acceleration")
    return {**situation, "format": f"{FORMAT}4", "end": end}


def checked(situation: Mapping[str, Any]) -> tuple[int, str]:
    """Check a situation against its format; return its version and kind of arm."""
    version, arm = version_of(situation), situation.get("arm")
    kind = arm.get("kind", "planar") if isinstance(arm, Mapping) else "planar"
    if "arm" in situation and not (isinstance(kind, str) and (version, kind) in KINDS):
        raise Unreadable(f"arm.kind: {kind} is not a kind of arm of {FORMAT}{version}")
    check_situation(situation, version, kind)
    return version, kind
