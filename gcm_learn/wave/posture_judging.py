"""Verdicts on the cells that a front in space has reached: free, frozen, or a contact."""

from __future__ import annotations

import numpy as np

from gcm_learn.arms.spatial_limb import limb_at
from gcm_learn.collision.postures import body_distance
from gcm_learn.compiled import njit
from gcm_learn.motion.joint_interception import target_room
from gcm_learn.scene.bodies import HAND, PART, TOP_SPEED
from gcm_learn.wave.kernels import CONTACT, FREE, FROZEN
from gcm_learn.wave.posture_ground import (
    ADAPTED,
    ARRIVED,
    DOORS,
    SHARE,
    entry_of,
    insulate,
    is_step,
)
from gcm_learn.wave.posture_marching import fastest_obstacle
from gcm_learn.wave.posture_stencil import SLAB, WIDTH

FINEST = 2e-3  # way of a body that is not resolved when a limb is asked about [forearms]
MOST_LOOKS = 256  # at one span of time, against absurdly fast bodies


@njit(_nrt=False)
def way_back(B, joints, leap, n, m, k, when):
    """Cell from which the front came to cell m at place k: where its arrivals fall off most.

    With its distance [cells] and the arrival there; the cell is -1 without such a cell.
    """
    best, steepest, hop, before = -1, 0.0, 0, 0.0
    for dz in range(-1, 2):
        for dy in range(-1, 2):
            for dx in range(-1, 2):
                e = k + dz * SLAB + dy * WIDTH + dx
                arrival = np.float64(B[e + ARRIVED])
                if e == k or B[e] <= 0.0 or arrival < 0.0 or arrival >= when:
                    continue
                away = dx * dx + dy * dy + dz * dz
                fall = (when - arrival) ** 2 / away
                p = m + (dz * n + dy) * n + dx
                if fall > steepest and is_step(joints, leap, m, p):
                    best, steepest, hop, before = p, fall, away, arrival
    return best, np.sqrt(hop), before


@njit(_nrt=False)
def _stride(B, elbows, n, h, m, k):
    """Farthest way of a point of the limb when the hand goes half a step from cell m at place k."""
    far = 0.25 * h * h
    for d in range(6):
        p = m + (-n * n, -n, -1, 1, n, n * n)[d]
        e = k + DOORS[d]
        # what has been reached has been seen, and what has not been reached lies ahead
        if B[e] > 0.0 and B[e + ARRIVED] >= 0.0:
            away = (elbows[m, 0] - elbows[p, 0]) ** 2 + (elbows[m, 1] - elbows[p, 1]) ** 2
            far = max(far, 0.25 * (away + (elbows[m, 2] - elbows[p, 2]) ** 2))
    return min(np.sqrt(far), 2.0 * h)


@njit(_nrt=False)
def hand_at_start(limb):
    """Hand (3) at t = 0."""
    _, _, _, x, y, z = limb_at(limb, limb.start)
    return x, y, z


@njit(_nrt=False)
def _room(scene, place, since, now, touch, shortest, desk):
    """Distance that obstacles have at least from a resting limb (six numbers) at the end of a span.

    -1 if one comes within `touch` of it in the span [s].
    """
    room = 1e30
    for k in range(desk.obstacles.size):
        b = desk.obstacles[k]
        speed, t = scene.bodies.rows[b, TOP_SPEED], now
        far = touch + speed * (now - since)
        found, _ = body_distance(scene.bodies, b, t, place, 0.0, 0.0, far, desk.poses)
        if found <= touch:
            return -1.0
        room = min(room, found)
        if found > far or speed == 0.0:
            continue
        least = max(min(shortest, FINEST * scene.limb.length / speed), (now - since) / MOST_LOOKS)
        while t > since:  # backwards from now, when the distance is known
            t = max(t - max((found - touch) / speed, least), since)
            found, _ = body_distance(scene.bodies, b, t, place, 0.0, 0.0, far, desk.poses)
            if found <= touch:
                return -1.0
    return room


