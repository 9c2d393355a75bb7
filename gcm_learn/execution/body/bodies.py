"""Bodies of arms, from files or from the package; situations of arms with bodies."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from gcm_learn import artifacts
from gcm_learn.arms import Kind
from gcm_learn.errors import BodyError, PhysicsError, RobotError, SituationError
from gcm_learn.execution.arena.pool import Pool, of_one_kind
from gcm_learn.execution.body.kinds import MECHANICS, misfit
from gcm_learn.execution.body.motors import with_motor_limits
from gcm_learn.situation import (
    AnyArmBody,
    ArmBody,
    ChainBody,
    FrameMass,
    Motor,
    Situation,
    read_arm_body,
)

if TYPE_CHECKING:
    from gcm_learn.arms import Fitted, Inertial

FOLDER = "bodies"
GRAVITY = (0.0, 0.0, -9.81)
"""Of bodies that are made from robots' files [m/s^2]."""
Made = TypeVar("Made")


def shipped_bodies() -> dict[str, Path]:
    """Files of the bodies that come with the package, by name."""
    folder = artifacts.shipped("models") / FOLDER
    return {path.stem: path for path in sorted(folder.glob("*.json"))}


def read_body(name: str | Path) -> AnyArmBody:
    """Read a body from a file, or by the name of a body that comes with the package.

    Raises
    ------
    FileFormatError
    """
    return read_arm_body(shipped_bodies().get(str(name), Path(name)))


@cache
def _kept(path: Path) -> AnyArmBody:
    """Return a body that comes with the package, read once."""
    return read_arm_body(path)


def body_for(arm: Any, given: AnyArmBody | str | Path | None = None) -> AnyArmBody:
    """Return the body of an arm.

    Parameters
    ----------
    arm : SpatialArm or Chain
    given : ArmBody, ChainBody, str or Path, optional
        A body, its file, or the name of one that comes with the package; by default the one of
        these that fits. A chain gets the body of the shipped arm with the same joints.

    Raises
    ------
    BodyError
        If none fits.
    """
    if given is None:
        mechanics = MECHANICS.of(arm)
        bodies = [_kept(path) for path in shipped_bodies().values()]
        bodies = [body for body in bodies if body.format == mechanics.format]
        reasons = {b.name: misfit(arm, b) or mechanics.stranger(arm, b.name) for b in bodies}
        for body in bodies:
            if not reasons[body.name]:
                return body
        why = "; ".join(f"{name}: {reason}" for name, reason in reasons.items())
        raise BodyError(f"body: none that is shipped fits the arm ({why})")
    body = given if isinstance(given, ArmBody | ChainBody) else read_body(given)
    reason = misfit(arm, body)
    if reason:
        raise BodyError(f"body {body.name or given!s}: does not fit: {reason}")
    return body


def body_of_robot(fitted: Fitted) -> ChainBody:
    """Return the body of a chain that was made from a robot's file, in metres.

    Raises
    ------
    RobotError
        One line that names a joint without a torque, or a field that makes no sense.
    """
    motors = []
    for k, (joint, drive) in enumerate(zip(fitted.model.joints, fitted.drives, strict=True)):
        if drive.torque is None:
            raise RobotError(f"joint {joint.name!r}: has no largest torque; give --torque")
        motors.append(_checked(Motor, f"joints[{k}]", *drive))
    frames = [_frame_mass(k, carried) for k, carried in enumerate(fitted.masses)]
    return _checked(ChainBody, "", 1.0, GRAVITY, tuple(frames), tuple(motors), fitted.model.name)


def _frame_mass(k: int, carried: Inertial) -> FrameMass:
    inertia = 0.5 * (carried.inertia + carried.inertia.T)
    numbers = carried.mass, carried.centre.tolist(), inertia.tolist()
    return _checked(FrameMass, f"frames[{k}]", *numbers)


def _checked(record: type[Made], path: str, *values: Any) -> Made:
    """Make a record; turn an error in a field into a RobotError with the field's full path."""
    try:
        return record(*values)
    except SituationError as error:
        field = f"{path}.{error.field}" if path else error.field
        raise RobotError(f"{field}: {error.reason}") from None


def pool_with_bodies(
    situations: Sequence[Situation[Any]], kind: Kind, body: AnyArmBody | str | Path | None = None
) -> Pool:
    """Pack situations of arms with mass.

    Arms without limits of acceleration get the limits of their motors.

    Parameters
    ----------
    situations : sequence of Situation
        Each must begin with a limb that touches nothing.
    kind : Kind
        Of all arms.
    body : ArmBody, ChainBody, str or Path, optional
        As `body_for` has it.

    Raises
    ------
    ArenaError, PhysicsError
        With the name of the first that does not, or whose arm has no body.
    """
    of_one_kind(situations, kind)
    bodies = tuple(_body_of(situation, body) for situation in situations)
    limited = [with_motor_limits(s, b) for s, b in zip(situations, bodies, strict=True)]
    return replace(Pool.of(limited, kind), bodies=bodies)


def _body_of(situation: Situation[Any], given: AnyArmBody | str | Path | None) -> AnyArmBody:
    try:
        return body_for(situation.arm, given)
    except PhysicsError as error:
        raise PhysicsError(f"situation {situation.name!r}: {error}") from None
