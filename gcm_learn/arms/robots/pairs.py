"""Pairs of links to check for self-collision, found by sampling postures."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from gcm_learn import seeding
from gcm_learn.arms.chain import ChainModel

POSTURES = 4000
ALWAYS = 0.95
"""Share of the postures: pairs that overlap in as many are taken for parts that touch by design."""


def frames_at(model: ChainModel, joints: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return rotations (k + 1, m, 3, 3) and places (k + 1, m, 3) of all frames at m postures."""
    count, joints = len(joints), model.values(joints)
    rotations, places = [np.broadcast_to(np.eye(3), (count, 3, 3))], [np.zeros((count, 3))]
    for k, joint in enumerate(model.joints):
        rotation, place = rotations[model.parent(k)], places[model.parent(k)]
        place = place + rotation @ np.array(joint.origin)
        rotation = rotation @ Rotation.from_quat(joint.rotation, scalar_first=True).as_matrix()
        moved = joints[:, k, None] * np.array(joint.axis)
        if joint.type == "prismatic":
            place = place + np.einsum("mij,mj->mi", rotation, moved)
        else:
            rotation = rotation @ Rotation.from_rotvec(moved).as_matrix()
        rotations.append(rotation)
        places.append(place)
    return np.array(rotations), np.array(places)


def checked_pairs(model: ChainModel, seed: int = 0) -> tuple[tuple[int, int], ...]:
    """Return pairs of links that overlap in some postures and not in all.

    Left out are links of one joint, links of neighbouring joints, and pairs that overlap never or
    always in a sample of postures, as MoveIt's setup assistant does.

    Parameters
    ----------
    model : ChainModel
    seed : int
        Of the sample.
    """
    low, high = np.array(model.ranges).T
    joints = seeding.rng(seed, 27).uniform(low, high, (POSTURES, model.dof))
    rotations, places = frames_at(model, joints)
    ends = [
        [
            rotations[link.joint] @ np.array(end) + places[link.joint]
            for end in (link.start, link.end)
        ]
        for link in model.links
    ]
    pairs = []
    for i, first in enumerate(model.links):
        for j in range(i + 1, len(model.links)):
            second = model.links[j]
            low, high = sorted((first.joint, second.joint))
            if low == high or model.parent(high - 1) == low:
                continue
            gap = segment_distance(*ends[i], *ends[j]) - first.radius - second.radius
            if 0.0 < np.mean(gap < 0.0) < ALWAYS:
                pairs.append((i, j))
    return tuple(pairs)


def segment_distance(a: np.ndarray, b: np.ndarray, c: np.ndarray, d: np.ndarray) -> np.ndarray:
    """Return the distances (m,) of segments a-b and c-d, each of (m, 3) points.

    The nearest points of the lines are clamped to the segments in turn (Ericson, Real-Time
    Collision Detection, 5.1.9).
    """
    u, v, w = b - a, d - c, a - c
    uu, vv, uv = (np.einsum("mi,mi->m", *pair) for pair in ((u, u), (v, v), (u, v)))
    uw, vw = np.einsum("mi,mi->m", u, w), np.einsum("mi,mi->m", v, w)
    tiny = 1e-15
    bottom = uu * vv - uv * uv
    s = np.where(bottom > tiny, (uv * vw - vv * uw) / np.maximum(bottom, tiny), 0.0)
    s = np.clip(s, 0.0, 1.0)
    t = np.where(vv > tiny, (uv * s + vw) / np.maximum(vv, tiny), 0.0)
    clamped = np.clip(t, 0.0, 1.0)
    again = np.where(uu > tiny, (uv * clamped - uw) / np.maximum(uu, tiny), 0.0)
    s = np.clip(np.where(uu > tiny, again, 0.0), 0.0, 1.0)
    away = w + s[:, None] * u - clamped[:, None] * v
    return np.linalg.norm(away, axis=1)
