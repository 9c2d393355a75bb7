"""Marching over any chart: a toy chart in space, by brute force; the plane's, by marching.

The toy chart has three dimensions and four postures in a ring.  It is marched, descended and
verified through the doors that serve the plane.
"""

from __future__ import annotations

import heapq
import itertools

import numpy as np
import pytest

from gcm_learn import seeding
from gcm_learn.arms import Arm
from gcm_learn.errors import LatticeError
from gcm_learn.handspace import Chart, Lattice
from gcm_learn.maps import build_map, chain_to, descend, explore
from gcm_learn.scene import pack
from gcm_learn.situation import Body, Plane, Situation, SolidQuadratic, Sphere
from gcm_learn.wave import MarchingParams, WaveParams, march, march_layers
from gcm_learn.wave.general import spread
from tests.handspace.toy import SWIVELS, Cube
from tests.wave.scenes import disc, scene, setting_of, three_discs

STILL = (0.0, 0.0, 0.0)
FLAT = Plane(STILL, (1.0, 0.0, 0.0), (0.0, 1.0, 0.0))
THICKNESS, GRASP = 0.04, 0.05
TICK = 0.0125  # steps of the toy take 8 ticks in space and 12 from swivel to swivel
BARE = MarchingParams(margin=0.0, until="horizon")


def ball(role, name, position, velocity=STILL, radius=0.1):
    return Body(role, name, Sphere(radius), SolidQuadratic(position, velocity, STILL))


def around(*bodies, horizon=2.0):
    """Make a situation in space around the toy chart; its target is far away by default."""
    if not any(body.role == "target" for body in bodies):
        bodies = (*bodies, ball("target", "far", (9.0, 9.0, 9.0)))
    arm = Arm((1.1, 0.3), 2.0, thickness=THICKNESS, grasp=GRASP)
    return Situation("toy", horizon, arm, bodies, FLAT)


def flying(rng, count=3):
    """Draw balls that fly through the cube, and not through the limb at the start."""
    bodies, cube = [], Cube()
    while len(bodies) < count:
        way = rng.normal(size=3)
        velocity = way / np.linalg.norm(way) * rng.uniform(0.4, 1.2)
        through = np.array([1.1, 0.3, 0.2]) + rng.uniform(-0.4, 0.4, size=3)
        place = through - velocity * rng.uniform(0.5, 1.2)
        body = ball("obstacle", str(len(bodies)), tuple(place.tolist()), tuple(velocity.tolist()))
        if apart(cube, cube.start(None)[0], body, 0.0)[0] > 0.3:
            bodies.append(body)
    return around(*bodies)


def apart(cube, nodes, body, t):
    """Distance (k,) of limbs to a ball's surface at t [s], by an own formula."""
    centre = np.array(body.motion.position) + np.array(body.motion.velocity) * t
    joints = cube.limbs[nodes]
    least = np.full(len(joints), np.inf)
    for a, b in ((joints[:, 0], joints[:, 1]), (joints[:, 1], joints[:, 2])):
        along = b - a
        share = ((centre - a) * along).sum(axis=1) / (along**2).sum(axis=1)
        nearest = a + np.clip(share, 0.0, 1.0)[:, None] * along
        least = np.minimum(least, np.linalg.norm(centre - nearest, axis=1))
    return least - body.shape.radius


def is_free(situation, cube, nodes, t):
    """Whether limbs (k,) are clear of all obstacles at t [s]."""
    bodies = [b for b in situation.bodies if b.role == "obstacle"]
    clear = [apart(cube, nodes, body, t) > THICKNESS for body in bodies]
    return np.logical_and.reduce([np.ones(len(nodes), dtype=bool), *clear])


