"""Steps and observations of many planar arms."""

from __future__ import annotations

from gcm_learn.compiled import njit
from gcm_learn.execution.arena.kernels.hands.observation import observe
from gcm_learn.execution.arena.kernels.hands.scene import workspace_for
from gcm_learn.execution.arena.kernels.hands.stepping import step
from gcm_learn.execution.arena.kernels.world import Options, State, Told, World


@njit(nogil=True)
def observe_all(world, state, chosen, options, out):
    """Write the observations of the arms `chosen` (k,) into their rows of `out`."""
    worlds, states, how = World(*world), State(*state), Options(*options)
    workspace = workspace_for(worlds, states, 0, states.place.size)
    for k in range(chosen.size):
        observe(worlds, states, chosen[k], how, out, workspace)


@njit(nogil=True)
def play(world, state, actions, options, told, first, last):
    """Make a step of arms first to last - 1, and observe."""
    worlds, states, how, out = World(*world), State(*state), Options(*options), Told(*told)
    workspace = workspace_for(worlds, states, first, last)
    for e in range(first, last):
        step(worlds, states, e, actions, how, out, workspace)
        observe(worlds, states, e, how, out.observations, workspace)
