"""Sources of seeds: stored catches by some order, or a learned model of postures."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from planting import Seeds, plant

from gcm_learn.recall import Memory
from gcm_learn.recall.headings import heading_of
from gcm_learn.recall.joint_moves import TIME

GATES = (4, 8, 11)  # knots of a movement that are planted; the last catches


@dataclass(frozen=True)
class Recalled:
    """Stored catches, the most promising first."""

    memory: Memory
    count: int
    """Seeds at most."""
    gates: bool
    """True if postures on the way are planted, too."""

    def __call__(self, problem: Any, trees: Any, end: float, way: Any) -> bool:
        """Plant them."""
        place = self.memory.index.embed_query(problem.situation, problem.scene)
        chosen = self.memory.recall(place, self.count)
        made = seeds_of(problem, self.memory.knots[chosen])
        return bool(plant(problem.study, trees, made, self.gates, end, way))


def seeds_of(problem: Any, knots: np.ndarray) -> Seeds:
    """Return movements (k, knots, n + 2), in the heading of the target, as seeds.

    Their first posture is moved to the start, the others by what is left of the movement.
    """
    limb, scene = problem.study.scene.limb, problem.scene
    joints = knots[:, :, :TIME].astype(float) + heading_of(limb, scene).shift
    took = np.abs(np.diff(joints, axis=1)) / scene.limits.joint_speed
    length = np.cumsum(took.max(axis=2), axis=1)
    left = 1.0 - np.hstack([np.zeros((len(knots), 1)), length / np.maximum(length[:, -1:], 1e-9)])
    joints += left[:, :, None] * (limb.start - joints[:, :1])
    joints = np.clip(joints, limb.low, limb.high)
    some = np.array(GATES)
    return Seeds(np.ascontiguousarray(joints[:, some]), knots[:, some, TIME].astype(float))
