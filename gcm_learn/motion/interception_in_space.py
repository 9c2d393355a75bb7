"""Where a hand in space meets targets, in the frame of the limb's base."""

from __future__ import annotations

import numpy as np

from gcm_learn.arms.spatial_limb import limb_at
from gcm_learn.collision.postures import desk_of, free_until, line, on_curve
from gcm_learn.collision.solids import room_in_pose
from gcm_learn.compiled import njit
from gcm_learn.scene import Scene
from gcm_learn.scene.bodies import HAND, PART, TOP_SPEED, pose_at

_LOOKS = 20_000  # at a resting limb, at most
_CLOSE = 1e-5  # share of the horizon too short to be told apart from now


@njit(_nrt=False)
def target_room(scene, b, x, y, z, t, poses):
    """Signed distance of the point (x, y, z) to the solid of body b at t [s].

    Parameters
    ----------
    poses : (bodies, 12) ndarray
        Row b is filled with the body's pose.
    """
    pose_at(scene.bodies, b, t, poses)
    return room_in_pose(scene.bodies, b, x, y, z, poses)


@njit(_nrt=False)
def fastest_hand(scene):
    """Bound of the hand's speed [lengths/s]: its own limit, or what the joints allow."""
    rate, limb = scene.limits.joint_speed, scene.limb
    far = limb.rho + limb.length
    turning = np.hypot(rate[0], rate[1]) * far + np.hypot(rate[2], rate[3]) * limb.length
    return min(turning, scene.limits.speed)


@njit(_nrt=False)
def met_at(scene, q, t, catch, poses):
    """First of the targets within `catch` of the hand at joints q (4,) and time t [s]; or -1."""
    _, _, _, x, y, z = limb_at(scene.limb, q)
    for b in range(scene.bodies.rows.shape[0]):
        if scene.bodies.rows[b, PART] == HAND:
            if target_room(scene, b, x, y, z, t, poses) <= catch:
                return b
    return -1


@njit
def first_meeting(scene, curve, since, until, catch, shortest, poses):
    """First moment of a move at which a target is within `catch` of the hand.

    Conservative advancement over the move in ``curve`` (4, 4), see `collision.postures`, with
    steps of at least `shortest` [s].

    Returns
    -------
    time : float
        -1 if there is none [s].
    body : int
    """
    span, t = until - since, since
    rate = np.zeros(4)
    for j in range(4):
        most = abs(curve[j, 1]) + 2.0 * abs(curve[j, 2]) + 3.0 * abs(curve[j, 3])
        rate[j] = most / span if span > 0.0 else 0.0
    limb = scene.limb
    speed = np.hypot(rate[0], rate[1]) * (limb.rho + limb.length)
    speed += np.hypot(rate[2], rate[3]) * limb.length
    while True:
        s = (t - since) / span if span > 0.0 else 1.0
        on_curve(curve, s, rate)
        _, _, _, x, y, z = limb_at(limb, rate)
        step = 1e300
        for b in range(scene.bodies.rows.shape[0]):
            if scene.bodies.rows[b, PART] == HAND:
                room = target_room(scene, b, x, y, z, t, poses) - catch
                if room <= 0.0:
                    return t, b
                fast = speed + scene.bodies.rows[b, TOP_SPEED]
                step = min(step, room / fast if fast > 0.0 else 1e300)
        if t >= until:
            return -1.0, -1
        t = min(t + max(step, shortest), until)


@njit(_nrt=False)
def may_be_met(scene, poses):
    """Whether a target may be within reach, and within the hand's way, at some moment.

    A necessary condition by conservative advancement, so False is certain.
    """
    limb, end = scene.limb, scene.limits.horizon
    far = limb.rho + limb.length
    _, _, _, x, y, z = limb_at(limb, limb.start)
    speed = fastest_hand(scene)
    for b in range(scene.bodies.rows.shape[0]):
        if scene.bodies.rows[b, PART] != HAND:
            continue
        t, top = 0.0, scene.bodies.rows[b, TOP_SPEED]
        while t <= end:
            ring = target_room(scene, b, 0.0, 0.0, 0.0, t, poses) - scene.limits.grasp - far
            way = target_room(scene, b, x, y, z, t, poses) - scene.limits.grasp - speed * t
            wait = way / (top + speed)
            if ring > 0.0:
                wait = max(wait, ring / top if top > 0.0 else 1e300)
            if wait <= _CLOSE * end:
                return True
            t += wait
    return False


def resting_in_space(scene: Scene, until: float) -> tuple[float, float]:
    """What comes to a spatial arm that rests from t = 0 on.

    Parameters
    ----------
    scene : Scene
    until : float
        [s]

    Returns
    -------
    touched : float
        Until when nothing touches the limb [s]; infinite if nothing does before `until`.
    met : float
        When a target first comes within grasp [s]; -1 if none does before `until`.
    """
    return _resting(scene, until, until / _LOOKS)


@njit
def _resting(scene, until, shortest):
    desk, start = desk_of(scene), scene.limb.start
    line(start, start, desk.curve)
    grasp = scene.limits.grasp
    met, _ = first_meeting(scene, desk.curve, 0.0, until, grasp, shortest, desk.poses)
    free = free_until(scene, start, 0.0, until, scene.limb.thickness, shortest, desk)
    return free if free < until else np.inf, met
