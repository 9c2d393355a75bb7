"""Links that are checked against each other, found by sampling postures."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from itertools import combinations, product
from typing import NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from gcm_learn import seeding
from gcm_learn.arms.chain_model import ChainModel
from gcm_learn.arms.convex_kernels import gaps
from gcm_learn.arms.robots.capsules import Packed, enclosing, packed
from gcm_learn.arms.robots.tree import Hull, all_balls

POSTURES = 20_000
CORNERS = 2_000  # of the ranges, at most, among the postures
TOUCH = 1e-9  # distance of parts that touch [lengths]
Meets = dict[tuple[int, int], np.ndarray]


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


class RigidLink(NamedTuple):
    """A rigid link: its name, the joint whose frame carries it, and its parts in that frame."""

    name: str
    joint: int
    hulls: Sequence[Hull]


class Frames(NamedTuple):
    """Frames of a chain in sampled postures."""

    rotations: np.ndarray  # (k + 1, m, 3, 3)
    places: np.ndarray  # (k + 1, m, 3)
    random: np.ndarray  # (m,): false for corners of the ranges

    @classmethod
    def sampled(cls, model: ChainModel, seed: int) -> Frames:
        """Return frames at random postures, and at corners of the ranges."""
        rng = seeding.rng(seed, 27)
        low, high = np.array(model.ranges).T
        joints = rng.uniform(low, high, (POSTURES, model.dof))
        if 2**model.dof <= CORNERS:
            sides = np.array(list(product((False, True), repeat=model.dof)))
        else:
            sides = rng.random((CORNERS, model.dof)) < 0.5
        joints[: len(sides)] = np.where(sides, high, low)
        return cls(*frames_at(model, joints), np.arange(POSTURES) >= len(sides))

    def some(self, at: np.ndarray) -> Frames:
        """Return the frames of some postures, given by their numbers or by a mask."""
        return Frames(self.rotations[:, at], self.places[:, at], self.random[at])

    def gaps(self, one: Packed, two: Packed, joints: tuple[int, int]) -> np.ndarray:
        """Return distances (m,) of two groups of parts: 0 or less if they touch, cut to `TOUCH`."""
        (i, j), split = joints, len(one.rounds)
        back = self.rotations[i].transpose(0, 2, 1)
        places = np.einsum("mij,mj->mi", back, self.places[j] - self.places[i])
        return gaps(*(one + two), split, back @ self.rotations[j], places, TOUCH)

    def any_of(self, meets: Collection[np.ndarray]) -> np.ndarray:
        """Return in which postures (m,) any of some pairs meets."""
        return np.any([*meets, np.zeros(len(self.random), bool)], axis=0)


def meetings(
    solids: Sequence[RigidLink], frames: Frames, joined: Collection[frozenset[str]]
) -> tuple[Meets, set[tuple[int, int]]]:
    """Return link pairs that overlap, with flags of the postures (m,), and link pairs to skip.

    Pairs to skip are those that one joint joins, by name, or that overlap in all postures. Links of
    one frame are in neither result.
    """
    parts = [packed(solid.hulls) for solid in solids]
    about = [packed([enclosing(all_balls(solid.hulls)).hull]) for solid in solids]
    meets, passed = {}, set()
    for a, b in combinations(range(len(solids)), 2):
        joints = solids[a].joint, solids[b].joint
        if joints[0] == joints[1]:
            continue
        if frozenset((solids[a].name, solids[b].name)) in joined:
            passed.add((a, b))
            continue
        met = frames.gaps(about[a], about[b], joints) <= 0.0
        met[met] = frames.some(met).gaps(parts[a], parts[b], joints) <= 0.0
        if met.all():
            passed.add((a, b))
        elif met.any():
            meets[a, b] = met
    return meets, passed
