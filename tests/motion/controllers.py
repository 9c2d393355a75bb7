"""Acceptance rules of two controllers, from their public documentation, in numpy alone."""

import csv
import io

import numpy as np
from scipy.interpolate import BPoly

LOW = np.array([-2.8973, -1.7628, -2.8973, -3.0718, -2.8973, -0.0175, -2.8973])
HIGH = np.array([2.8973, 1.7628, 2.8973, -0.0698, 2.8973, 3.7525, 2.8973])
PANDA = {
    "velocity": np.array([2.175] * 4 + [2.61] * 3),
    "acceleration": np.array([15, 7.5, 10, 12.5, 15, 20, 20]),
    "jerk": np.array([7500, 3750, 5000, 6250, 7500, 10000, 10000]),
}
"""Limits of the Panda: frankaemika.github.io/docs/control_parameters.html#limits-for-panda."""
NOW = 1000.0
"""Time on the controller's clock [s]."""
FIELDS = ("positions", "velocities", "accelerations")


def times_of(message):
    """Times of the points (n,) [s]."""
    stamps = [point["time_from_start"] for point in message["points"]]
    return np.array([stamp["sec"] + 1e-9 * stamp["nanosec"] for stamp in stamps])


def ros_fault(message, joints):
    """Return why ``joint_trajectory_controller`` refuses a message, or None.

    These are the rules of ``validate_trajectory_msg`` in github.com/ros-controls/ros2_controllers.
    Parameters have their defaults, so no last velocity but zero is allowed, and no effort; see
    control.ros.org/rolling/doc/ros2_controllers/joint_trajectory_controller/doc/parameters.html.
    """
    names, points, time = message["joint_names"], message["points"], times_of(message)
    if len(names) != len(joints) or not set(names) <= set(joints):
        return "joint names"
    if not points:
        return "no points"
    if (np.abs(points[-1]["velocities"]) > np.finfo(np.float32).eps).any():
        return "velocity of the last point"
    start = message["header"]["stamp"]["sec"]
    if start != 0 and start + time[-1] < NOW:
        return "ends in the past"
    if (np.diff(time) <= 0.0).any():
        return "times do not increase"
    for point in points:
        for field in FIELDS:
            empty = field != "positions" and not point[field]
            if not empty and len(point[field]) != len(names):
                return f"length of {field}"
        if point["effort"]:
            return "effort"
    return None


def ros_curve(message):
    """Return the controller's spline: cubic with velocities, quintic with accelerations, too.

    See "Trajectory Representation" in its documentation on control.ros.org.
    """
    given = [[point[field] for field in FIELDS if point[field]] for point in message["points"]]
    return BPoly.from_derivatives(times_of(message), given)


def franka_fault(table):
    """Return why a Panda would abort rows of a table that are sent one a millisecond, or None.

    Conditions of libfranka for joint trajectories, by differences of positions; the arm rests
    before and after. At both ends rates and accelerations are zero.
    """
    names = [name for name in table if f"{name}_velocity" in table]
    q, steps = (
        np.stack([table[name] for name in names], axis=1),
        1e-3 * np.arange(len(table["time"])),
    )
    late = table["time"] - steps
    if np.abs(late[:-1]).max() > 1e-9 or late[-1] > 1e-9:
        return "no row for each millisecond"
    for word, least in (("velocity", 1e-6), ("acceleration", 1e-4)):
        ends = np.stack([table[f"{name}_{word}"][[0, -1]] for name in names], axis=1)
        if (np.abs(ends) > least * PANDA[word]).any():
            return f"{word} at an end"
    if (q < LOW - 1e-6).any() or (q > HIGH + 1e-6).any():
        return "position"
    change = np.pad(q, ((3, 3), (0, 0)), mode="edge")
    for word, slack in (("velocity", 1e-6), ("acceleration", 1e-6), ("jerk", 1e-4)):
        change = np.diff(change, axis=0) / 1e-3
        if (np.abs(change) > PANDA[word] * (1.0 + slack)).any():
            return word
    return None


def read_table(text):
    """Return the columns of a CSV file."""
    rows = list(csv.DictReader(io.StringIO(text)))
    return {name: np.array([float(row[name]) for row in rows]) for name in rows[0]}
