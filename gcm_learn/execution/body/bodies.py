"""Which body an arm has: a file, or one that comes with the package."""

from __future__ import annotations

from pathlib import Path

from gcm_learn import artifacts
from gcm_learn.arms import SpatialArm
from gcm_learn.errors import BodyError
from gcm_learn.situation import ArmBody, read_arm_body

FOLDER = "bodies"


def shipped_bodies() -> dict[str, Path]:
    """Files of the bodies that come with the package, by name."""
    folder = artifacts.shipped("models") / FOLDER
    return {path.stem: path for path in sorted(folder.glob("*.json"))}


def read_body(name: str | Path) -> ArmBody:
    """A body by its file, or by the name of one that comes with the package.

    Raises
    ------
    FileFormatError
    """
    return read_arm_body(shipped_bodies().get(str(name), Path(name)))


def body_for(arm: SpatialArm, given: ArmBody | str | Path | None = None) -> ArmBody:
    """The body of an arm.

    Parameters
    ----------
    arm : SpatialArm
    given : ArmBody, str or Path, optional
        A body, its file, or the name of one that comes with the package; by default the one of
        these that fits.

    Raises
    ------
    BodyError
        If none fits.
    """
    if given is None:
        bodies = [read_arm_body(path) for path in shipped_bodies().values()]
        fitting = [body for body in bodies if not body.misfit(arm)]
        if not fitting:
            reasons = "; ".join(f"{body.name}: {body.misfit(arm)}" for body in bodies)
            raise BodyError(f"body: none that is shipped fits the arm ({reasons})")
        return fitting[0]
    body = given if isinstance(given, ArmBody) else read_body(given)
    misfit = body.misfit(arm)
    if misfit:
        raise BodyError(f"body {body.name or given!s}: does not fit: {misfit}")
    return body
