"""Functions that differ between limbs in the arena, chosen by the type of their first argument.

The one table of this folder; `spatial` and `chains` hold the kernels.
"""

from __future__ import annotations

from gcm_learn.arms import ChainLimb, SpatialLimb
from gcm_learn.compiled import by_type
from gcm_learn.execution.arena.kernels.joints import chains, spatial
from gcm_learn.execution.arena.kernels.joints.chains import ChainWorld
from gcm_learn.execution.arena.kernels.world import World

blank = by_type({World: spatial.blank, ChainWorld: chains.blank})
"""Limb with arrays for any situation of a world."""

limb_in = by_type({SpatialLimb: spatial.limb_in, ChainLimb: chains.limb_in})
"""Limb of situation s: (limb, world, s). Arrays of the given limb may be overwritten."""

buffers = by_type({SpatialLimb: spatial.buffers, ChainLimb: chains.buffers})
"""Buffers that only limbs of the type need: (limb,)."""

beside = by_type({SpatialLimb: spatial.beside, ChainLimb: chains.beside})
"""Limb that can be placed without moving the first one: (limb, buffers, k), k being 0 or 1."""

gap_of = by_type({SpatialLimb: spatial.gap_of, ChainLimb: chains.gap_of})
"""Distance of body b at t [s] to a limb at a place: (limb, place, bodies, b, t, enough, poses).

Above `enough` it may be that of the ball that holds the body.
"""

shape_numbers = by_type({SpatialLimb: spatial.shape_numbers, ChainLimb: chains.shape_numbers})
"""Count of the numbers that `tell_shape` writes: (limb,)."""

tell_shape = by_type({SpatialLimb: spatial.tell_shape, ChainLimb: chains.tell_shape})
"""Write the places of the links: (limb, place, reach, row, at)."""

size_numbers = by_type({SpatialLimb: spatial.size_numbers, ChainLimb: chains.size_numbers})
"""Count of the numbers that `tell_sizes` writes: (limb,)."""

tell_sizes = by_type({SpatialLimb: spatial.tell_sizes, ChainLimb: chains.tell_sizes})
"""Write the sizes of the links: (limb, place, touch, reach, row, at)."""

approach_numbers = by_type(
    {SpatialLimb: spatial.approach_numbers, ChainLimb: chains.approach_numbers}
)
"""Count of the numbers that `tell_approach` writes: (limb,)."""

tell_approach = by_type({SpatialLimb: spatial.tell_approach, ChainLimb: chains.tell_approach})
"""Write the direction from which a target is caught: (limb, place, scene, b, t, poses, row, at)."""

nearest_point = by_type({SpatialLimb: spatial.nearest_point, ChainLimb: chains.nearest_point})
"""Point on a link's axis that is nearest to body b at its pose: (limb, place, bodies, b, poses).

Returns
-------
i : int
    The link.
px, py, pz : float
    The point.
x, y, z : float
    From there to the nearest point of the body; 0 where they meet.
radius : float
    Of the link, beyond the limb's thickness.
"""

point_velocity_on = by_type(
    {SpatialLimb: spatial.point_velocity_on, ChainLimb: chains.point_velocity_on}
)
"""Velocity (3) of a point of link i: (limb, place, i, joints, rates, x, y, z)."""

brakes_slowly = by_type({SpatialLimb: spatial.brakes_slowly, ChainLimb: chains.brakes_slowly})
"""Return whether the hand keeps its speed while the joints brake after a step.

Takes (limb, scene, speed, end, rates, span, buffers). Joints and rates (dof,) are those after the
step.
"""

tell_fan = by_type({SpatialLimb: spatial.tell_fan, ChainLimb: chains.tell_fan})
"""Write the fan: (limb, view, time, posture, e, body, place, aim, row, at)."""
