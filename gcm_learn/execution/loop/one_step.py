"""Observation of a spatial arm at t = 0 of a situation, and its posture after a command.

The situation may be a belief, in which the limb touches something: nothing is judged here.
"""

from __future__ import annotations

import numpy as np

from gcm_learn.arms import SpatialArm
from gcm_learn.compiled import njit
from gcm_learn.execution.arena.kernels.joints.playing import observe_all
from gcm_learn.execution.arena.kernels.joints.scene import view_in, views_for
from gcm_learn.execution.arena.kernels.joints.stepping import reach_out
from gcm_learn.execution.arena.kernels.world import Options, State, World, world_of
from gcm_learn.execution.arena.settings import ArenaSettings
from gcm_learn.motion import fastest_hand, opening
from gcm_learn.scene import pack
from gcm_learn.situation import Situation


class OneStep:
    """The first step of an arm in space.

    Parameters
    ----------
    situation : Situation
    settings : ArenaSettings
    """

    def __init__(self, situation: Situation[SpatialArm], settings: ArenaSettings) -> None:
        scene = pack(situation)
        posture = np.concatenate([scene.limb.start, scene.limb.rates])[None]
        state = State(np.zeros(1, np.int64), posture, np.zeros((1, 3)), np.zeros(1))
        world = world_of([scene], [opening(scene).rules], [fastest_hand(scene)])
        self.told = np.zeros((1, settings.width), np.float32)
        """As `envs.CatchArm3D` lists it (1, width)."""
        self.posture = posture[0]
        """Joints [rad] and their rates [rad/s] (2 dof,)."""
        self._world, self._arm = tuple(world), state
        self._options = settings.options
        observe_all(self._world, tuple(state), np.zeros(1, np.int64), self._options, self.told)

    def after(self, command: np.ndarray) -> np.ndarray:
        """Posture (2 dof,) after the step, as near to a command (dof,) as the limits allow."""
        out = np.empty(self.posture.size)
        _after(self._world, tuple(self._arm), command[None].astype(float), self._options, out)
        return out


@njit
def _after(world, state, command, options, out):
    """Write the posture (2 dof,) after a step of the only arm."""
    worlds, states, how = World(*world), State(*state), Options(*options)
    view = view_in(worlds, 0, views_for(worlds, states, 0, 1))
    end, speed, n = view.joints[0], view.rules.speed, view.joints.shape[1]
    reach_out(view.scene, speed, states.posture, 0, command, how.dt, end, view)
    out[:n], out[n:] = end, view.rates[0]
