"""Postures that catch a target, and straight moves between postures."""

from __future__ import annotations

import numpy as np

from gcm_learn.arms.limbs import hand_of, place, reach_of
from gcm_learn.compiled import njit
from gcm_learn.motion.joint_interception import target_room
from gcm_learn.planners.joints.moves import rest_is_free, time_of, timed_move_is_free
from gcm_learn.planners.joints.pull import met_from, slope_at

HALVINGS = 10  # of the time by which a catch may become earlier
CENTRE, FROM_HAND, _ = range(3)  # places of a target that the hand is put to; last from the base
PLACES = 3
RIM = 1e-6  # share of the reach that is not used


@njit(_nrt=False)
def place_on(study, b, t, which):
    """Return a place of body b at t [s], within reach: the centre, or about the nearest point.

    The nearest point of a solid lies against the slope of the distance to it.

    Returns
    -------
    x, y, z : float
    there : bool
        Whether it was within reach.
    """
    scene, poses, limb = study.scene, study.desk.poses, study.scene.limb
    x, y, z = 0.0, 0.0, 0.0
    if which == FROM_HAND:
        x, y, z = hand_of(limb, place(limb, limb.start))
    room = target_room(scene, b, x, y, z, t, poses)
    if which == CENTRE or room <= 0.0:
        x, y, z = poses[b, 0], poses[b, 1], poses[b, 2]
    else:
        nx, ny, nz = slope_at(study, b, x, y, z, t)
        x, y, z = x - room * nx, y - room * ny, z - room * nz
    away, far = np.sqrt(x * x + y * y + z * z), reach_of(limb) * (1.0 - RIM)
    if away <= far:
        return x, y, z, True
    return x * far / away, y * far / away, z * far / away, False


@njit(_nrt=False)
def reach(study, q, since, until, p, t):
    """A straight move from joints q to p (dof,), free and over at t [s].

    Parameters
    ----------
    since, until : float
        The limb is at q since then and may stay there until then [s].

    Returns
    -------
    leave, arrive : float
        When the move begins and ends; -1 if none is free [s].
    """
    took, pieces = time_of(study, q, p)
    if since + took > t:
        return -1.0, -1.0
    if timed_move_is_free(study, q, since, p, t, pieces):
        return since, t
    if t - since < 1.05 * took:
        return -1.0, -1.0
    if t - took <= until and timed_move_is_free(study, q, t - took, p, t, pieces):
        if rest_is_free(study, q, since, t - took):
            return t - took, t
    if timed_move_is_free(study, q, since, p, since + took, pieces):
        if rest_is_free(study, p, since + took, t):
            return since, since + took
    return -1.0, -1.0


@njit(_nrt=False)
def earlier(study, q, since, b, p, t):
    """Find the earliest straight move from joints q (dof,) that catches body b before t [s].

    Parameters
    ----------
    since : float
        When the limb is at q [s].
    p : (dof,) ndarray
        Joints at the end of the move; overwritten by those of the earlier move.

    Returns
    -------
    float
        End of the move; a move that ends before t begins at `since` [s].
    """
    low, goal = since, study.goal
    for _ in range(HALVINGS):
        middle = 0.5 * (low + t)
        pieces = met_from(study, q, since, b, p, middle)
        if pieces > 0 and timed_move_is_free(study, q, since, goal, middle, pieces):
            t = middle
            for j in range(q.size):
                p[j] = goal[j]
        else:
            low = middle
    return t
