"""Thin walls, at rest and moving, hold: the front is never found behind one (erratum 14)."""

from __future__ import annotations

import numpy as np
import pytest

from gcm_learn import seeding
from gcm_learn.wave import MarchingParams, WaveParams
from gcm_learn.wave.causal import march_in_plane as march
from gcm_learn.wave.kernels import FROZEN
from gcm_learn.wave.solver import propagate_in_plane as propagate
from tests.wave import walls
from tests.wave.scenes import state_of

PLAIN, MARCH = WaveParams(until="horizon"), MarchingParams(until="horizon")
PROMISED = (0.05, 0.25, 0.5, 1.0)  # speeds of walls [cells per tau]
CASES = [("static", 0.0), *((m, v) for m in walls.MOTIONS[1:] for v in PROMISED)]
VARIANTS = {
    "wave": WaveParams(n=40, until="horizon"),
    "nine points": WaveParams(n=40, until="horizon", laplacian=9),
    "paper's lattice": PLAIN,
    "printed start": WaveParams(n=40, until="horizon", start="printed", start_radius=3.0),
    "long step": WaveParams(n=40, until="horizon", step=0.8),
}


def cases(part):
    return [case for case in CASES if part == "upper arm" or case[0] != "passing"]


@pytest.mark.parametrize("part", walls.PARTS)
def test_a_wall_is_where_the_limb_touches(part):
    """The criterion's line in hand-space is the line that freezes."""
    scene = walls.draw(seeding.rng(51), part, "static", 0.0, 0.0, PLAIN)
    lattice = scene.setting[1]
    frozen = state_of(march(*scene.setting, MARCH)) == FROZEN
    starts = [wall.theta for wall in scene.pair]
    off = [np.abs(np.angle(np.exp(1j * (scene.direction - theta)))) for theta in starts]
    across = np.minimum(*off) * walls.breadth(lattice, scene.direction) / lattice.spacing
    # Near the rims the elbow swings fast and the margin is wide; and within the reach of the
    # bodies the forearm freezes cells of its own.
    x, y = np.meshgrid(lattice.centres, lattice.centres)
    middle = (np.hypot(x, y) > walls.PARTS[part][1] + 0.25) & (
        np.hypot(x, y) < lattice.upper_arm + 0.9
    )
    assert np.count_nonzero(frozen & middle) > 20
    assert across[frozen & middle].max() < 3.0


@pytest.mark.parametrize("part", walls.PARTS)
@pytest.mark.parametrize("variant", VARIANTS)
def test_no_wave_leaks(part, variant):
    params = VARIANTS[variant]
    met = 0
    for motion, speed in cases(part):
        for k in range(4):
            rng = seeding.rng(52, k)
            scene = walls.draw(rng, part, motion, speed, 0.0, params)
            front = propagate(*scene.setting, params)
            leaked = walls.leaked_cells(scene, front)
            assert leaked == 0, f"{motion} at {speed} cells/tau, scene {k}"
            met += np.count_nonzero(state_of(front) == FROZEN) > 5
    assert met > 30  # fronts that ran against a wall


@pytest.mark.parametrize("part", walls.PARTS)
@pytest.mark.parametrize("n", [40, 80])
def test_no_marching_leaks(part, n):
    params, met = MarchingParams(n=n, until="horizon"), 0
    for motion, speed in cases(part):
        for k in range(8):
            rng = seeding.rng(53, k)
            scene = walls.draw(rng, part, motion, speed, 0.0, WaveParams(n=n))
            front = march(*scene.setting, params)
            assert walls.leaked_cells(scene, front) == 0, f"{motion} at {speed}, scene {k}"
            met += np.count_nonzero(state_of(front) == FROZEN) > 5
    assert met > 60


@pytest.mark.parametrize("engine", ["wave", "marching"])
@pytest.mark.parametrize("motion", ["static", "head on", "sweeping", "passing"])
def test_the_criterion_sees_leaks(engine, motion):
    """Without the margin a wall without thickness stands between the cells' centres."""
    params = WaveParams(n=40, until="horizon", margin=0.0)
    for k in range(5):
        rng, speed = seeding.rng(54, k), 0.25 * (motion != "static")
        scene = walls.draw(rng, "upper arm", motion, speed, 0.0, params)
        if engine == "wave":
            front = propagate(*scene.setting, params)
        else:
            front = march(*scene.setting, MarchingParams(n=40, until="horizon", margin=0.0))
        assert walls.leaked_cells(scene, front) > 20


def test_no_leaks_beside_the_hand(monkeypatch):
    """Walls within a cell or two of the hand: there the fronts have rules of their own."""
    for beside in (0.03, 0.05, 0.1):
        monkeypatch.setattr(walls, "_angles", lambda *_, a=beside: (a, 1.0, 400.0))
        reached = []
        for k in range(60):
            scene = walls.draw(seeding.rng(57, k), "upper arm", "static", 0.0, 0.0, PLAIN)
            for front in (propagate(*scene.setting, PLAIN), march(*scene.setting, MARCH)):
                assert walls.leaked_cells(scene, front) == 0
                reached.append(np.count_nonzero(front.first > 0.0))
        assert np.mean(np.array(reached) > 200) > 0.2


def test_a_wall_that_recedes_lets_the_front_follow():
    """Walls are not walls for ever: what they leave is reached, later than if it had been free."""
    params = VARIANTS["wave"]
    scene = walls.draw(seeding.rng(55), "upper arm", "receding", 0.1, 0.0, params)
    front = propagate(*scene.setting, params)
    low, high = (wall.theta for wall in scene.pair)
    outside = np.mod(scene.direction - low, 2.0 * np.pi) > high - low
    assert np.count_nonzero(outside & (front.first > 0.0)) > 30


@pytest.mark.slow
@pytest.mark.parametrize("part", walls.PARTS)
@pytest.mark.parametrize("width", [0.0, 1.0, 2.0])
def test_no_leaks_in_many_scenes(part, width):
    for motion, speed in cases(part):
        for k in range(40):
            scene = walls.draw(seeding.rng(56, k), part, motion, speed, width, PLAIN)
            assert walls.leaked_cells(scene, propagate(*scene.setting, PLAIN)) == 0
            front = march(*scene.setting, MARCH)
            assert walls.leaked_cells(scene, front) == 0
