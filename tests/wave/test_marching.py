"""Causal marching: exact in free space, close to the shortest way round walls, kin to the wave."""

from __future__ import annotations

import threading

import numpy as np
import pytest

from gcm_learn import seeding
from gcm_learn.arm.lattice import hand_space
from gcm_learn.wave import MarchingParams, WaveParams, march, propagate
from gcm_learn.wave.kernels import CONTACT, FREE, FROZEN
from tests.transforms import mirrored, turned
from tests.wave.scenes import SPEED, away, disc, scene, task_of, three_discs

EXPLORE = MarchingParams(until="horizon")
COARSE = MarchingParams(n=40, until="horizon")


def in_cells(task, front):
    """Arrival as a distance at hand speed [cells], nan where the front never came."""
    return np.where(front.arrival >= 0.0, front.arrival * SPEED / task.lattice.spacing, np.nan)


@pytest.mark.parametrize("arm", [{}, {"upper_arm": 0.4, "hand": (0.9, 0.1)}])
def test_exact_in_free_space(arm):
    """With an inner hole (rho = 0.4) exact where the hole is not in the way."""
    params = MarchingParams(n=56, until="horizon")
    for k in range(300):
        rng = seeding.rng(41, k)
        hand = tuple(float(v) for v in rng.uniform(-1.2, 1.2, size=2))
        task = task_of(scene(horizon=3.0, **({"hand": hand} | arm)), 56)
        front = march(task, params)
        inside = hand_space(task.lattice).inside.reshape(56, 56)
        assert np.array_equal(front.arrival >= 0.0, inside)
        assert (front.state == FREE).all()
        x, _ = np.meshgrid(task.lattice.centres, task.lattice.centres)
        seen = inside & ((task.lattice.upper_arm == 1.0) | (x > 0.65))
        error = np.abs(in_cells(task, front) - away(task))[seen]
        assert error.max() < 1e-9, f"start {k}"
        if arm:
            break


def test_anisotropy():
    task = task_of(scene(hand=(0.41, -0.2), horizon=3.0))
    distance = away(task)
    far = (distance > 10.0) & hand_space(task.lattice).inside.reshape(80, 80)
    speed = distance[far] / in_cells(task, march(task, EXPLORE))[far]
    assert 1.0 - speed.min() / speed.max() <= 0.01


def shortest_ways(task, blocked):
    """Lengths (n, n) [cells] of the shortest ways from the hand past blocked cells.

    Ways are polygons with corners in free cells next to blocked ones (a visibility graph), and a
    segment is free when none of its points lies in a blocked cell.
    """
    n = blocked.shape[0]
    to_cells = 1.0 / task.lattice.spacing
    reach = task.lattice.upper_arm + 1.0
    hand = (np.array(task.hand)[::-1] + reach) * to_cells - 0.5
    ring = hand_space(task.lattice).inside.reshape(n, n)
    padded = np.pad(blocked, 1)
    near = sum(padded[1 + i : n + 1 + i, 1 + j : n + 1 + j] for i in (-1, 0, 1) for j in (-1, 0, 1))
    corners = np.vstack([hand, np.argwhere(ring & ~blocked & (near > 0))])

    def seen(points, others):
        """Lengths (p, o) of free segments, infinite where something is in the way."""
        share = np.linspace(0.0, 1.0, 160)[:, None, None]
        out = np.empty((len(points), len(others)))
        for k, point in enumerate(points):
            way = np.rint(point + share * (others - point)).astype(int)
            free = ~blocked[np.clip(way[..., 0], 0, n - 1), np.clip(way[..., 1], 0, n - 1)]
            length = np.hypot(*(others - point).T)
            out[k] = np.where(free.reshape(160, -1).all(axis=0), length, np.inf)
        return out

    between = seen(corners, corners)
    length = between[0].copy()
    for _ in range(40):
        length = np.minimum(length, (length[:, None] + between).min(axis=0))
    cells = np.argwhere(ring & ~blocked)
    ways = np.full((n, n), np.nan)
    ways[tuple(cells.T)] = (length[:, None] + seen(corners, cells)).min(axis=0)
    return ways


