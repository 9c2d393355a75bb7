"""Cells against bodies over a span of time: nothing that passed in between is forgotten."""

import numpy as np
import pytest

from gcm_learn import seeding
from gcm_learn.arms import Arm
from gcm_learn.charts import Lattice
from gcm_learn.charts.lattice import hand_space
from gcm_learn.collision.occupancy import blocked_cells, first_touch, met_targets, postures_of
from gcm_learn.families.random_planar import random_planar
from gcm_learn.families.random_solid import random_solid
from gcm_learn.scene.bodies import poses_at
from gcm_learn.scene.packing import pack_bodies
from gcm_learn.situation import Body, Disc, PlanarQuadratic, Situation
from tests.planar_geometry import elbow_of, place, segment_distances

SHORTEST = 1e-5  # [s]
FAMILIES = {"planar": random_planar, "solid": random_solid}


def sampled(situation, b, hand, elbow, times):
    """Distances (n,) of body b to the limb at rest."""
    pose = place(situation, situation.bodies[b], times)
    shape, n = situation.bodies[b].shape, len(times)
    hand, elbow = np.tile(hand, (n, 1)), np.tile(elbow, (n, 1))
    upper_arm = segment_distances(shape, pose, np.zeros((n, 2)), elbow)
    return np.minimum(upper_arm, segment_distances(shape, pose, elbow, hand))


@pytest.mark.parametrize("family", FAMILIES)
@pytest.mark.parametrize("seed", range(12))
def test_first_touch_is_the_first_sampled_touch(family, seed):
    rng = seeding.rng(21, seed)
    situation = FAMILIES[family](rng)
    bodies, arm = pack_bodies(situation), situation.arm
    scratch = np.zeros((len(situation.bodies), 12))
    elbow = elbow_of(arm, np.array([arm.hand]))[0]
    gap, (t0, t1) = 0.1, np.sort(rng.uniform(0.0, situation.horizon, 2))
    times = np.linspace(t0, t1, 4001)
    for b, body in enumerate(situation.bodies):
        if body.role == "target":
            continue
        t = first_touch(bodies, b, *arm.hand, *elbow, gap, t0, t1, SHORTEST, scratch)
        d = sampled(situation, b, arm.hand, elbow, times)
        touching = np.flatnonzero(d <= gap)
        if t < 0.0:
            assert d.min() > gap - 1e-4
        else:
            assert sampled(situation, b, arm.hand, elbow, np.array([t]))[0] <= gap + 1e-6
            assert len(touching) == 0 or t <= times[touching[0]] + 1e-9
            before = times < t - 2.0 * SHORTEST
            assert not before.any() or d[before].min() > gap - 1e-4


@pytest.mark.parametrize("family", FAMILIES)
@pytest.mark.parametrize("seed", range(4))
def test_blocked_cells_are_those_touched_within_their_span(family, seed):
    rng = seeding.rng(22, seed)
    situation = FAMILIES[family](rng)
    lattice = Lattice(20, situation.arm.upper_arm, situation.arm.elbow)
    bodies, space = pack_bodies(situation), hand_space(lattice)
    cells = rng.permutation(np.flatnonzero(space.inside))[:60]
    now = 0.6
    since = rng.uniform(0.2, now, cells.size)
    gap = np.full(space.inside.size, 0.02)
    postures, blocked = postures_of(bodies, space.limb, gap), np.empty(cells.size, dtype=bool)
    poses_at(bodies, now, postures.poses)
    blocked_cells(postures, cells, since, cells.size, now, 1e-4, blocked)
    for cell, start, found in zip(cells, since, blocked, strict=True):
        hand, elbow = space.limb[cell, :2], space.limb[cell, 2:]
        times = np.linspace(start, now, 300)
        lowest = min(
            (
                sampled(situation, b, hand, elbow, times).min()
                for b, body in enumerate(situation.bodies)
                if body.role == "obstacle"
            ),
            default=np.inf,
        )
        if found:
            assert lowest <= 0.02 + 0.02  # between two samples it may come a little nearer
        else:
            assert lowest > 0.02 - 1e-3


def test_a_bullet_through_the_span_is_not_missed():
    """It is at neither end of the span near the limb."""
    motion = PlanarQuadratic((0.5, 5.0), (0.0, -100.0), (0.0, 0.0))
    still = PlanarQuadratic((1.5, 0.0), (0.0, 0.0), (0.0, 0.0))
    bodies = (Body("target", "ball", Disc(0.1), still), Body("obstacle", "b", Disc(1e-3), motion))
    situation = Situation("bullet", 1.0, Arm((2.0, 0.0), 1.0), bodies)
    packed, scratch = pack_bodies(situation), np.zeros((2, 12))
    args = (packed, 1, 2.0, 0.0, 1.0, 0.0, 0.0)
    t = first_touch(*args, 0.0, 0.1, 1e-6, scratch)
    assert t == pytest.approx((5.0 - 1e-3) / 100.0, abs=2e-6)
    assert first_touch(*args, 0.06, 0.1, 1e-6, scratch) == -1.0


@pytest.mark.parametrize("family", FAMILIES)
@pytest.mark.parametrize("seed", range(8))
def test_targets_met_are_the_first_sampled_ones(family, seed):
    rng = seeding.rng(23, seed)
    situation = FAMILIES[family](rng, (1, 2))
    bodies = tuple(
        Body("target", str(k), b.shape, b.motion) for k, b in enumerate(situation.bodies)
    )
    situation = Situation("t", situation.horizon, situation.arm, bodies, situation.plane)
    lattice = Lattice(20, situation.arm.upper_arm, situation.arm.elbow)
    space, now, gap = hand_space(lattice), 0.9, 0.3
    cells = rng.permutation(np.flatnonzero(space.inside))[:30]
    since = rng.uniform(0.0, now, cells.size)
    met, when = np.empty(cells.size, dtype=np.int64), np.empty(cells.size)
    postures = postures_of(pack_bodies(situation), space.limb, np.zeros(space.inside.size))
    poses_at(postures.bodies, now, postures.poses)
    met_targets(postures, gap, cells, since, cells.size, now, SHORTEST, met, when)
    for cell, start, body, t in zip(cells, since, met, when, strict=True):
        times = np.linspace(start, now, 400)
        hand = np.tile(space.limb[cell, :2], (400, 1))
        firsts = []
        for target in bodies:
            d = segment_distances(target.shape, place(situation, target, times), hand, hand)
            near = np.flatnonzero(d <= gap)
            firsts.append(times[near[0]] if len(near) else np.inf)
        if body < 0:
            assert min(firsts) == np.inf
        else:  # a graze may fall between two samples
            assert t <= min(firsts) + 1e-9
            there = segment_distances(
                bodies[body].shape,
                place(situation, bodies[body], np.array([t])),
                hand[:1],
                hand[:1],
            )
            assert there[0] <= gap + 1e-6