def neighbours(cube, node):
    """Neighbours of a node and the steps to them [s], spelled out."""
    (i, j, k, s), out = np.unravel_index(node, cube.shape), []
    for d in ((1, 0, 0), (0, 1, 0), (0, 0, 1)):
        for side in (1, -1):
            cell = tuple(c + side * e for c, e in zip((i, j, k), d, strict=True))
            if min(cell) >= 0 and max(cell) < cube.n:
                out.append((np.ravel_multi_index((*cell, s), cube.shape), cube.spacing / 2.0))
    for side in (1, -1):
        beside = (i, j, k, (s + side) % SWIVELS)
        out.append((np.ravel_multi_index(beside, cube.shape), cube.turn))
    return [(int(q), step) for q, step in out if cube.inside[q]]


def reached_by_waiting(situation, cube):
    """First arrivals (nodes,) [s] by brute force: where the hand can be at every tick."""
    ticks, nodes = round(situation.horizon / TICK), np.arange(len(cube.hands))
    free = np.array([is_free(situation, cube, nodes, t * TICK) for t in range(ticks + 1)])
    there = np.zeros_like(free)
    start = int(cube.start(None)[0][0])
    there[0, start] = free[0, start]
    table = [neighbours(cube, node) for node in nodes]
    for t in range(1, ticks + 1):
        there[t] = there[t - 1] & free[t]
        for node in np.flatnonzero(free[t] & cube.inside):
            for q, step in table[node]:
                k = round(step / TICK)
                if t >= k and there[t - k, q] and free[t - k : t + 1, node].all():
                    there[t, node] = True
    first = np.where(there.any(axis=0), there.argmax(axis=0) * TICK, np.inf)
    return first


def reached_at_once(situation, cube):
    """First arrivals without waits and refusals, by Dijkstra with sampled occupancy."""
    start = int(cube.start(None)[0][0])
    came, refused, waiting = {}, set(), [(0.0, start, 0.0)]
    while waiting:
        t, node, step = heapq.heappop(waiting)
        if node in came or t > situation.horizon:
            continue
        came[node] = t
        instants = np.linspace(t - step, t, 40)
        if not all(is_free(situation, cube, np.array([node]), s)[0] for s in instants):
            refused.add(node)
            continue
        for q, took in neighbours(cube, node):
            heapq.heappush(waiting, (t + took, q, took))
    return came, refused


@pytest.fixture
def cube():
    return Cube()


def test_it_is_a_chart_as_the_lattice_is(cube):
    assert isinstance(cube, Chart) and isinstance(Lattice(20), Chart)
    steps = cube.steps(None)
    for node in (0, 7, 250, 499):
        span = slice(*steps.first[node : node + 2])
        wanted = np.array(sorted(neighbours(cube, node)))
        order = np.argsort(steps.to[span])
        assert steps.to[span][order].tolist() == wanted[:, 0].tolist()
        np.testing.assert_allclose(steps.time[span][order], wanted[:, 1])


@pytest.mark.parametrize("turn", [0.15, 0.4])
def test_in_free_space_costs_add_up(turn):
    """Steps along the axes, and the shorter way round the ring of postures."""
    cube = Cube(turn=turn)
    made = build_map(around(), BARE, chart=cube)
    middle = np.array([2, 2, 2])
    index = np.stack(np.unravel_index(np.arange(len(cube.hands)), cube.shape), axis=-1)
    ring = np.minimum(index[:, 3], SWIVELS - index[:, 3])
    exact = np.abs(index[:, :3] - middle).sum(axis=1) * cube.spacing / 2.0 + ring * turn
    assert made.arrival.shape == (5, 5, 5, 4) and made.engine == "marching"
    assert not made.arrival.mask.any()
    np.testing.assert_allclose(made.arrival.ravel(), exact, atol=1e-12)


