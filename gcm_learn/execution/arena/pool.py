"""Situations in which episodes begin, packed for kernels, and the catches that they want."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from gcm_learn.arms import Kind, check_kind, kind_of
from gcm_learn.errors import ArenaError
from gcm_learn.execution.arena.kernels.joints.stepping import can_stop
from gcm_learn.execution.arena.kernels.world import CAUGHT, LATE, World, world_of
from gcm_learn.execution.arena.kinds import KERNELS
from gcm_learn.motion import Rules, opening, why_blocked
from gcm_learn.scene import Scene, pack
from gcm_learn.situation import AnyArmBody, AnySituation


class Catch(NamedTuple):
    """A target that was caught."""

    body: str
    """Name of the target."""
    time: float
    """[s]"""


class Wanted(NamedTuple):
    """Numbers of catches that a situation asks for."""

    most: int
    """An episode is over after so many."""
    least: int
    """At the horizon so many make it a success."""

    def at_horizon(self, count: int) -> int:
        """Return the outcome of an episode that had so many catches until the horizon."""
        return CAUGHT if count >= self.least else LATE


def wanted_of(situation: AnySituation, most: int | None = None) -> Wanted:
    """Return the numbers of catches that a situation asks for.

    Parameters
    ----------
    situation : Situation
    most : int, optional
        Ends an episode that asks for "most" of its targets; by default all of them do.
    """
    count = len(situation.targets)
    if situation.catch == "any":
        return Wanted(1, 1)
    return Wanted(count, count) if situation.catch == "all" else Wanted(most or count, 1)


def without(situation: Any, caught: Iterable[Catch]) -> Any:
    """Return a situation without its caught targets; at least one target must be left."""
    names = {catch.body for catch in caught}
    if not names:
        return situation
    return replace(situation, bodies=tuple(b for b in situation.bodies if b.name not in names))


@dataclass(frozen=True)
class Pool:
    """Situations with one kind of arm in which episodes begin."""

    situations: tuple[Any, ...]
    """Planar arms in their canonical form: the hand on the positive x axis, the elbow on the
    right; other arms as they were given."""
    frames: tuple[Any, ...]
    """Frames in which they were drawn; their method `original` leads there."""
    world: World
    embeddings: np.ndarray
    """Of the situations (s, dim) float32; dim is 0 if settings have none."""
    bodies: tuple[AnyArmBody, ...] = ()
    """Of the arms, if they have mass."""

    def __len__(self) -> int:
        return len(self.situations)

    @property
    def kind(self) -> Kind:
        """Kind of the arms."""
        return kind_of(self.situations[0])

    @property
    def speed(self) -> np.ndarray:
        """Greatest speeds of the hands (s,) [lengths/s]."""
        return self.world.pace

    @property
    def horizons(self) -> np.ndarray:
        """Horizons of the situations (s,) [s]."""
        return self.world.limits[:, KERNELS.of(self.kind).horizon]

    @property
    def starts(self) -> np.ndarray:
        """Postures of the arms at t = 0 (s, k), see `State`."""
        return KERNELS.of(self.kind).starts(self.world)

    @classmethod
    def of(cls, situations: Sequence[AnySituation], kind: Kind | None = None) -> Pool:
        """Pack situations; each must begin with a limb that touches nothing.

        Parameters
        ----------
        situations : sequence of Situation
        kind : Kind, optional
            Kind of all arms; by default that of the first one.

        Raises
        ------
        ArenaError
            With the name of the first that does not.
        ArmKindError
            With the name of the first arm of another kind.
        """
        if not situations:
            raise ArenaError("situations: there is none")
        kernels = KERNELS.of(kind or situations[0])
        of_one_kind(situations, kind or kind_of(situations[0]))
        kernels.check(situations)
        turned, frames = zip(*map(kernels.placed, situations), strict=True)
        scenes = [pack(situation) for situation in turned]
        rules = [_rules_of(scene, s) for scene, s in zip(scenes, turned, strict=True)]
        pace = [kernels.pace(scene) for scene in scenes]
        wanted = [wanted_of(situation) for situation in turned]
        bounded = [kernels.bounded(scene) for scene in scenes]
        world = world_of(bounded, rules, pace, kernels.rows, wanted)
        return cls(turned, frames, world, np.zeros((len(turned), 0), np.float32))

    def guided(self, fields: np.ndarray) -> Pool:
        """Return the same situations with times to go (s, n, n); see `guidance.fields_of`."""
        return replace(self, world=self.world._replace(fields=fields.astype(np.float32)))

    @property
    def whole(self) -> Pool:
        """Pool of all situations; a `Reserve` has to draw these."""
        return self

    def at(self, index: int) -> tuple[Pool, int]:
        """Return the pool, and the index of a situation in the pool."""
        return self, index

    def part(self, chosen: Sequence[int] | np.ndarray) -> Pool:
        """Return some of the situations, packed anew; everything that is known comes with them."""
        rows = [int(i) for i in chosen]
        made = Pool.of([self.situations[i] for i in rows])
        if len(self.world.fields):
            made = made.guided(self.world.fields[rows])
        frames = tuple(self.frames[i] for i in rows)
        bodies = tuple(self.bodies[i] for i in rows) if self.bodies else ()
        return replace(made, frames=frames, embeddings=self.embeddings[rows], bodies=bodies)


def placed(situation: AnySituation) -> tuple[AnySituation, Any]:
    """Return a situation in the form of its arena, and the frame in which it was drawn."""
    return KERNELS.of(situation).placed(situation)


def of_one_kind(situations: Sequence[AnySituation], kind: Kind, who: str = "the arena") -> None:
    """Refuse situations with arms of another kind.

    Raises
    ------
    ArmKindError
        With the name of the first one.
    """
    for situation in situations:
        check_kind(situation, kind, who)


def stops(situation: AnySituation, dt: float) -> bool:
    """Return whether an arm keeps its limits if it brakes from t = 0 on, in steps of `dt` [s]."""
    if not any(getattr(situation.arm, "joint_rates", None) or ()):
        return True
    scene = pack(situation)
    return can_stop(scene, opening(scene).rules.speed, dt)


def _rules_of(scene: Scene, situation: AnySituation) -> Rules:
    """Return the rules of a scene; refuse a scene whose limb touches something at t = 0."""
    opened = opening(scene)
    if opened.clearance <= 0.0:
        raise ArenaError(f"situation {situation.name!r}: {why_blocked(situation, scene)}")
    return opened.rules
