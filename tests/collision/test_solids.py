"""Distances of points and segments to solids, held against dense samples."""

from __future__ import annotations

import numpy as np
import pytest

from gcm_learn import seeding
from gcm_learn.collision.solids import room_in_pose, solid_distance
from gcm_learn.families.random_solid import random_solid
from gcm_learn.scene import pack_bodies
from gcm_learn.scene.bodies import pose_at
from gcm_learn.situation import Sphere
from tests.referee import depths, place


@pytest.mark.parametrize("k", range(12))
def test_a_segment_is_as_near_as_its_nearest_point(k):
    rng = seeding.rng(82, k)
    situation = random_solid(rng)
    bodies, poses = pack_bodies(situation), np.zeros((len(situation.bodies), 12))
    for b, body in enumerate(situation.bodies):
        t = rng.uniform(0.0, situation.horizon)
        pose_at(bodies, b, t, poses)
        ends = poses[b, :3] + rng.uniform(-1.0, 1.0, size=(2, 3))
        along = np.linspace(0.0, 1.0, 2001)[:, None]
        points = ends[0] + along * (ends[1] - ends[0])
        centre, turn = (a[0] for a in place(situation, body, np.array([t])))
        depth = depths(body.shape, (points - centre) @ turn)
        rooms = [room_in_pose(bodies, b, *point, poses) for point in points[::100]]
        np.testing.assert_allclose(np.maximum(rooms, 0.0), np.maximum(depth[::100], 0.0), atol=1e-9)
        if not isinstance(body.shape, Sphere):
            sampled = max(depth.min(), 0.0)
            found = solid_distance(bodies, poses, b, *map(tuple, ends))
            assert found == pytest.approx(sampled, abs=2e-3) and found <= sampled + 1e-9
