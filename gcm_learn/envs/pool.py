"""Situations packed for the kernels of the arena."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from gcm_learn.envs import kernels as k
from gcm_learn.envs.settings import Settings
from gcm_learn.errors import ArenaError
from gcm_learn.motion.rules import opening
from gcm_learn.motion.verification import HOLE_MARGIN
from gcm_learn.planners.completion import CATCH_STEP
from gcm_learn.recall import own_axis
from gcm_learn.scene.bodies import FIRST, LAST, SWING, Bodies
from gcm_learn.scene.packing import pack
from gcm_learn.scene.scene import Scene
from gcm_learn.situation import Situation
from gcm_learn.situation.canonical import Frame, canonical

HUB = 0.015  # distance that hands keep from the shoulder, where joints jump [forearm lengths]


@dataclass(frozen=True)
class Pool:
    """Situations in which episodes begin."""

    situations: tuple[Situation, ...]
    """In their canonical form: the hand on the positive x axis, the elbow on the right."""
    frames: tuple[Frame, ...]
    """How each of them was drawn."""
    world: k.World
    embeddings: np.ndarray
    """Of the situations (s, dim) float32; dim is 0 where nobody asked for them."""

    def __len__(self) -> int:
        return len(self.situations)

    @classmethod
    def of(cls, situations: Sequence[Situation]) -> Pool:
        """Pack situations; each must begin with a limb that touches nothing.

        Raises
        ------
        ArenaError
            With the name of the first that does not.
        """
        if not situations:
            raise ArenaError("situations: there is none")
        turned = [canonical(situation) for situation in situations]
        packed = [pack(situation) for situation, _ in turned]
        arms = np.array([_arm_row(s, b) for (s, _), b in zip(turned, packed, strict=True)])
        world = _joined([scene.bodies for scene in packed], arms)
        none = np.zeros((len(turned), 0), np.float32)
        return cls(tuple(s for s, _ in turned), tuple(f for _, f in turned), world, none)

    def prepared(self, settings: Settings) -> Pool:
        """The same situations with what settings ask for: maps' times to go, embeddings."""
        made = self
        if settings.weights.guide != 0.0 and not len(self.world.fields):
            from gcm_learn.envs.guidance import fields_of

            made = made.guided(fields_of(self.situations))
        if settings.embedding and not self.embeddings.shape[1]:
            from gcm_learn.envs.views import embeddings_of

            made = replace(made, embeddings=embeddings_of(self.situations))
        return made

    def guided(self, fields: np.ndarray) -> Pool:
        """The same situations with times to go (s, n, n); see `guidance.fields_of`."""
        return replace(self, world=self.world._replace(fields=fields.astype(np.float32)))

    def part(self, chosen: Sequence[int] | np.ndarray) -> Pool:
        """Some of the situations, packed anew; times to go and embeddings come with them."""
        rows = [int(i) for i in chosen]
        made = Pool.of([self.situations[i] for i in rows])
        frames = tuple(self.frames[i] for i in rows)
        if len(self.world.fields):
            made = made.guided(self.world.fields[rows])
        return replace(made, frames=frames, embeddings=self.embeddings[rows])


def _arm_row(situation: Situation, scene: Scene) -> np.ndarray:
    """The arm of a canonical situation as a row."""
    arm = situation.arm
    free, rules = opening(scene)
    if free <= 0.0:
        raise ArenaError(f"situation {situation.name!r}: the limb touches an obstacle at t = 0")
    row = np.zeros(k.ARM_COLUMNS)
    row[k.RHO], row[k.SPEED], row[k.THICKNESS] = arm.upper_arm, arm.max_hand_speed, arm.thickness
    row[k.FLOOR] = rules.touch
    row[k.GRASP], row[k.HORIZON] = rules.catch, situation.horizon
    row[k.NEAR] = max(arm.inner_reach + HOLE_MARGIN, HUB)
    row[k.FAR], row[k.START] = arm.reach, arm.hand[0]
    row[k.INSTANT] = CATCH_STEP * rules.instant  # as plans are ended
    row[k.ANGLE_STEP] = scene.bodies.angle_step
    if arm.max_joint_speed is not None:
        row[k.TURN_1], row[k.TURN_2] = arm.max_joint_speed
    return row


def _joined(packed: Sequence[Bodies], arms: np.ndarray) -> k.World:
    """All bodies in one set of arrays; indices into vertices and swings move along."""
    longest = max(b.angles.shape[1] for b in packed)
    angles = np.zeros((sum(len(b.angles) for b in packed), longest, 2))
    rows, vertices, first = [], [], [0]
    corners, swings = 0, 0
    for bodies in packed:
        row = np.zeros((len(bodies.rows), k.ROW_COLUMNS))
        row[:, : k.LONG] = bodies.rows
        for b in range(len(row)):
            row[b, k.LONG : k.LONG + 3] = own_axis(bodies, b)
        row[:, [FIRST, LAST]] += corners
        row[row[:, SWING] >= 0.0, SWING] += swings
        angles[swings : swings + len(bodies.angles), : bodies.angles.shape[1]] = bodies.angles
        rows.append(row)
        vertices.append(bodies.vertices)
        corners, swings = corners + len(bodies.vertices), swings + len(bodies.angles)
        first.append(first[-1] + len(row))
    return k.World(
        rows=np.vstack(rows),
        vertices=np.vstack(vertices),
        angles=angles,
        first=np.array(first),
        arms=arms,
        fields=np.zeros((0, 2, 2), dtype=np.float32),
    )
