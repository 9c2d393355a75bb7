"""Movements for robots and tables: CSV, and ROS 2 ``trajectory_msgs/JointTrajectory``."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Sequence
from typing import Any

import numpy as np

from gcm_learn.arms import CHAIN, PLANAR, ByKind
from gcm_learn.errors import FieldError
from gcm_learn.motion.movement import Movement
from gcm_learn.motion.smoothing import ends_at_rest

NANO = 1_000_000_000
NEAREST = 0.01
"""Share of their distance by which even samples are at least before the last instant."""
JUMP = 1e-3
"""Share of the limits of acceleration that is no jump."""
ADVICE = """\
# A stamp of 0 means: start when received. To meet what moves, write the time of the plan's t = 0.
"""
_NAMES = ByKind(
    {
        PLANAR: lambda arm: ["shoulder", "elbow"],
        CHAIN: lambda arm: [
            joint.name or f"joint_{k + 1}"
            for k, joint in enumerate(arm.model.joints)
            if joint.follows is None
        ],
    },
    default=lambda arm: [f"joint_{k + 1}" for k in range(len(arm.joints))],
)


def joint_names(arm: Any) -> list[str]:
    """Return the names of an arm's joints, from its model or as ``joint_1`` and so on.

    Joints that follow others are not among them: a trajectory has a column for each coordinate.
    """
    names: list[str] = _NAMES.of(arm)(arm)
    return names


def to_csv(
    movement: Movement, names: Sequence[str] | None = None, *, rate: float | None = None
) -> str:
    """Return a movement as CSV: a row a sample, the first row names the columns.

    Columns are `time` [s], the joints [rad or lengths], their `_velocity` and `_acceleration` where
    the movement has rates, and `hand_x`, `hand_y` and `hand_z`.

    Parameters
    ----------
    movement : Movement
    names : sequence of str, optional
        Names of the joints.
    rate : float, optional
        Even samples a second [Hz]; by default the rows are the movement's own samples.
    """
    joints = _names_for(movement, names)
    hand = [f"hand_{axis}" for axis in "xyz"[: movement.hand.shape[1]]]
    made, forces = _sampled(movement, _times(movement, rate))
    parts, headings = [made.time[:, None], made.joints], ["time", *joints]
    for values, word in ((made.rates, "velocity"), (forces, "acceleration")):
        if values is not None:
            parts.append(values)
            headings += [f"{name}_{word}" for name in joints]
    out = io.StringIO()
    table = csv.writer(out, lineterminator="\n")
    table.writerow([*headings, *hand])
    table.writerows(np.hstack([*parts, made.hand]).tolist())
    return out.getvalue()


def to_joint_trajectory(
    movement: Movement, names: Sequence[str] | None = None, *, rate: float | None = None
) -> dict[str, Any]:
    """Return a movement as the fields of a ROS 2 ``trajectory_msgs/JointTrajectory``.

    A ``JointTrajectoryController`` draws straight lines through positions, cubic curves where there
    are velocities, quintic ones where there are accelerations, too. So accelerations that jump are
    left out of a movement's own samples; the cubic curves are the verified ones.

    Parameters
    ----------
    movement : Movement
    names : sequence of str, optional
        Names of the joints, as the controller knows them.
    rate : float, optional
        Even samples a second [Hz]; by default the points are the movement's own samples.

    Returns
    -------
    dict
        `header`, `joint_names` and `points`; times are increasing whole nanoseconds.
    """
    exact = _times(movement, rate)
    nanoseconds = np.rint(exact * NANO).astype(np.int64)
    kept = np.append(np.diff(nanoseconds) > 0, True)  # a planar path may name an instant twice
    made, forces = _sampled(movement, exact, nanoseconds / NANO)
    if rate is None and _jumps(movement):
        forces = None
    points = [
        {
            "positions": made.joints[k].tolist(),
            "velocities": [] if made.rates is None else made.rates[k].tolist(),
            "accelerations": [] if forces is None else forces[k].tolist(),
            "effort": [],
            "time_from_start": dict(zip(("sec", "nanosec"), divmod(time, NANO), strict=True)),
        }
        for k, time in enumerate(nanoseconds.tolist())
        if kept[k]
    ]
    return {
        "header": {"stamp": {"sec": 0, "nanosec": 0}, "frame_id": ""},
        "joint_names": _names_for(movement, names),
        "points": points,
    }


def _times(moves: Movement, rate: float | None) -> np.ndarray:
    """Return a movement's sample times (n,), or even times at `rate` with the last instant [s]."""
    if rate is None:
        return moves.time
    even = np.arange(int(moves.duration * rate) + 1) / rate
    return np.append(even[even < moves.duration - NEAREST / rate], moves.duration)


