"""Limbs at rest among moving bodies: until when, and in which spans of time, they are free."""

from __future__ import annotations

from gcm_learn.arms.limbs import place, self_gap, still
from gcm_learn.collision.postures import gap_to
from gcm_learn.compiled import njit
from gcm_learn.scene.bodies import TOP_SPEED


@njit(_nrt=False)
def state_at(scene, where, t, touch, desk):
    """Return whether a resting limb is free at t [s], and for how long that surely stays so.

    Parameters
    ----------
    where : place of the limb
    """
    limb, bodies = scene.limb, scene.bodies
    blocked, apart, together = False, 1e300, 0.0
    slack = still(limb)
    if self_gap(limb, where, slack, touch)[0] <= touch:
        return False, 1e300
    for k in range(desk.obstacles.size):
        b = desk.obstacles[k]
        speed = bodies.rows[b, TOP_SPEED]
        far = touch + speed * min(apart, 1e200)
        found, _ = gap_to(limb, where, slack, bodies, b, t, 0.0, far, desk.poses)
        if found > touch:
            if speed > 0.0:
                apart = min(apart, (found - touch) / speed)
            continue
        blocked = True
        if touch > found:
            together = max(together, (touch - found) / speed if speed > 0.0 else 1e300)
    return not blocked, together if blocked else apart


@njit(_nrt=False)
def free_until(scene, q, since, until, touch, shortest, desk):
    """Until when a limb may rest at joints q (n,), from `since` on.

    Conservative advancement, with steps of at least `shortest` [s].

    Returns
    -------
    float
        `until` if it is not touched before [s]; `since` if it is touched then.
    """
    where, t, safe = place(scene.limb, q), since, since
    while t < until:
        free, stays = state_at(scene, where, t, touch, desk)
        if not free:
            return safe
        safe = t + stays
        t += max(stays, shortest)
    return until
