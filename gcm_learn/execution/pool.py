"""Situations in which episodes begin, packed for kernels."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from gcm_learn.arms import SpatialArm
from gcm_learn.errors import ArenaError
from gcm_learn.execution.settings import Settings, SpatialSettings
from gcm_learn.execution.space.stepping import can_stop
from gcm_learn.execution.space.world import SpatialWorld, spatial_world_of
from gcm_learn.execution.world import World, world_of
from gcm_learn.motion import HOLE_MARGIN, Rules, opening
from gcm_learn.scene import Limits, Scene, pack
from gcm_learn.situation import Frame, Situation, canonical, planar, spatial

_SPEED = Limits._fields.index("speed")
HUB = 0.015  # distance that hands keep from the shoulder, where joints jump [forearm lengths]


@dataclass(frozen=True)
class Pool:
    """Situations in which episodes begin."""

    situations: tuple[Situation, ...]
    """In their canonical form: the hand on the positive x axis, the elbow on the right."""
    frames: tuple[Frame, ...]
    """How each of them was drawn."""
    world: World
    embeddings: np.ndarray
    """Of the situations (s, dim) float32; dim is 0 where nobody asked for them."""

    def __len__(self) -> int:
        return len(self.situations)

    @property
    def speed(self) -> np.ndarray:
        """Greatest speeds of the hands (s,) [forearms/s]."""
        return self.world.limits[:, _SPEED]

    @classmethod
    def of(cls, situations: Sequence[Situation]) -> Pool:
        """Pack situations; each must begin with a limb that touches nothing.

        Raises
        ------
        ArenaError
            With the name of the first that does not.
        """
        _some(situations)
        turned = [canonical(planar(situation, "the arena")) for situation in situations]
        scenes = [pack(situation) for situation, _ in turned]
        rules = [_rules_of(scene, s.name) for scene, (s, _) in zip(scenes, turned, strict=True)]
        world = world_of([_outside_hole(scene) for scene in scenes], rules)
        none = np.zeros((len(turned), 0), np.float32)
        return cls(tuple(s for s, _ in turned), tuple(f for _, f in turned), world, none)

    def prepared(self, settings: Settings) -> Pool:
        """The same situations with what settings ask for: maps' times to go, embeddings."""
        made = self
        if settings.weights.guide != 0.0 and not len(self.world.fields):
            from gcm_learn.execution.guidance import fields_of

            made = made.guided(fields_of(self.situations))
        if settings.embedding and not self.embeddings.shape[1]:
            from gcm_learn.execution.embedding import embeddings_of

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


@dataclass(frozen=True)
class SpatialPool:
    """Situations in space in which episodes begin."""

    situations: tuple[Situation[SpatialArm], ...]
    """As they were given."""
    world: SpatialWorld

    def __len__(self) -> int:
        return len(self.situations)

    @classmethod
    def of(cls, situations: Sequence[Situation[SpatialArm]]) -> SpatialPool:
        """Pack situations; each must begin with a limb that touches nothing.

        Raises
        ------
        ArenaError
            With the name of the first that does not.
        """
        _some(situations)
        scenes = [pack(spatial(situation, "the arena in space")) for situation in situations]
        named = zip(scenes, situations, strict=True)
        rules = [_rules_of(scene, situation.name) for scene, situation in named]
        return cls(tuple(situations), spatial_world_of(scenes, rules))

    def prepared(self, settings: SpatialSettings) -> SpatialPool:
        """The same; refuses what is too fast at t = 0 to be stopped in steps as long as these."""
        for situation in self.situations:
            if not stops(situation, settings.dt):
                name, dt = situation.name, settings.dt
                raise ArenaError(f"situation {name!r}: the arm cannot stop in steps of {dt} s")
        return self

    def part(self, chosen: Sequence[int] | np.ndarray) -> SpatialPool:
        """Some of the situations, packed anew."""
        return SpatialPool.of([self.situations[int(i)] for i in chosen])


def stops(situation: Situation[SpatialArm], dt: float) -> bool:
    """Whether an arm keeps its limits if it brakes from t = 0 on, in steps of `dt` [s]."""
    if situation.arm.joint_rates is None or not any(situation.arm.joint_rates):
        return True
    scene = pack(situation)
    return can_stop(scene, opening(scene).rules.speed, dt)


def _some(situations: Sequence[object]) -> None:
    if not situations:
        raise ArenaError("situations: there is none")


def _rules_of(scene: Scene, name: str) -> Rules:
    """The rules of a scene; refuses one in which the limb touches something at t = 0."""
    opened = opening(scene)
    if opened.clearance <= 0.0:
        raise ArenaError(f"situation {name!r}: the limb touches an obstacle at t = 0")
    return opened.rules


def _outside_hole(scene: Scene) -> Scene:
    """The same scene with a ring that also keeps hands from the shoulder."""
    near = max(scene.limb.near + HOLE_MARGIN, HUB)
    return scene._replace(limb=scene.limb._replace(near=near))
