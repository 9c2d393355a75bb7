"""Balls of table tennis: flight, bounce, pieces, and the situations that they become."""

import gzip
import json
import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from gcm_learn.errors import FileFormatError
from gcm_learn.outside import TableTennis, ball_flight as flight
from gcm_learn.outside.table_tennis import FIELDS, facing
from tests.geometry import poses
from tests.outside.conftest import DATA

INERTIA = 2.0 / 3.0 * flight.MASS * flight.RADIUS**2


def converted(path, **settings):
    return TableTennis(**settings).convert([path])


def given_states():
    states = json.loads((DATA / "balls.json").read_text())
    return facing(np.array([[state[name] for name in FIELDS] for state in states]))


def reference(state, until, times):
    """Return places by another integrator, with bounces found as events."""
    places = np.full((len(times), 3), np.nan)

    def rate(t, y):
        v, w = y[3:6], y[6:]
        speed = math.sqrt(v @ v)
        area = math.pi * flight.RADIUS**2
        drag = -0.5 * flight.AIR * area * flight.DRAG * speed * v
        lift = 0.5 * flight.AIR * area * flight.RADIUS * flight.LIFT * np.cross(w, v)
        pull = (drag + lift) / flight.MASS - [0.0, 0.0, flight.GRAVITY]
        return np.concatenate([v, pull, np.zeros(3)])

    def lands(t, y):
        over = abs(y[0]) <= flight.TABLE[0] and abs(y[1]) <= flight.TABLE[1]
        return y[2] - flight.RADIUS if over else 1.0

    lands.terminal, lands.direction = True, -1
    begin, y = 0.0, np.array(state, float)
    while begin < until:
        done = solve_ivp(
            rate, (begin, until), y, events=lands, rtol=1e-10, atol=1e-12, dense_output=True,
            max_step=0.01,
        )  # fmt: skip
        inside = (times >= begin) & (times <= done.t[-1])
        places[inside] = done.sol(times[inside])[:3].T
        begin, y = done.t[-1], done.y[:, -1].copy()
        if done.status != 1:
            break
        y = flight.bounced(y[None])[0]
        y[2] = flight.RADIUS + 1e-12
    return places


@pytest.mark.parametrize("k", range(3))
def test_balls_fly_as_by_a_fine_integration(k):
    """The conversion stays within 5 mm everywhere, and within half of it here."""
    until, states = 1.5, given_states()
    times = np.linspace(0.0, until, 4001)
    truth = reference(states[k], until, times)
    pieces = flight.pieces_of(flight.flights(states[k : k + 1], until)[0])
    law = [
        {"start": p.start, "position": p.motion.position, "velocity": p.motion.velocity,
         "acceleration": p.motion.acceleration}
        for p in pieces
    ]  # fmt: skip
    centre, _ = poses({"motion": {"kind": "piecewise", "pieces": law}}, times)
    assert np.linalg.norm(centre - truth, axis=1).max() < 0.0025
    assert len(pieces) < 15


@pytest.mark.parametrize("seed", range(20))
def test_a_bounce_keeps_the_laws_of_mechanics(seed):
    """Impulse at the lowest point, no energy won, friction within its cone."""
    rng = np.random.default_rng(seed)
    before = np.concatenate([[0, 0, flight.RADIUS], rng.normal(0, 4, 3), rng.normal(0, 80, 3)])
    before[5] = -abs(before[5]) - 0.1
    after = flight.bounced(before[None])[0]
    change = flight.MASS * (after[3:6] - before[3:6])
    arm = np.array([0.0, 0.0, -flight.RADIUS])
    np.testing.assert_allclose(
        INERTIA * (after[6:] - before[6:]), np.cross(arm, change), atol=1e-15
    )
    assert after[5] == pytest.approx(-flight.RESTITUTION * before[5])
    assert np.hypot(*change[:2]) <= flight.FRICTION * change[2] * (1 + 1e-12)

    def energy(state):
        v, w = state[3:6], state[6:]
        return 0.5 * flight.MASS * v @ v + 0.5 * INERTIA * w @ w

    assert energy(after) < energy(before)
    slip = [row[3:6] + np.cross(row[6:], arm) for row in (before, after)]
    assert slip[0][:2] @ slip[1][:2] >= -1e-12


