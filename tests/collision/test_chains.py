"""Limbs as chains in space: distances against those in the plane and sampled ones; spans."""

from __future__ import annotations

import numpy as np
import pytest

from gcm_learn import seeding
from gcm_learn.collision.chains import Chains, add_spans, bone_distance
from gcm_learn.collision.distance import segment_distance
from gcm_learn.families.random_planar import random_planar
from gcm_learn.families.random_solid import random_solid
from gcm_learn.scene import pack_bodies
from gcm_learn.scene.bodies import HAND, PART, pose_at
from tests.referee import depths, place


@pytest.mark.parametrize("family", [random_planar, random_solid])
@pytest.mark.parametrize("k", range(6))
def test_in_the_plane_they_are_segments(family, k):
    rng = seeding.rng(81, k)
    situation = family(rng)
    bodies, poses = pack_bodies(situation), np.zeros((len(situation.bodies), 12))
    for b in range(len(situation.bodies)):
        pose_at(bodies, b, rng.uniform(0.0, situation.horizon), poses)
        joints = np.zeros((1, 2, 3))
        joints[0, :, :2] = rng.uniform(-2.0, 2.0, size=(2, 2))
        flat = segment_distance(bodies, poses, b, *joints[0, 0, :2], *joints[0, 1, :2])
        assert bone_distance(bodies, poses, b, joints, 0, 0) == pytest.approx(flat, abs=1e-9)


@pytest.mark.parametrize("k", range(12))
def test_in_space_they_are_as_near_as_their_nearest_point(k):
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
        sampled = max(depths(body.shape, (points - centre) @ turn).min(), 0.0)
        found = bone_distance(bodies, poses, b, ends[None], 0, 0)
        assert found == pytest.approx(sampled, abs=2e-3) and found <= sampled + 1e-9


def spans_of(chains, m, end, wanted):
    """Spans (k, 2) of a limb, after one that is known already."""
    total, times = add_spans(chains, m, end, wanted, np.full((1, 2), -1.0), 1)
    assert (times[0] == -1.0).all()
    return times[1:total]


@pytest.mark.parametrize("k", range(8))
def test_spans_are_those_of_dense_samples(k):
    rng = seeding.rng(83, k)
    situation = random_planar(rng, (2, 4))
    bodies, end = pack_bodies(situation), situation.horizon
    which = np.flatnonzero(bodies.rows[:, PART] != HAND)
    joints = np.zeros((30, 3, 3))
    joints[:, 1:, :2] = rng.uniform(-1.5, 1.5, size=(30, 2, 2))
    gap, poses = np.full(30, 0.05), np.zeros((len(bodies.rows), 12))
    shortest = 1e-3
    chains = Chains(bodies, which, joints, gap, poses.copy(), shortest)
    for m in range(30):
        own, other = (spans_of(chains, m, end, wanted) for wanted in (False, True))
        assert np.ptp(np.vstack([own, other]), axis=1).sum() == pytest.approx(end)  # no gaps
        for t in rng.uniform(0.0, end, 40):
            rooms = []
            for b in which:
                pose_at(bodies, b, t, poses)
                rooms += [bone_distance(bodies, poses, b, joints, m, j) - 0.05 for j in (0, 1)]
            if abs(min(rooms)) > 0.02:  # not at the ends of spans
                inside = ((own[:, 0] <= t) & (t <= own[:, 1])).any()
                assert inside == (min(rooms) > 0.0)
