"""Exported movements pass models of two controllers, and broken ones do not."""

import numpy as np
import pytest
from scipy.interpolate import PPoly

from gcm_learn import solve
from gcm_learn.motion import to_csv, to_joint_trajectory
from gcm_learn.situation import situation_from_json
from tests.chains import drawn
from tests.motion.controllers import (
    HIGH,
    LOW,
    NOW,
    PANDA,
    franka_fault,
    read_table,
    ros_curve,
    ros_fault,
    times_of,
)

NAMES = [f"panda_joint{k}" for k in range(1, 8)]
WORDS = ("", "_velocity", "_acceleration")


def table(step=1):
    """Columns of the fastest movement of third order to full speed and back, by milliseconds."""
    made = {"time": 1e-3 * np.arange(0, 801, step)}
    for k, (name, speed, force, jerk) in enumerate(zip(NAMES, *PANDA.values(), strict=True)):
        rise, full = force / jerk, speed / force
        spans = [rise, full - rise, rise, 0.1, rise, full - rise, rise, 1.0]
        thirds = jerk * np.array([[1, 0, -1, 0, -1, 0, 1, 0]])
        way = PPoly(thirds, np.append(0.0, np.cumsum(spans))).antiderivative(3)
        way.c[-1] += 0.5 * (LOW[k] + HIGH[k] - way(0.8))
        made |= {f"{name}{word}": way(made["time"], order) for order, word in enumerate(WORDS)}
    return made


def message():
    """The same movement as points, 125 a second."""
    rows = table(8)
    columns = [np.stack([rows[f"{name}{word}"] for name in NAMES], axis=1) for word in WORDS]
    points = [
        {"positions": q.tolist(), "velocities": v.tolist(), "accelerations": a.tolist(),
         "effort": [], "time_from_start": {"sec": 0, "nanosec": 8_000_000 * k}}
        for k, (q, v, a) in enumerate(zip(*columns, strict=True))
    ]  # fmt: skip
    stamp = {"sec": 0, "nanosec": 0}
    return {"header": {"stamp": stamp}, "joint_names": list(NAMES), "points": points}


def test_a_movement_of_third_order_is_accepted():
    assert franka_fault(table()) is None
    assert ros_fault(message(), NAMES) is None


def _point(k, field, change):
    return lambda m: change(m["points"][k][field])


def _cell(column, k, by):
    return lambda t: t[column].__setitem__(k, t[column][k] + by)


def _rows(keep):
    return lambda t: t.update({name: keep(column) for name, column in t.items()})


BROKEN = [
    (lambda m: m["joint_names"].pop(), "joint names"),
    (lambda m: m["joint_names"].clear(), "joint names"),
    (lambda m: m["joint_names"].__setitem__(2, "elbow"), "joint names"),
    (lambda m: m["points"].clear(), "no points"),
    (_point(5, "time_from_start", lambda t: t.update(nanosec=32_000_000)), "times"),
    (_point(5, "time_from_start", lambda t: t.update(nanosec=10)), "times"),
    (_point(3, "positions", lambda q: q.pop()), "length of positions"),
    (_point(3, "positions", lambda q: q.clear()), "length of positions"),
    (_point(3, "velocities", lambda v: v.pop()), "length of velocities"),
    (_point(0, "accelerations", lambda a: a.append(0.0)), "length of accelerations"),
    (_point(1, "effort", lambda e: e.extend([0.0] * 7)), "effort"),
    (_point(-1, "velocities", lambda v: v.__setitem__(4, 1e-6)), "velocity of the last"),
    (lambda m: m["points"].__delitem__(slice(40, None)), "velocity of the last"),
    (lambda m: m["header"]["stamp"].update(sec=int(NOW) - 1), "past"),
    (lambda t: t[NAMES[0]].__imul__(1.001), "velocity"),
    (lambda t: t[NAMES[3]].__iadd__(2.0), "position"),
    (_cell(NAMES[1], 750, 5e-6), "acceleration"),
    (_cell(NAMES[1], 750, 3e-6), "jerk"),
    (_cell("time", 50, 1e-4), "millisecond"),
    (_cell(f"{NAMES[2]}_velocity", 0, 1e-3), "velocity at an end"),
    (_cell(f"{NAMES[5]}_acceleration", -1, -0.1), "acceleration at an end"),
    (_rows(lambda column: np.delete(column, 90)), "millisecond"),
    (_rows(lambda column: column[:400]), "velocity at an end"),
]
"""Changes of a good message or table, and the complaint about them."""
MESSAGES = 14


@pytest.mark.parametrize("k", range(len(BROKEN)))
def test_what_is_broken_is_refused(k):
    change, complaint = BROKEN[k]
    broken = message() if k < MESSAGES else table()
    change(broken)
    fault = ros_fault(broken, NAMES) if k < MESSAGES else franka_fault(broken)
    assert (fault is not None and fault.startswith(complaint)) or fault.endswith(complaint)


def caught(asked, hold=None, **limits):
    """Movements of a Panda that end at rest, under the maker's limits."""
    found = []
    for given in [drawn("panda", k) | {"end": "rest"} for k in asked]:
        given |= {"format": "gcm-learn/situation@4"}
        given["arm"] |= {"max_acceleration": PANDA["acceleration"].tolist()} | limits
        for body in given["bodies"]:
            if body["role"] == "target" and hold is not None:
                body["hold"] = {"seconds": hold, "relative_speed": 0.3}
        plan = solve(situation_from_json(given))
        found += [plan.trajectory] if plan.caught else []
    assert 2 * len(found) >= len(asked)
    return found


@pytest.fixture(scope="module")
def smooth():
    """Movements with limits of jerk."""
    jerk = PANDA["jerk"].tolist()
    return [*caught(range(8), max_jerk=jerk), *caught(range(8), 0.1, max_jerk=jerk)]


def test_what_ends_at_rest_runs_on_both_controllers(smooth):
    for moves in smooth:
        for rate in (None, 125.0, 1000.0):
            made = to_joint_trajectory(moves, NAMES, rate=rate)
            assert ros_fault(made, NAMES) is None
            written = [point["positions"] for point in made["points"]]
            np.testing.assert_allclose(written, moves.joints_at(times_of(made)), atol=1e-13)
        rows = read_table(to_csv(moves, NAMES, rate=1000.0))
        assert franka_fault(rows) is None
        assert rows["time"][-1] == moves.duration


@pytest.mark.parametrize(("rate", "off"), [(None, 1e-8), (125.0, 1e-4), (1000.0, 1e-6)])
def test_the_controller_draws_the_verified_curve(smooth, rate, off):
    """Under limits of jerk by quintic curves, else by cubic ones."""
    for moves in [*smooth[:3], *caught([1])]:
        made = to_joint_trajectory(moves, rate=rate)
        time = np.linspace(0.0, times_of(made)[-1], 3000)
        np.testing.assert_allclose(ros_curve(made)(time), moves.joints_at(time), atol=off)
    assert bool(made["points"][0]["accelerations"]) == (rate is not None)