def test_balls_in_a_vacuum_fall_as_galilei_says(monkeypatch):
    monkeypatch.setattr(flight, "_DRAG", 0.0)
    monkeypatch.setattr(flight, "_LIFT", 0.0)
    state = np.array([[0.0, -2.0, 1.0, 0.5, -1.0, 2.0, 9.0, 9.0, 9.0]])
    (piece,) = flight.pieces_of(flight.flights(state, 0.6)[0])
    np.testing.assert_allclose(piece.motion.velocity, (0.5, -1.0, 2.0), atol=1e-9)
    np.testing.assert_allclose(piece.motion.acceleration, (0, 0, -flight.GRAVITY), atol=1e-8)


def test_topspin_dips_and_sidespin_curves():
    ball = np.array([[0.0, 1.3, 0.3, 0.0, -5.0, 1.0, 0.0, 0.0, 0.0]] * 3)
    ball[1, 6], ball[2, 8] = 100.0, 100.0  # about x: the top of a ball that flies along -y
    plain, top, side = (row[0].places[20] for row in flight.flights(ball, 0.15))
    assert top[2] < plain[2] - 0.003 and abs(side[0]) > 0.003 and plain[0] == 0.0


def test_every_ball_in_reach_becomes_a_situation(balls):
    result = converted(balls())
    assert [s.name for s in result.situations] == ["ball-7", "ball-9"]
    assert list(result.notes()) == [
        "1 of 4: the ball meets the net (left out)",
        "1 of 3: the ball stays out of reach (left out)",
        "0 of 2: the start is blocked",
    ]
    for situation in result.situations:
        assert [b.name for b in situation.bodies] == ["ball", "table"]
        assert situation.targets[0].motion.kind == "piecewise" and situation.horizon < 2.0


def test_both_ends_of_the_table_are_one(balls):
    """A ball that flies the other way is the same ball, the table turned by half a turn."""

    def turn(states):
        for state in states:
            for name in FIELDS:
                if not name.endswith("z"):
                    state[name] = -state[name]

    assert converted(balls(turn)).situations == converted(balls()).situations


def test_the_base_is_a_setting(balls):
    near = converted(balls(), base=(0.3, -1.9, -0.1)).situations[0]
    assert near.arm.base.origin == (0.3, -1.9, -0.1)
    with pytest.raises(FileFormatError, match="no ball comes within the arm's reach"):
        converted(balls(), base=(0.0, -9.0, 0.0))


def test_files_may_be_compressed(balls, tmp_path):
    packed = tmp_path / "balls.json.gz"
    packed.write_bytes(gzip.compress(balls().read_bytes()))
    assert converted(packed).situations == converted(balls()).situations


REFUSED = [
    (lambda s: s[1].pop("vel_z"), "[1].vel_z: is missing"),
    (lambda s: s[1].update(pos_x="far"), "[1].pos_x: must be a number"),
    (lambda s: s[1].update(w_vel_y=math.nan), "[1].w_vel_y: must be finite"),
    (lambda s: s[1].update(vel_x=1e30), "[1].vel_x: is too large (1e+30, max 10000)"),
    (lambda s: s[1].update(id=7), "[1].id: is given twice"),
    (lambda s: s.append(3), "[4]: must be an object (got 3)"),
]


@pytest.mark.parametrize(("change", "message"), REFUSED)
def test_what_is_not_understood_is_refused_in_one_line(change, message, balls):
    given = balls(change)
    (reason,) = map(str, converted(given).left_out)
    assert str(given) in reason and message in reason and "\n" not in reason
