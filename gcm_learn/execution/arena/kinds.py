"""The table of kinematic arms: kernels and layouts of each kind."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from gcm_learn.arms import PLANAR, SPATIAL, ByKind
from gcm_learn.execution.arena.kernels.hands import fan as hand_fan
from gcm_learn.execution.arena.kernels.hands import observation as hand_observation
from gcm_learn.execution.arena.kernels.hands import playing as hand_playing
from gcm_learn.execution.arena.kernels.hands import scene as hand_scene
from gcm_learn.execution.arena.kernels.joints import fan as joint_fan
from gcm_learn.execution.arena.kernels.joints import observation as joint_observation
from gcm_learn.execution.arena.kernels.joints import playing as joint_playing
from gcm_learn.execution.arena.kernels.joints import scene as joint_scene
from gcm_learn.execution.arena.kernels.world import State
from gcm_learn.motion import HOLE_MARGIN, fastest_hand
from gcm_learn.scene import Scene
from gcm_learn.situation import AnySituation, canonical

HUB = 0.015  # distance that hands keep from the shoulder, where joints jump [forearm lengths]


class Layout(NamedTuple):
    """Numbers of an observation."""

    arm: int
    target: int
    obstacle: int
    """Of each slot."""
    fan: int
    straight: int
    """Index of the direction, or of the command, that leads straight to the target."""


class AsDrawn:
    """The frame of a situation that an arena leaves as it was drawn."""

    def original(self, points: np.ndarray) -> np.ndarray:
        """Return the points."""
        return points


@dataclass(frozen=True)
class Kernels:
    """Kernels and layout that a kinematic plant needs of a kind of arm."""

    commands: int
    """Numbers of a command."""
    layout: Layout
    start: slice
    """Columns of a world's limbs with the posture at t = 0."""
    horizon: int
    """Column of a world's limits."""
    state: Callable[[int], State]
    """State of so many arms, all zero."""
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


def _hands(count: int) -> State:
    hand = np.zeros((count, 2))
    return State(np.zeros(count, np.int64), hand, hand, np.zeros(count))


def _joints(count: int) -> State:
    posture, hand = np.zeros((count, 2 * joint_fan.COMMAND)), np.zeros((count, 3))
    return State(np.zeros(count, np.int64), posture, hand, np.zeros(count))


def _outside_hole(scene: Scene) -> Scene:
    """Return the same scene with a ring that also keeps hands from the shoulder."""
    near = max(scene.limb.near + HOLE_MARGIN, HUB)
    return scene._replace(limb=scene.limb._replace(near=near))


KERNELS = ByKind(
    {
        PLANAR: Kernels(
            commands=2,
            layout=Layout(
                hand_observation.ARM, hand_observation.TARGET, hand_observation.OBSTACLE,
                hand_fan.RAYS * hand_fan.RAY, hand_observation.MEETING,
            ),
            start=hand_scene.START,
            horizon=hand_scene.HORIZON,
            state=_hands,
            placed=canonical,
            bounded=_outside_hole,
            pace=lambda scene: scene.limits.speed,
            observe=hand_playing.observe_all,
            play=hand_playing.play,
        ),
        SPATIAL: Kernels(
            commands=joint_fan.COMMAND,
            layout=Layout(
                joint_observation.ARM, joint_observation.TARGET, joint_observation.OBSTACLE,
                joint_fan.FRAME + joint_fan.COMMANDS * joint_fan.RAY, joint_observation.AIM,
            ),
            start=joint_scene.START,
            horizon=joint_scene.HORIZON,
            state=_joints,
            placed=lambda situation: (situation, AsDrawn()),
            bounded=lambda scene: scene,
            pace=fastest_hand,
            observe=joint_playing.observe_all,
            play=joint_playing.play,
        ),
    },
    who="the arena",
)  # fmt: skip
"""By kind of arm."""
