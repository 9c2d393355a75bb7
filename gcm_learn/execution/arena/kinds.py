"""The table of kinematic arms: kernels and layouts of each kind."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from gcm_learn.arms import CHAIN, PLANAR, SPATIAL, ByKind, Chain, ChainModel, limb_of_chain
from gcm_learn.errors import ArenaError
from gcm_learn.execution.arena.kernels.hands import (
    observation as hand_observation,
    scene as hand_scene,
)
from gcm_learn.execution.arena.kernels.hands.nearness import RAY, RAYS
from gcm_learn.execution.arena.kernels.hands.stepping import observe_all, play
from gcm_learn.execution.arena.kernels.joints import (
    chains,
    fan as joint_fan,
    observation as joint_observation,
    scene as joint_scene,
)
from gcm_learn.execution.arena.kernels.world import State, World, fields_in_rows
from gcm_learn.motion import HOLE_MARGIN, fastest_hand
from gcm_learn.scene import Scene
from gcm_learn.situation import AnySituation, canonical

HUB = 0.015  # distance that hands keep from the shoulder, where joints jump [forearm lengths]


class Layout(NamedTuple):
    """Counts of the numbers of actions and observations."""

    commands: int
    """Of an action."""
    arm: int
    target: int
    obstacle: int
    """Of each slot."""
    fan: int
    straight: int
    """Index of the direction, or of the command, that leads straight to the target."""


class AsDrawn:
    """Frame of a situation that the arena does not transform."""

    def original(self, points: np.ndarray) -> np.ndarray:
        """Return the points."""
        return points


@dataclass(frozen=True)
class Kernels:
    """Kernels and layout that a kinematic plant needs of a kind of arm."""

    layout: Callable[[Any], Layout]
    """Layout of arms of a model; None where all arms of the kind are alike."""
    rows: Callable[[Sequence[Scene]], np.ndarray]
    """Rows of a world's limbs."""
    starts: Callable[[World], np.ndarray]
    """Postures at t = 0 (s, k) of a world."""
    horizon: int
    """Column of a world's limits."""
    state: Callable[[int, int], State]
    """State of so many arms, all zero: (count, commands)."""
    check: Callable[[Sequence[AnySituation]], None]
    """Refuse situations that cannot stand side by side, or not at all."""
    placed: Callable[[Any], tuple[AnySituation, Any]]
    """Situation in the form of the arena, and the frame in which it was drawn."""
    bounded: Callable[[Scene], Scene]
    """Scene with the limits that steps keep."""
    pace: Callable[[Scene], float]
    """Fastest that a hand can be [lengths/s]."""
    observe: Callable[..., None]
    """Write observations: (world, state, chosen, options, out)."""
    play: Callable[..., None]
    """Make a step: (world, state, actions, options, results, first, last)."""
    ways_to_go: Any = None
    """Write the guide's potential of every arm: (world, state, out); absent for arms of hands."""


def _hands(count: int, commands: int) -> State:
    hand = np.zeros((count, 2))
    return State(np.zeros(count, np.int64), hand, hand, np.zeros(count), np.full((count, 1), -1.0))


def _joints(count: int, commands: int) -> State:
    posture, hand = np.zeros((count, 2 * commands)), np.zeros((count, 3))
    caught = np.full((count, 1), -1.0)  # as wide as a pool needs, see `Batch.put`
    return State(np.zeros(count, np.int64), posture, hand, np.zeros(count), caught)


_PLANAR_LAYOUT = Layout(
    2, hand_observation.ARM, hand_observation.TARGET, hand_observation.OBSTACLE,
    RAYS * RAY, hand_observation.MEETING,
)  # fmt: skip
_SPATIAL_LAYOUT = Layout(
    joint_fan.COMMAND, joint_observation.ARM, joint_observation.TARGET, joint_observation.OBSTACLE,
    joint_fan.FRAME + joint_fan.COMMANDS * joint_fan.RAY, joint_observation.AIM,
)  # fmt: skip


def _chain_layout(model: ChainModel) -> Layout:
    """Layout of chains of a model, which have no fan; counted by the kernels."""
    limb = limb_of_chain(Chain(model, tuple(low for low, _ in model.ranges), 0.0))
    arm, target = joint_observation.arm_numbers(limb), joint_observation.target_numbers(limb)
    straight = arm + joint_observation.UNTIL_AIM
    return Layout(model.dof, arm, target, joint_observation.OBSTACLE, 0, straight)


def _alike(situations: Sequence[AnySituation]) -> None:
    """Refuse branched or coupled chains, and chains with other sizes than the first."""
    first: Any = situations[0].arm
    for situation in situations:
        model = situation.arm.model  # type: ignore[union-attr]
        if not model.serial:
            reason = "its arm has branches or followers, which arenas do not take"
            raise ArenaError(f"situation {situation.name!r}: {reason}")
        found, wanted = sizes_of(model), sizes_of(first.model)
        if found != wanted:
            reason = f"its arm has {found}, that of {situations[0].name!r} {wanted}"
            raise ArenaError(f"situation {situation.name!r}: {reason}")


def sizes_of(model: ChainModel) -> str:
    """Return the counts of joints and links that determine the observations of a chain."""
    return f"{model.dof} joints and {len(model.links)} links"


def _pace_of_chain(scene: Scene) -> float:
    """Unit of speeds: the hand's limit, or the root of the sum of squares of each joint's part."""
    parts = scene.limits.joint_speed * scene.limb.tails
    return min(float(np.linalg.norm(parts)), scene.limits.speed)


def _outside_hole(scene: Scene) -> Scene:
    """Return the same scene with a ring that also keeps hands from the shoulder."""
    near = max(scene.limb.near + HOLE_MARGIN, HUB)
    return scene._replace(limb=scene.limb._replace(near=near))


_SPATIAL = Kernels(
    layout=lambda model: _SPATIAL_LAYOUT,
    rows=chains.rows_of,
    starts=chains.starts_of,
    horizon=joint_scene.HORIZON,
    state=_joints,
    check=lambda situations: None,
    placed=lambda situation: (situation, AsDrawn()),
    bounded=lambda scene: scene,
    pace=fastest_hand,
    observe=joint_observation.observe_all,
    play=joint_observation.play,
    ways_to_go=joint_observation.ways_to_go,
)
KERNELS = ByKind(
    {
        PLANAR: Kernels(
            layout=lambda model: _PLANAR_LAYOUT,
            rows=fields_in_rows,
            starts=lambda world: world.limbs[:, hand_scene.START],
            horizon=hand_scene.HORIZON,
            state=_hands,
            check=lambda situations: None,
            placed=canonical,
            bounded=_outside_hole,
            pace=lambda scene: scene.limits.speed,
            observe=observe_all,
            play=play,
        ),
        SPATIAL: _SPATIAL,
        CHAIN: replace(_SPATIAL, layout=_chain_layout, check=_alike, pace=_pace_of_chain),
    },
    who="the arena",
)
"""By kind of arm."""
