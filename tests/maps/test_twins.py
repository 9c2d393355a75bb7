"""Static twins of dynamic situations."""

import numpy as np
import pytest

from gcm_learn import families
from gcm_learn.errors import SituationError
from gcm_learn.maps import build_map, static_twin
from gcm_learn.scene import TOP_SPEED, pack_bodies, pose
from gcm_learn.wave import MarchingParams

N = MarchingParams(n=40)


def drawn(family, k):
    situation = families.draw(family, 9, k)
    return situation, build_map(situation, N)


@pytest.mark.parametrize("k", range(3))
def test_what_rests_is_its_own_twin(k):
    situation, made = drawn("static-clutter", k)
    assert made.interception is not None and made.effective_obstacles.any()
    again = build_map(static_twin(situation, made, poses=5), N)
    assert np.array_equal(again.effective_obstacles, made.effective_obstacles)
    assert again.interception.time <= made.interception.time + 1e-9


def test_bodies_rest_where_the_front_met_them():
    """With several poses the twin's front is kept out of more of the effective obstacles."""
    shut = []
    for k in range(16):
        situation, made = drawn("crossing-swarm", k)
        if made.interception is None or not made.effective_obstacles.any():
            continue
        both = [static_twin(situation, made, poses) for poses in (1, 5)]
        for twin in both:
            assert np.all(pack_bodies(twin).rows[:, TOP_SPEED] == 0.0)
            names = [body.name for body in situation.bodies]
            place, _ = pose(situation, names.index(twin.bodies[0].name), made.interception.time)
            assert np.allclose(pose(twin, 0, 0.0)[0], place)
        entered = [~np.ma.getmaskarray(build_map(twin, N).arrival) for twin in both]
        shut.append([1.0 - e[made.effective_obstacles].mean() for e in entered])
    once, often = np.mean(shut, axis=0)
    assert len(shut) >= 5 and once + 0.1 < often


def test_a_map_without_a_catch_has_no_twin():
    missed = (one for k in range(60) if (one := drawn("gate", k))[1].interception is None)
    with pytest.raises(SituationError, match="met no target"):
        static_twin(*next(missed))