@pytest.mark.parametrize("k", range(6))
def test_without_waits_it_is_what_brute_force_finds(cube, k):
    situation = flying(seeding.rng(71, k))
    made = build_map(situation, BARE, chart=cube)
    came, refused = reached_at_once(situation, cube)
    ours = set(np.flatnonzero(made.effective_obstacles))
    assert len(ours ^ refused) <= 0.02 * len(came)
    arrival = made.arrival.filled(np.nan).ravel()
    theirs = np.full(arrival.size, np.nan)
    free = [node for node in came if node not in refused]
    theirs[free] = [came[node] for node in free]
    both = np.isfinite(arrival) & np.isfinite(theirs)
    assert both.sum() > 100
    assert np.mean(np.abs(arrival - theirs)[both] < 1e-9) > 0.97  # grazes go either way
    assert np.count_nonzero(np.isfinite(arrival) != np.isfinite(theirs)) <= 0.02 * len(came)


@pytest.mark.parametrize("k", range(4))
def test_with_waits_it_is_what_brute_force_finds(cube, k):
    situation = flying(seeding.rng(72, k), 4)
    front = explore(pack(situation), cube, BARE, wait=True)
    theirs, ours = reached_by_waiting(situation, cube), front.first.ravel()
    both = np.isfinite(theirs) & (ours >= 0.0)
    assert np.count_nonzero(np.isfinite(theirs) != (ours >= 0.0)) <= 0.02 * both.sum()
    late = (theirs - ours)[both]
    assert np.mean((late > -1.5 * TICK) & (late < 4.0 * TICK)) > 0.97
    assert len(front.nodes) > both.sum() > 300  # cells that are left and reached again
    plain = build_map(situation, BARE, chart=cube).arrival.filled(np.inf).ravel()
    assert (ours[np.isfinite(plain)] <= plain[np.isfinite(plain)] + 1e-9).all()


def goal_behind(cube, wall=True):
    """A ball to catch in a corner of the cube, and one that is in the way of some limbs."""
    goal = ball("target", "goal", tuple(cube.hands[-1].tolist()), radius=0.05)
    post = ball("obstacle", "post", (1.4, 0.3, 0.2), radius=0.12)
    return around(goal, *([post] if wall else []))


def complaints(situation, cube, nodes, times):
    """What is wrong with a path of nodes (m,) that the hand comes to at times (m,) [s]."""
    out = []
    steps = zip(nodes[:-1], nodes[1:], times[:-1], times[1:], strict=True)
    for a, b, left, came in steps:
        step = dict(neighbours(cube, a)).get(b)
        if step is None:
            out.append(f"{a} and {b} are no neighbours")
        elif came < left + step - 1e-9:
            out.append(f"the step from {a} to {b} is too fast")
        elif not all(
            is_free(situation, cube, np.array([b]), t)[0] for t in np.linspace(came - step, came, 9)
        ):
            out.append(f"{b} is not free")
        elif not all(
            is_free(situation, cube, np.array([a]), t)[0] for t in np.linspace(left, came - step, 9)
        ):
            out.append(f"{a} is left too late")
    return out


@pytest.mark.parametrize("wall", [False, True])
def test_it_is_descended_and_the_path_holds(cube, wall):
    situation = goal_behind(cube, wall)
    made = build_map(situation, MarchingParams(margin=0.0), chart=cube)
    assert made.interception is not None and made.interception.body == "goal"
    points, arrival = descend(made)
    node = np.ravel_multi_index(made.interception.cell, cube.shape)
    nodes = chain_to(made, int(node))
    np.testing.assert_allclose(points, cube.hands[nodes])
    np.testing.assert_allclose(arrival, made.arrival.ravel()[nodes])
    assert np.linalg.norm(points[-1] - cube.hands[-1]) <= 0.05 + 0.71 * cube.spacing
    assert complaints(situation, cube, nodes, arrival) == []
    steps = [dict(neighbours(cube, a))[b] for a, b in itertools.pairwise(nodes)]
    assert arrival[-1] == pytest.approx(sum(steps))  # costs add up, nobody waits
    assert made.interception.time == pytest.approx(arrival[-1])