@njit(_nrt=False)
def _way(elbows, m, p, hop):
    """Bound of the way of a point of the limb between cells m and p, `hop` apart."""
    x, y = elbows[m, 0] - elbows[p, 0], elbows[m, 1] - elbows[p, 1]
    z = np.float64(elbows[m, 2] - elbows[p, 2])
    return max(np.sqrt(x * x + y * y + z * z), hop)


@njit(_nrt=False)
def _meeting(scene, hand, since, now, near, shortest, poses):
    """First instant in a span [s] at which a target is near a hand at rest (-1), and which one."""
    when, body = -1.0, -1
    for b in range(scene.bodies.rows.shape[0]):
        if scene.bodies.rows[b, PART] != HAND:
            continue
        speed, t = scene.bodies.rows[b, TOP_SPEED], since
        least = shortest
        if speed > 0.0:
            least = min(shortest, FINEST * scene.limb.length / speed)
            least = max(least, (now - since) / MOST_LOOKS)
        until = now if body < 0 else when
        while True:
            room = target_room(scene, b, hand[0], hand[1], hand[2], t, poses) - near
            if room <= 0.0:
                when, body = t, b
                break
            if t >= until or speed == 0.0 or room > speed * (until - t):
                break
            t = min(t + max(room / speed, least), until)
    return when, body


@njit(_nrt=False)
def judge_cells(scene, ground, terms, batch, count, now, judged, desk):
    """Decide what becomes of the cells that the front has just reached (Eq. 11).

    A limb is not checked where it surely stays clear: by the clearance at the cell before, less the
    motion of limb and obstacles since.

    Returns
    -------
    cell, body : int
        The earliest contact among them, -1 without one.
    time : float
        Its time [s].
    """
    contact, contact_body, first = -1, -1, -1.0
    n, kappa, elbows, B = ground.n, terms.kappa, ground.found.elbows, ground.B
    quick, now = fastest_obstacle(scene), now * kappa
    joints, leap, h = ground.found.nodes.joints, ground.found.nodes.leap, ground.found.nodes.spacing
    middle = 0.5 * (n - 1)
    for i in range(count):
        m, since = batch.cells[i], batch.since[i] * kappa
        k = entry_of(m, n)
        hand = (m % n - middle) * h, (m // n % n - middle) * h, (m // (n * n) - middle) * h
        place = (elbows[m, 0], elbows[m, 1], elbows[m, 2], hand[0], hand[1], hand[2])
        home, hop, left = way_back(B, joints, leap, n, m, k, batch.when[i])
        judged.via[m], left, here = home, left * kappa, batch.when[i] * kappa
        wide = judged.margin + (judged.widening[m] if judged.widening.size > 0 else 0.0)
        touch, room, sure = scene.limb.thickness, -1.0, -1.0
        if wide > 0.0:
            touch += wide * _stride(B, elbows, n, h, m, k)
        if home >= 0:
            room = judged.room[home] - _way(elbows, m, home, hop * h)
            sure = room - quick * max(now - left, left - since)
            room -= quick * abs(here - left)
        if sure <= touch:
            room = _room(scene, place, since, now, touch, terms.shortest, desk)
            if room <= touch:
                judged.state[m] = FROZEN
                continue
            room -= quick * abs(now - here)
        judged.room[m] = room
        t, body = _meeting(scene, hand, since, now, terms.grasp, terms.shortest, desk.poses)
        if body >= 0 and t >= terms.ignore * kappa:
            judged.state[m] = CONTACT
            t = max(t, batch.when[i] * kappa)
            if contact < 0 or t < first:
                contact, contact_body, first = m, body, t
    return contact, contact_body, first


@njit(_nrt=False)
def freeze(ground, batch, count, state):
    """Take the frozen and contacted ones among the cells just reached out of the dynamics."""
    for i in range(count):
        m = batch.cells[i]
        if state[m] != FREE:
            k = entry_of(m, ground.n)
            if ground.run.held:
                ground.B[k + ADAPTED], ground.B[k + SHARE] = ground.B[k], np.float32(0.0)
            else:
                insulate(ground.B, k)