@pytest.mark.parametrize(
    ("hand", "wall"),
    [
        ((1.2, 0.3), disc("obstacle", "behind a tip", (1.05, 0.95), radius=0.08)),
        ((1.0, -0.9), disc("obstacle", "in the middle", (0.2, 1.2), radius=0.15)),
        ((-0.3, 1.1), disc("obstacle", "by the elbow", (0.5, 0.5), radius=0.05)),
    ],
    ids=lambda a: getattr(a, "name", None),
)
def test_round_a_static_wall(hand, wall):
    """The front's times are those of the shortest ways round what it froze, or nearly so."""
    task = task_of(scene(wall, hand=hand, horizon=5.0), 40)
    front = march(task, COARSE)
    frozen = front.state == FROZEN
    assert np.count_nonzero(frozen) > 15
    exact, found = shortest_ways(task, frozen), in_cells(task, front)
    cells = np.isfinite(exact) & ~frozen & np.isfinite(found)
    assert np.count_nonzero(cells) > 0.9 * np.count_nonzero(np.isfinite(exact))
    excess = (found - exact)[cells]
    hidden = (exact - away(task))[cells] > 0.5
    assert np.count_nonzero(hidden) > 100
    assert excess.min() > -0.5  # a ray may shave a blocked cell's corner
    assert np.median(np.abs(excess[hidden])) < 0.35 and excess.max() < 1.5
    assert np.abs(excess[~hidden]).max() < 0.5


def test_static_obstacles_only_make_it_later():
    for k in range(15):
        rng = seeding.rng(42, k)
        situation = three_discs(rng, moving=False)
        bodies = situation.bodies[1:4]
        before = None
        for count in range(4):
            task = task_of(scene(*bodies[:count], horizon=5.0))
            front = march(task, EXPLORE)
            arrival = np.where(front.state == FREE, in_cells(task, front), np.nan)
            arrival[np.isnan(arrival)] = np.inf
            if before is not None:
                assert (arrival >= before - 0.05)[np.isfinite(before)].all()
                assert np.isinf(arrival[np.isinf(before)]).all()
            before = arrival


@pytest.mark.parametrize("k", range(3))
def test_marching_and_wave_agree(k):
    """After an affine fit the two maps differ by little more than the wave's anisotropy."""
    situation = three_discs(seeding.rng(43, k), moving=False)
    task = task_of(situation)
    wave = propagate(task, WaveParams(until="horizon", laplacian=9))
    marched = march(task, EXPLORE)
    both = (wave.arrival > 0.0) & (marched.arrival > 0.0)
    both &= (wave.state == FREE) & (marched.state == FREE)
    assert np.count_nonzero(both) > 2500
    ours, theirs = marched.arrival[both] * 400.0, wave.arrival[both] * 400.0  # [tau]
    slope, shift = np.polyfit(ours, theirs, 1)
    assert slope == pytest.approx(1.0, abs=0.05) and 10.0 < shift < 25.0
    assert np.std(theirs - slope * ours - shift) < 3.0
    agree = (wave.state == FROZEN) == (marched.state == FROZEN)
    reached = (wave.arrival > 0.0) & (marched.arrival > 0.0)
    assert np.mean(agree[reached]) > 0.99


@pytest.mark.parametrize(
    ("move", "back"),
    [
        (mirrored, lambda a: a[::-1]),
        (lambda s: turned(s, 0.5 * np.pi), lambda a: np.rot90(a)),
        (lambda s: turned(s, np.pi), lambda a: np.rot90(a, 2)),
    ],
    ids=["mirror", "quarter turn", "half turn"],
)
def test_symmetry(move, back):
    for k in range(8):
        situation = three_discs(seeding.rng(44, k))
        here, there = (march(task_of(s, 40), COARSE) for s in (situation, move(situation)))
        states = np.count_nonzero(here.state != back(there.state))
        assert states <= 2
        task = task_of(situation, 40)
        difference = np.abs(in_cells(task, here) - back(in_cells(task, there)))
        assert np.nanquantile(difference, 0.98) < 0.05


def test_contact():
    ball = disc("target", "ball", (-0.4, 1.0), radius=0.05)
    task = task_of(scene(ball, grasp=0.05))
    front = march(task, MarchingParams())
    assert front.contact_body == 0 and front.state.ravel()[front.contact_cell] == CONTACT
    exact = (np.hypot(-0.4 - 1.2, 1.0 - 0.3) - 0.1) / SPEED
    assert front.contact_time == pytest.approx(exact, abs=task.lattice.spacing / SPEED)


def test_the_front_stops_at_the_horizon():
    task = task_of(scene(horizon=0.3))
    front = march(task, EXPLORE)
    reached = front.arrival >= 0.0
    assert 0.9 * 0.3 < front.arrival.max() <= 0.3
    inside = hand_space(task.lattice).inside.reshape(80, 80)
    assert np.array_equal(reached, inside & (away(task) <= 0.3 * SPEED / task.lattice.spacing))


def test_same_bytes_again_and_in_threads():
    tasks = [task_of(three_discs(seeding.rng(45, k)), 40) for k in range(8)]
    alone = [march(task, COARSE).arrival.tobytes() for task in tasks]
    found: dict[int, list[bytes]] = {}

    def work(name):
        found[name] = [march(task, COARSE).arrival.tobytes() for _ in range(10) for task in tasks]

    threads = [threading.Thread(target=work, args=(name,)) for name in (0, 1)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert found[0] == found[1] == alone * 10
