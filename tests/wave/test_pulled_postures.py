"""A front over the hand's places in space: postures, times and free moves of its cells."""

from __future__ import annotations

import json

import numpy as np
import pytest

from gcm_learn.arms import hands_along
from gcm_learn.maps import CognitiveMap, build_map
from gcm_learn.scene import pack
from gcm_learn.situation import situation_from_json
from gcm_learn.wave import MarchingParams
from tests.chains import SETS, drawn
from tests.geometry import arm_of, least_at
from tests.spatial import EXAMPLES

PARAMS = MarchingParams(n=16, margin=0.0, until="horizon")
SLOW = pytest.mark.slow  # compiles a march for chains
TOUCHING = 2e-6  # of what may be taken for a touch or for free, either way


@pytest.fixture(scope="module", params=["spatial", *(pytest.param(n, marks=SLOW) for n in SETS)])
def marched(request):
    """A situation as JSON, the same read, and its map."""
    if request.param == "spatial":
        given = json.loads(EXAMPLES.read_text("utf-8").splitlines()[15])
    else:
        given = drawn(request.param, 2)
    situation = situation_from_json(given)
    return given, situation, build_map(situation, PARAMS)


def reached_of(found):
    """Cells that the front entered, and the cells from which it came, -1 for the start."""
    cells = np.flatnonzero(np.isfinite(found.arrival.filled(np.inf)).ravel())
    return cells, found.via.ravel()[cells]


def test_every_hand_is_in_its_cell(marched):
    _, situation, found = marched
    cells, _ = reached_of(found)
    assert len(cells) > 20
    hands = found.chart.in_base(hands_along(situation.arm, found.joints[cells])[0])
    away = np.abs(hands - found.chart.hands[cells])
    assert away.max() <= 0.5 * found.chart.spacing * (1.0 + 1e-6)


def test_no_step_is_faster_than_the_joints(marched):
    _, situation, found = marched
    cells, homes = reached_of(found)
    start = np.array(situation.arm.joints)
    before = np.where((homes >= 0)[:, None], found.joints[homes], start)
    arrival = found.arrival.filled(np.nan).ravel()
    since = np.where(homes >= 0, arrival[homes], 0.0)
    speed = pack(situation).limits.joint_speed
    took = np.abs(found.joints[cells] - before) / speed
    assert (took.max(axis=1) <= arrival[cells] - since + 1e-6).all()
    low, high = np.array(situation.arm.joint_range).T
    assert (found.joints[cells] >= low).all() and (found.joints[cells] <= high).all()


def test_every_step_is_free_and_ends_in_time(marched):
    given, situation, found = marched
    arm = arm_of(given["arm"])
    cells, homes = reached_of(found)
    arrival = found.arrival.filled(np.nan).ravel()
    assert arrival[cells].max() <= situation.horizon
    for cell, home in list(zip(cells, homes, strict=True))[::7]:
        q = found.joints[home] if home >= 0 else np.array(situation.arm.joints)
        since = arrival[home] if home >= 0 else 0.0
        shares = np.linspace(0.0, 1.0, 9)
        postures = q + shares[:, None] * (found.joints[cell] - q)
        times = since + shares * (arrival[cell] - since)
        assert min(least_at(given, arm, times, postures)) > -TOUCHING


@SLOW
def test_a_ball_at_rest_keeps_the_front_out():
    given = drawn("panda", 0)
    given = given | {"bodies": given["bodies"][:1]}
    situation = situation_from_json(given)
    free = build_map(situation, PARAMS)
    assert not free.effective_obstacles.any()
    # a cell half a metre from the hand or more, and no nearer to the arm at its start
    away = np.linalg.norm(free.chart.hands - free.hand, axis=1)
    arrival = free.arrival.filled(np.inf).ravel()
    cell = int(np.argmin(np.where(away > 0.5, arrival, np.inf)))
    none = [0.0, 0.0, 0.0]
    place = free.chart.in_world(free.chart.hands[cell]).tolist()
    motion = {"kind": "quadratic", "position": place, "velocity": none, "acceleration": none}
    ball = {"role": "obstacle", "name": "ball", "motion": motion}
    ball["shape"] = {"kind": "sphere", "radius": 0.15}
    assert np.isfinite(arrival[cell])
    found = build_map(situation_from_json(given | {"bodies": [*given["bodies"], ball]}), PARAMS)
    near = np.linalg.norm(found.chart.hands - found.chart.hands[cell], axis=1) <= 0.15
    assert np.ma.getmaskarray(found.arrival).ravel()[near].all()
    assert found.effective_obstacles.any()
    assert found.arrival.count() < free.arrival.count()


def test_a_map_is_kept_in_a_file(marched, tmp_path):
    _, situation, found = marched
    same = CognitiveMap.load(found.save(tmp_path / "map"))
    assert (same.chart.arm.reach, same.chart.arm.joints) == (
        situation.arm.reach,
        situation.arm.joints,
    )
    assert (same.chart.n, same.hand) == (found.chart.n, pytest.approx(found.hand))
    np.testing.assert_array_equal(same.joints, found.joints)
    np.testing.assert_array_equal(same.via, found.via)
    np.testing.assert_array_equal(same.arrival.filled(-1.0), found.arrival.filled(-1.0))
