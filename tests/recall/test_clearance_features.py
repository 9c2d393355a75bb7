"""What is looked at: the world at t = 0 as the arm finds it, not how it is written down."""

from dataclasses import replace

import numpy as np

from gcm_learn import seeding
from gcm_learn.families.random_planar import random_planar
from gcm_learn.families.random_solid import random_solid
from gcm_learn.motion.movement import Movement
from gcm_learn.motion.verification import clearance
from gcm_learn.recall.features import TOUCH, batched
from gcm_learn.recall.hand_features import (
    CELLS,
    CONTEXT,
    DIRECTIONS,
    LENGTHS,
    RINGS,
    clearance_features,
)
from gcm_learn.situation import PlanarQuadratic
from gcm_learn.situation.canonical import canonical
from tests.transforms import mirrored, turned
from tests.worlds import disc


def drawn(k, family=random_planar):
    return family(seeding.rng(91, k))


def same(here, there):
    np.testing.assert_allclose(there.context, here.context, atol=2e-5)
    np.testing.assert_allclose(there.cells, here.cells, atol=2e-5)


def test_a_turned_or_mirrored_situation_looks_the_same():
    for k in range(12):
        situation = drawn(k)
        for other in (turned(situation, 1.234), mirrored(situation)):
            same(clearance_features(situation), clearance_features(other))
        solid = drawn(k, random_solid)
        same(clearance_features(solid), clearance_features(canonical(solid)[0]))


def test_the_order_of_bodies_does_not_matter_but_for_the_order_of_rows():
    situation = next(s for s in map(drawn, range(99)) if len(s.obstacles) == 4)
    here = clearance_features(situation)
    there = clearance_features(replace(situation, bodies=situation.bodies[::-1]))
    np.testing.assert_array_equal(there.context, here.context)
    np.testing.assert_array_equal(there.cells[::-1], here.cells)


def test_a_body_that_cannot_be_met_is_not_seen():
    situation = drawn(3)
    far = disc("moon", (40.0, 0.0), radius=0.5)
    seen = clearance_features(replace(situation, bodies=(*situation.bodies, far)))
    np.testing.assert_array_equal(seen.cells, clearance_features(situation).cells)


def test_cells_say_what_a_resting_limb_meets():
    """A cell touches exactly if a limb that rests there has no clearance."""
    checked = 0
    for k in range(30):
        situation = drawn(k)
        arm, bodies = situation.arm, situation.bodies
        still = [
            replace(b, motion=PlanarQuadratic(b.motion.position, (0.0, 0.0), (0.0, 0.0)))
            for b in bodies
        ]
        situation = replace(situation, bodies=tuple(still))
        if not situation.obstacles:
            continue
        seen = clearance_features(situation).cells
        cells = np.max(seen, axis=0, initial=0.0).reshape(len(LENGTHS), len(RINGS), DIRECTIONS)
        side = 1.0 if arm.elbow == "right" else -1.0
        start = np.arctan2(arm.hand[1], arm.hand[0])
        for i, j in ((1, 0), (3, 5), (4, 20)):
            r = arm.inner_reach + RINGS[i] * (arm.reach - arm.inner_reach)
            a = start + side * 2.0 * np.pi * j / DIRECTIONS
            hand = np.array([[np.cos(a), np.sin(a)]]) * r
            way = Movement.of_hand(arm, np.array([0.0]), hand)
            room = clearance(situation, way)[0]
            if abs(room) < 1e-3:
                continue
            assert (cells[-1, i, j] == TOUCH) == (room <= 0.0)
            checked += 1
    assert checked > 40


def test_many_looks_as_one_keep_apart_whose_is_whose():
    situations = [drawn(k) for k in range(20)]
    many = [clearance_features(s) for s in situations]
    whole = batched(many)
    assert whole.context.shape == (20, CONTEXT) and whole.cells.shape[1] == CELLS
    for k, one in enumerate(many):
        np.testing.assert_allclose(whole.cells[whole.whose == k] / 170, one.cells, atol=0.5 / 170)
