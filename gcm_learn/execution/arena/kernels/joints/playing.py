"""Steps and observations of many arms that move in their joints."""

from __future__ import annotations

from typing import Any, NamedTuple

from gcm_learn.arms.limbs import hand_of, place
from gcm_learn.compiled import njit
from gcm_learn.execution.arena.kernels.joints.chains import ChainWorld
from gcm_learn.execution.arena.kernels.joints.meeting import way_to_go
from gcm_learn.execution.arena.kernels.joints.observation import observe
from gcm_learn.execution.arena.kernels.joints.scene import view_in, views_for
from gcm_learn.execution.arena.kernels.joints.stepping import step
from gcm_learn.execution.arena.kernels.world import Options, State, Told, World, pay


class JointKernels(NamedTuple):
    """Kernels of many arms that move in their joints."""

    observe: Any
    play: Any
    ways_to_go: Any


def kernels_in(world_type: type[World]) -> JointKernels:
    """Return the kernels of many arms in a type of world.

    Worlds come as plain tuples, so that a call is quick; the type chooses the kernels of limbs.
    """

    @njit(nogil=True)
    def observe_all(world, state, chosen, options, out):
        """Write the observations of the arms `chosen` (k,) into their rows of `out`."""
        worlds, states, how = world_type(*world), State(*state), Options(*options)
        room = views_for(worlds, states, 0, states.place.size)
        for k in range(chosen.size):
            e = chosen[k]
            view = view_in(worlds, states, e, room)
            observe(view, states.time[e], states.posture, e, how, out[e])
            hand = hand_of(view.scene.limb, place(view.scene.limb, view.joints[0]))
            states.hand[e, 0], states.hand[e, 1], states.hand[e, 2] = hand

    @njit(nogil=True)
    def play(world, state, actions, options, told, first, last):
        """Make a step of arms first to last - 1, and observe."""
        worlds, states, how, out = world_type(*world), State(*state), Options(*options), Told(*told)
        room = views_for(worlds, states, first, last)
        for e in range(first, last):
            view = step(worlds, states, e, actions, how, out, room)
            row = out.observations[e]
            observe(view, states.time[e], states.posture, e, how, row)

    @njit(nogil=True)
    def ways_to_go(world, state, out):
        """Write the guide's potential of every arm."""
        worlds, states = world_type(*world), State(*state)
        room = views_for(worlds, states, 0, states.place.size)
        for e in range(states.place.size):
            view = view_in(worlds, states, e, room)
            out[e] = way_to_go(view, states.time[e], states.posture, e)

    return JointKernels(observe_all, play, ways_to_go)


SPATIAL_KERNELS = kernels_in(World)
CHAIN_KERNELS = kernels_in(ChainWorld)


@njit(nogil=True)
def settle(told, catches, weights, shares, nearer):
    """Pay every arm for a step that a plant with mass made.

    Parameters
    ----------
    told : Told
        As a plain tuple, with the outcomes.
    catches : (e,) ndarray
        Of the step, as shares of those that end the episodes.
    weights : (4,) ndarray
    shares : (e,) ndarray
        Of the horizons that the step took.
    nearer : (e,) ndarray
        See `pay`.
    """
    out = Told(*told)
    for e in range(shares.size):
        pay(out, e, out.outcomes[e], catches[e], shares[e], weights, nearer[e])
