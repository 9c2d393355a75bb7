"""Roots of the second tree: postures that catch, or whole ends of movements."""

from __future__ import annotations

from gcm_learn.arms.limbs import hand_bound
from gcm_learn.compiled import by_type, njit
from gcm_learn.planners.joints.endings import FIRST, UNPULLED, Endings, ended
from gcm_learn.planners.joints.pull import pulled
from gcm_learn.planners.joints.ramps import GIVEN
from gcm_learn.planners.joints.tree_goals import (
    NEAR_GOAL,
    any_target,
    draw_goal,
    draw_near,
    draw_near_start,
)
from gcm_learn.planners.joints.tree_moves import FROM_CATCH
from gcm_learn.planners.joints.trees import add_node, uniform
from gcm_learn.scene import bodies

LATE = 1.0 / 3.5  # instants are drawn as this power of a uniform number: later ones more often
SLOW = 0.25  # speed of a target that halves its chance, in that of the fastest hand
BIAS = 0.3  # see `bias_by`
DRAWS = 8  # of instants until a target is slow enough


@njit(_nrt=False)
def _instant(study, trees, ends, horizon):
    """Draw a target and an instant, preferring late instants and slow targets."""
    laws, limits = study.scene.bodies, study.scene.limits
    slow = SLOW * hand_bound(study.scene.limb, limits.joint_speed)
    for _ in range(DRAWS):
        b, t = any_target(study, trees), horizon * (1.0 - uniform(trees)) ** LATE
        bodies.pose_at(laws, b, t, ends.work.poses)
        place = ends.work.poses[b, 0], ends.work.poses[b, 1], ends.work.poses[b, 2]
        p = bodies.piece_at(laws, b, t) if laws.rows[b, bodies.PIECES] > 0.0 else 0
        vx, vy, vz = bodies.velocity_by(laws, b, p, t, place)
        if uniform(trees) * (1.0 + (vx * vx + vy * vy + vz * vz) / (slow * slow)) <= 1.0:
            break
    return b, t


@njit(_nrt=False)
def draw_end(ends, study, trees, horizon):
    """Draw an end of a movement; see `draw_goal`."""
    count = ends.made[0]
    if count == ends.body.size:
        return -1
    if count > 0 and uniform(trees) < NEAR_GOAL:
        k = int(uniform(trees) * count)
        b = ends.body[k]
        t = draw_near(study, trees, ends.joints[k, FIRST], ends.span[k, 0], horizon)
    else:
        b, t = _instant(study, trees, ends, horizon)
        draw_near_start(study, trees, b, t)
    return end_at(ends, study, trees, b, t)


@njit(_nrt=False)
def end_at(ends, study, trees, b, t):
    """Pull the drawn posture to target b, caught at t [s], and add the movement's end as a root.

    Returns
    -------
    int
        Number of the root, -1 without one.
    """
    held = study.scene.bodies.rows[b, bodies.HOLD] >= 0.0
    when = t - ends.half if held else t
    if when <= 0.0 or not pulled(ends.aim, b, when, trees.drawn):
        ends.why[UNPULLED] += 1
        return -1
    e = ended(study, trees, ends, b, t)
    if e < 0:
        return -1
    first = ends.first[e]
    t = ends.time[e, first]
    trees.ends[0] = trees.ends[1] = t
    return add_node(trees, FROM_CATCH, ends.joints[e, first], ends.rates[e, first], t, GIVEN, -1, e)


@njit(_nrt=False, forceinline=True)
def _draw_touch(ends, study, trees, horizon):
    return draw_goal(study, trees, horizon)


draw_by = by_type({None: _draw_touch, Endings: draw_end})
"""Draw a root, by what is to be done at the end; see `draw_goal`."""


@njit(_nrt=False, forceinline=True)
def _no_bias(ends):
    return 0.0


@njit(_nrt=False, forceinline=True)
def _bias(ends):
    return BIAS


bias_by = by_type({None: _no_bias, Endings: _bias})
"""Share of states to which trees grow that are drawn from the other tree."""