def _sampled(
    moves: Movement, exact: np.ndarray, written: np.ndarray | None = None
) -> tuple[Movement, np.ndarray | None]:
    """Resample a movement at times `exact`; return it with its accelerations (n, dof) there.

    Accelerations are those of the piece that begins at a sample. The last ones are those of the
    last piece. A movement without rates has None. Rates at the end are 0 if the arm rests.

    Parameters
    ----------
    moves : Movement
    exact : (n,) ndarray
        Times [s].
    written : (n,) ndarray, optional
        The same, rounded: joints and rates are theirs [s].
    """
    if moves.rates is None:
        if exact is moves.time:
            return moves, None
        if moves.path is not None:
            return Movement.of_hand(moves.arm, exact, moves.hand_at(exact)), None
        return Movement(moves.arm, exact, moves.joints_at(exact)), None
    if moves.time.size == 1:
        return moves, np.zeros_like(moves.joints)
    time = exact if written is None else written
    curve = _curve(moves)
    joints, rates = curve(time), curve(time, 1)
    joints[-1], rates[-1] = moves.joints[-1], 0.0 if ends_at_rest(moves) else moves.rates[-1]
    return Movement(moves.arm, exact, joints, rates), curve(exact, 2)


def _jumps(moves: Movement) -> bool:
    """Return whether the accelerations of a movement jump at a sample."""
    if moves.rates is None or moves.time.size < 3:
        return False
    cubic, square = _curve(moves).c[:2]
    first, last = 2.0 * square, 2.0 * square + 6.0 * cubic * np.diff(moves.time)[:, None]
    least = JUMP * np.array(moves.arm.max_joint_acceleration)
    return bool((np.abs(first[1:] - last[:-1]) > least).any())


def _curve(moves: Movement) -> Any:
    """Return the cubic curves of a movement with rates."""
    from scipy.interpolate import CubicHermiteSpline

    return CubicHermiteSpline(moves.time, moves.joints, moves.rates)


def to_yaml(message: dict[str, Any]) -> str:
    """Return a message as YAML for ``ros2 topic pub``; a comment explains the start time."""
    lines = [f"header: {_flow(message['header'])}", f"joint_names: {_flow(message['joint_names'])}"]
    lines.append("points:")
    for point in message["points"]:
        for k, (field, value) in enumerate(point.items()):
            lines.append(f"{'  ' if k else '- '}{field}: {_flow(value)}")
    return ADVICE + "\n".join(lines) + "\n"


def _flow(value: Any) -> str:
    """Return a value in YAML's flow style; JSON is nearly that, but YAML wants ``1.0e-09``."""
    if isinstance(value, dict):
        return "{" + ", ".join(f"{key}: {_flow(part)}" for key, part in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(_flow, value)) + "]"
    if isinstance(value, float):
        text = repr(value)
        mantissa, mark, exponent = text.partition("e")
        return f"{mantissa if '.' in mantissa else mantissa + '.0'}e{exponent}" if mark else text
    return json.dumps(value)


def _names_for(movement: Movement, names: Sequence[str] | None) -> list[str]:
    """Return names of all joints, each of which is there once."""
    made = joint_names(movement.arm) if names is None else list(names)
    count = movement.joints.shape[1]
    if len(made) != count or len(set(made)) != count:
        raise FieldError("names", f"must be {count} different names (got {', '.join(made)})")
    return made
