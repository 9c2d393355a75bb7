"""An index by likeness and by the change that an adaptation takes, for arms in joints.

A change has two ends. At the start the joints differ. At the end the target and its approach
differ, at the share of the horizon at which the memory catches. All are squared distances, each by
its mean over pairs of situations, so that one inner product holds their sum.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple

import numpy as np

from gcm_learn.errors import RecallError
from gcm_learn.recall.headings import axis_at, heading_of, signs_of, track_of
from gcm_learn.recall.index import Numbers, nearest_query, nearest_rows
from gcm_learn.recall.kinds import MEMORIES, raw_features
from gcm_learn.recall.raw_features import Scale
from gcm_learn.recall.waypoints import TIME, Waypoints
from gcm_learn.scene import Scene, pack

INSTANTS = 12  # at which the target is looked at, evenly over the horizon
FAR = 2.0  # distance from the origin at which targets are cut [reaches]
LEAST = 1e-6  # mean square below which a part tells nothing


class Ends(NamedTuple):
    """Ends of changes that a situation asks for, in the canonical frame of its arm."""

    start: np.ndarray
    """(n,): joints at t = 0 by their speeds [horizons]."""
    places: np.ndarray
    """(INSTANTS, 3): the target [reaches]."""
    axes: np.ndarray
    """(INSTANTS, 3): its approach, 0 without one."""


def ends_of(situation: Any, scene: Scene | None = None) -> Ends:
    """Return the ends of changes that a situation in any frame asks for."""
    scene = pack(situation) if scene is None else scene
    heading, signs = heading_of(scene.limb, scene), signs_of(situation)
    places, axes = track_of(scene, INSTANTS)
    mirror = np.array([1.0, signs.min(), 1.0])
    places = heading.points(places) * mirror / situation.arm.reach
    far = np.linalg.norm(places, axis=1, keepdims=True)
    speeds = np.array(situation.arm.max_joint_speed) * situation.horizon
    return Ends(
        (scene.limb.start - heading.shift) * signs / speeds,
        places * np.minimum(1.0, FAR / np.maximum(far, 1e-12)),
        axes @ heading.rows.T * mirror,
    )


@dataclass(frozen=True)
class ChangeIndex(Numbers):
    """Neighbours by raw parameters and by the size of the change, in equal parts."""

    scale: Scale
    parts: np.ndarray
    """(4,): weights of raw parameters, start, place and approach."""
    joints: int
    name: ClassVar[str] = "change"

    @classmethod
    def fit(cls, situations: Sequence[Any], seed: int = 0) -> ChangeIndex:
        """Learn the scales of the parameters and the mean sizes of the changes."""
        if not all(MEMORIES.of(situation).in_joints for situation in situations):
            raise RecallError("index 'change': knows arms in joints only")
        features = np.array([raw_features(s) for s in situations])
        ends = [ends_of(s) for s in situations]
        scale = Scale.of(features)
        seen = [
            scale(features),
            np.array([e.start for e in ends]),
            np.array([e.places for e in ends]).reshape(-1, 3),
            np.array([a for e in ends for a in e.axes if a.any()]).reshape(-1, 3),
        ]
        mean = np.array([2.0 * s.var(axis=0).sum() if len(s) else 0.0 for s in seen])
        weights = np.where(mean > LEAST, 1.0 / np.maximum(mean, LEAST), 0.0)
        return cls(scale, weights.astype(np.float32), len(ends[0].start))

    @property
    def arrays(self) -> dict[str, np.ndarray]:
        """The scales and the weights."""
        scale = {"mean": self.scale.mean, "spread": self.scale.spread}
        return scale | {"parts": self.parts, "joints": np.array([self.joints])}

    @classmethod
    def of(cls, arrays: Mapping[str, np.ndarray]) -> ChangeIndex:
        """The index with such numbers."""
        scale = Scale(arrays["mean"], arrays["spread"])
        return cls(scale, arrays["parts"], int(arrays["joints"][0]))

    @property
    def dim(self) -> int:
        """Numbers of an embedding: likeness, start, and for each instant place and approach."""
        return len(self.scale.mean) + self.joints + 3 + 7 * INSTANTS

    def embed_query(self, situation: Any, scene: Scene | None = None) -> np.ndarray:
        """Embedding of a situation."""
        raw, start, place, axis = self.parts
        scene = pack(situation) if scene is None else scene
        ends = ends_of(situation, scene)
        far = -place * (ends.places**2).sum(axis=1) - axis * (ends.axes**2).sum(axis=1)
        parts = (
            2.0 * raw * nearest_query(self.scale(raw_features(situation, scene))),
            2.0 * start * nearest_query(ends.start),
            [1.0],
            2.0 * place * ends.places.ravel(),
            2.0 * axis * ends.axes.ravel(),
            far,
        )
        return np.concatenate(parts).astype(np.float32)

    def embed_memories(
        self, situations: Sequence[Any], trajectories: Sequence[Waypoints]
    ) -> np.ndarray:
        """Embeddings of memories."""
        rows = [self._row(s, w) for s, w in zip(situations, trajectories, strict=True)]
        return np.array(rows, np.float32).reshape(-1, self.dim)

    def _row(self, situation: Any, waypoints: Waypoints) -> np.ndarray:
        """Return the embedding (dim,) of a memory."""
        scene, signs = pack(situation), signs_of(situation)
        heading = heading_of(scene.limb, scene)
        end = waypoints.knots[-1, :TIME].astype(float)
        mirror = np.array([1.0, signs.min(), 1.0])
        axis = heading.rows @ axis_at(scene.limb, end * signs + heading.shift) * mirror
        goal = waypoints.goal[:3].astype(float)
        goal *= min(1.0, FAR / max(float(np.linalg.norm(goal)), 1e-12))
        speeds = np.array(situation.arm.max_joint_speed) * situation.horizon
        share = waypoints.catch_time / situation.horizon * INSTANTS - 1.0
        near = np.maximum(0.0, 1.0 - np.abs(np.arange(INSTANTS) - max(share, 0.0)))
        parts = (
            nearest_rows(self.scale(raw_features(situation, scene)[None]))[0],
            nearest_rows(waypoints.knots[:1, :TIME] / speeds)[0],
            [-self.parts[2] * float(goal @ goal)],
            np.outer(near, goal).ravel(),
            np.outer(near, axis).ravel(),
            near,
        )
        return np.concatenate(parts)
