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

NANO = 1_000_000_000
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


def to_csv(movement: Movement, names: Sequence[str] | None = None) -> str:
    """Return a movement as CSV: a row a sample, the first row names the columns.

    Columns are `time` [s], the joints [rad or lengths], their `_velocity` where the movement has
    rates, and `hand_x`, `hand_y` and `hand_z`.

    Parameters
    ----------
    movement : Movement
    names : sequence of str, optional
        Names of the joints.
    """
    joints = _names_for(movement, names)
    hand = [f"hand_{axis}" for axis in "xyz"[: movement.hand.shape[1]]]
    parts = [movement.time[:, None], movement.joints]
    headings = ["time", *joints]
    if movement.rates is not None:
        parts.append(movement.rates)
        headings += [f"{name}_velocity" for name in joints]
    out = io.StringIO()
    table = csv.writer(out, lineterminator="\n")
    table.writerow([*headings, *hand])
    table.writerows(np.hstack([*parts, movement.hand]).tolist())
    return out.getvalue()


def to_joint_trajectory(movement: Movement, names: Sequence[str] | None = None) -> dict[str, Any]:
    """Return a movement as the fields of a ROS 2 ``trajectory_msgs/JointTrajectory``.

    Points with velocities are cubic curves, points without are straight lines in the joints; a
    ``JointTrajectoryController`` interpolates them so, too.

    Parameters
    ----------
    movement : Movement
    names : sequence of str, optional
        Names of the joints, as the controller knows them.

    Returns
    -------
    dict
        `header`, `joint_names` and `points`; times are increasing whole nanoseconds.
    """
    points: list[dict[str, Any]] = []
    previous = -1
    for k, time in enumerate(movement.time.tolist()):
        nanoseconds = round(time * NANO)
        if nanoseconds == previous:  # a planar path may name an instant twice
            points.pop()
        previous = nanoseconds
        rates = [] if movement.rates is None else movement.rates[k].tolist()
        points.append(
            {
                "positions": movement.joints[k].tolist(),
                "velocities": rates,
                "accelerations": [],
                "effort": [],
                "time_from_start": {"sec": nanoseconds // NANO, "nanosec": nanoseconds % NANO},
            }
        )
    return {
        "header": {"stamp": {"sec": 0, "nanosec": 0}, "frame_id": ""},
        "joint_names": _names_for(movement, names),
        "points": points,
    }


def to_yaml(message: dict[str, Any]) -> str:
    """Return the fields of a message as YAML, as ``ros2 topic pub`` and ``echo`` write them."""
    lines = [f"header: {_flow(message['header'])}", f"joint_names: {_flow(message['joint_names'])}"]
    lines.append("points:")
    for point in message["points"]:
        for k, (field, value) in enumerate(point.items()):
            lines.append(f"{'  ' if k else '- '}{field}: {_flow(value)}")
    return "\n".join(lines) + "\n"


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