@pytest.mark.parametrize("k", range(12))
def test_the_chain_of_a_front_that_waits_holds(cube, k):
    drawn = flying(seeding.rng(73, k), 4)
    goal = ball("target", "goal", tuple(cube.hands[-1].tolist()), radius=0.05)
    situation = around(*drawn.bodies[:4], goal)
    front = explore(pack(situation), cube, MarchingParams(margin=0.0), wait=True)
    if front.met_state < 0:
        pytest.skip("blocked at the start, or the goal is")
    chain = front.chain()
    nodes, arrival = front.nodes[chain].tolist(), front.arrival[chain]
    assert complaints(situation, cube, nodes, arrival) == []
    assert front.met_time >= arrival[-1] and front.met.ravel()[nodes[-1]]
    assert (np.diff(front.arrival) >= 0.0).all() and (front.end >= front.arrival).all()


def test_what_cannot_meet_a_target_any_more_is_not_queued(cube):
    situation = goal_behind(cube, wall=False)
    near, far = (pack(around(*situation.bodies, horizon=h)) for h in (0.62, 2.0))
    few, many = (explore(s, cube, MarchingParams(margin=0.0), wait=True) for s in (near, far))
    assert few.met_body == many.met_body == 0 and few.met_time == many.met_time
    assert len(few.nodes) < 0.8 * len(many.nodes)


def test_maps_of_other_charts_say_what_they_cannot(cube, tmp_path):
    made = build_map(around(), BARE, chart=cube)
    with pytest.raises(TypeError, match="Cube"):
        made.save(tmp_path / "map")
    with pytest.raises(TypeError, match="Cube"):
        build_map(around(), WaveParams(), chart=cube)
    assert descend(made) is None  # nothing was met
    with pytest.raises(LatticeError):
        Lattice(3)


# --- the plane ---------------------------------------------------------------------------------

N = 32
PLANAR = MarchingParams(n=N, until="horizon")
OCTILE = 1.0 / np.cos(np.pi / 8)  # how much longer than the straight line steps may be


@pytest.mark.parametrize("k", range(10))
@pytest.mark.parametrize("wait", [False, True])
def test_marching_in_the_plane_means_the_same_and_is_more_exact(wait, k):
    setting = setting_of(three_discs(seeding.rng(74, k), moving=wait), N)
    fast = (march_layers if wait else march)(*setting, PLANAR)
    slow = spread(*setting, PLANAR, wait)
    ours, theirs = fast.first, slow.first
    if not wait:
        ours, theirs = (np.where(f.refused, -1.0, f.first) for f in (fast, slow))
    step = setting.lattice.spacing / setting.speed
    # Marching with waits ends where a target is met; the other explores on.
    until = min(fast.met_time, slow.met_time, situation_end(setting)) - 3.0 * step
    both = (ours >= 0.0) & (theirs >= 0.0)
    early = (ours >= 0.0) & (ours < until / OCTILE), (theirs >= 0.0) & (theirs < until / OCTILE)
    if both.sum() < 50:
        pytest.skip("blocked from the start")
    assert np.count_nonzero((early[0] | early[1]) & ~both) <= 0.06 * both.sum()
    # Steps across a corner slip through where marching goes round.
    assert np.mean(theirs[both] >= ours[both] - step) > 0.9
    if not wait:  # at rest, what is late is late by the chart's steps
        assert np.mean(theirs[both] <= OCTILE * ours[both] + 1.5 * step) > 0.97
    assert np.median(np.abs(theirs - ours)[both]) < 2.0 * step


def situation_end(setting):
    return setting.scene.limits.horizon


def test_joint_limits_count_on_any_chart():
    situation = scene(disc("obstacle", "o", (-1.0, -1.0)), max_joint_speed=(2.0, 3.0), horizon=3.0)
    setting = setting_of(situation, N)
    fast, slow = march(*setting, PLANAR).first, spread(*setting, PLANAR, False).first
    both = (fast >= 0.0) & (slow >= 0.0)
    assert both.sum() > 200
    assert np.median(slow[both] / np.maximum(fast[both], 1e-9)) < 1.1
    free = spread(*setting.limited(shoulder=np.inf, elbow=np.inf), PLANAR, False).first
    assert (slow[both] >= free[both] - 1e-9).all()
