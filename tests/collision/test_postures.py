"""A spatial limb among moving bodies, against looking at very many instants."""

import numpy as np
import pytest

from gcm_learn.arms.curves import hermite, line, on_curve
from gcm_learn.collision.postures import desk_of, distance_at, least_on, move_is_free
from gcm_learn.scene import pack
from gcm_learn.situation import read_situations
from tests.spatial import EXAMPLES

SITUATIONS = read_situations(EXAMPLES)
INSTANTS = np.linspace(0.0, 1.0, 1501)
FINE = 5e-3  # how far limb and bodies may come in one of the instants, in lengths


def anywhere(scene, rng):
    return scene.limb.low + rng.random(4) * (scene.limb.high - scene.limb.low)


def looked_at(scene, curve, since, until, desk):
    """Least distance over the instants of a move."""
    q, least = np.empty(4), np.inf
    for s in INSTANTS:
        on_curve(curve, s, q)
        least = min(least, distance_at(scene, q, since + s * (until - since), desk))
    return least


@pytest.mark.parametrize("k", range(0, len(SITUATIONS), 5))
def test_the_least_distance_over_a_move_is_that_of_all_its_instants(k):
    scene, rng = pack(SITUATIONS[k]), np.random.default_rng(k)
    desk, horizon = desk_of(scene), SITUATIONS[k].horizon
    for straight in (True, False) * 3:
        q, p = anywhere(scene, rng), anywhere(scene, rng)
        since, until = np.sort(rng.random(2)) * horizon
        if straight:
            line(q, p, desk.curve)
        else:
            v, w = rng.normal(size=(2, 4)) * 3.0
            hermite(q, v, p, w, until - since, desk.curve)
        curve = desk.curve.copy()
        found, when = least_on(scene, since, until, 0.0, 1e-6, 1e300, desk)
        seen = looked_at(scene, curve, since, until, desk)
        assert found <= max(seen, 0.0) + 2e-6
        assert found >= seen - FINE * (1 + 4 * (not straight))
        assert (when == -1.0) == (found > 1e200)


@pytest.mark.parametrize("k", range(0, len(SITUATIONS), 7))
def test_a_move_is_free_where_its_least_distance_says_so(k):
    scene, rng = pack(SITUATIONS[k]), np.random.default_rng(k)
    desk, horizon = desk_of(scene), SITUATIONS[k].horizon
    answers = []
    for _ in range(60):
        q, p, until = anywhere(scene, rng), anywhere(scene, rng), horizon * rng.random()
        line(q, p, desk.curve)
        least, _ = least_on(scene, 0.0, until, 0.0, 1e-7, 1e300, desk)
        for touch in (0.999 * max(least, 0.0), 1.001 * max(least, 0.0) + 1e-6):
            answers.append(move_is_free(scene, q, 0.0, p, until, touch, desk))
            assert answers[-1] == (least > touch)
    if desk.obstacles.size:
        assert True in answers and False in answers


def test_hermite_goes_through_its_ends_with_their_rates():
    q, v, p, w = np.random.default_rng(0).normal(size=(4, 4))
    curve, at, near = np.empty((4, 4)), np.empty(4), np.empty(4)
    hermite(q, v, p, w, 0.7, curve)
    for s, place, rate in ((0.0, q, v), (1.0, p, w)):
        on_curve(curve, s, at)
        on_curve(curve, s + 1e-7, near)
        assert np.allclose(at, place, atol=1e-12)
        assert np.allclose((near - at) / 0.7e-7, rate, atol=1e-4)
