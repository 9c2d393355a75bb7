"""Rates of joints that move a hand as wanted, by weighted damped least squares."""

from __future__ import annotations

import numpy as np

from gcm_learn.arms import limbs
from gcm_learn.compiled import njit
from gcm_learn.motion.joint_interception import approaches, hand_direction
from gcm_learn.scene import bodies

TURNS = 5  # of holding joints at their limits
HARD, SOFT = 1e-9, 0.3  # damping of the hand's velocity and of its direction [share]


@njit(_nrt=False)
def look(study, ends, b, t, q):
    """Write derivatives of the hand and the target's pose at joints q (n,), t [s]; the hand.

    Two approaches fix the hand's spin; one fixes how its direction turns.
    """
    limb, poses, turns, toward = study.scene.limb, ends.work.poses, ends.turns, ends.toward
    where = limbs.place(limb, q)
    place = limbs.hand_of(limb, where)
    limbs.jacobian(limb, q, ends.near)
    limbs.spins(limb, q, turns)
    if approaches(study.scene, b) < 2:
        toward[0], toward[1], toward[2] = hand_direction(study.scene, where, q, b, 0)
        for j in range(q.size):
            turns[0, j], turns[1, j], turns[2, j] = _across(toward, turns[:, j])
    bodies.pose_at(study.scene.bodies, b, t, poses)
    bodies.turn_at(study.scene.bodies, b, t, poses)
    return place


@njit(_nrt=False)
def _across(toward, spin):
    """Rate of a direction (3,) that turns with an angular velocity (3,)."""
    (ax, ay, az), (wx, wy, wz) = (toward[0], toward[1], toward[2]), (spin[0], spin[1], spin[2])
    return wy * az - wz * ay, wz * ax - wx * az, wx * ay - wy * ax


@njit(_nrt=False)
def want(study, ends, b, t, place, share):
    """Write a share of the target's velocity at `place` (3), and its turning; call after `look`."""
    laws, wanted = study.scene.bodies, ends.wanted
    p = bodies.piece_at(laws, b, t) if laws.rows[b, bodies.PIECES] > 0.0 else 0
    ux, uy, uz = bodies.velocity_by(laws, b, p, t, place)
    wanted[0], wanted[1], wanted[2] = share * ux, share * uy, share * uz
    wanted[3], wanted[4], wanted[5] = bodies.spin_by(laws, b, p, t)
    if approaches(study.scene, b) < 2:
        wanted[3], wanted[4], wanted[5] = _across(ends.toward, wanted[3:])


@njit(_nrt=False)
def least_rates(ends, weights, soft, out):
    """Write the least rates, in units of `weights`, that move the hand as ``ends.wanted`` says.

    Minimises the sum of (rate / weight)^2; rows of direction are damped, and are let go where
    joints are at their limits (Whitney 1969, Nakamura and Hanafusa 1986).

    Parameters
    ----------
    ends : Endings
        Derivatives of the hand in `near` and `turns`, what is wanted in `wanted`, limits in `most`.
    weights : (n,) ndarray
    soft : bool
        Whether the direction counts.
    out : (n,) ndarray
        Gets the rates.

    Returns
    -------
    bool
    """
    system, near, turns, n = ends.aim.system, ends.near, ends.turns, out.size
    held = np.uint64(0)
    for turn in range(TURNS):
        rows = 6 if soft and turn < 2 else 3
        _filled(ends, weights, held, out, rows)
        trace = system[0, 0] + system[1, 1] + system[2, 2]
        turning = system[3, 3] + system[4, 4] + system[5, 5] if rows > 3 else 0.0
        for a in range(rows):
            system[a, a] += HARD * trace if a < 3 else SOFT * turning + 1e-12
        if not trace > 0.0 or not solved(system, rows):
            return False
        over = False
        if turn == 0:
            ends.excess[0] = 0.0
        for j in range(n):
            if held >> np.uint64(j) & np.uint64(1):
                continue
            total = 0.0
            for a in range(rows):
                total += (near[a, j] if a < 3 else turns[a - 3, j]) * system[a, 7]
            out[j] = weights[j] * weights[j] * total
            if turn == 0 and abs(out[j]) > ends.excess[0] * ends.most[j]:
                ends.excess[0], ends.excess[1] = abs(out[j]) / ends.most[j], j
            if abs(out[j]) > ends.most[j]:
                out[j] = np.copysign(ends.most[j], out[j])
                held |= np.uint64(1) << np.uint64(j)
                over = True
        if not over:
            return True
    return False


@njit(_nrt=False)
def _filled(ends, weights, held, out, rows):
    """Write the equations of joints that are not held at their limits."""
    system, near, turns, n = ends.aim.system, ends.near, ends.turns, out.size
    for a in range(rows):
        system[a, 6] = ends.wanted[a]
        for c in range(rows):
            system[a, c] = 0.0
    for j in range(n):
        free = held >> np.uint64(j) & np.uint64(1) == 0
        square = weights[j] * weights[j]
        for a in range(rows):
            x = near[a, j] if a < 3 else turns[a - 3, j]
            if not free:
                system[a, 6] -= x * out[j]
                continue
            for c in range(rows):
                y = near[c, j] if c < 3 else turns[c - 3, j]
                system[a, c] += square * x * y


@njit(_nrt=False)
def solved(system, rows):
    """Solve for column 6 by elimination with pivots on the diagonal; column 7 gets the answer."""
    for a in range(rows):
        pivot = system[a, a]
        if not pivot > 1e-300:
            return False
        for c in range(a + 1, rows):
            factor = system[c, a] / pivot
            if factor != 0.0:
                for k in range(a + 1, rows):
                    system[c, k] -= factor * system[a, k]
                system[c, 6] -= factor * system[a, 6]
    for a in range(rows - 1, -1, -1):
        total = system[a, 6]
        for k in range(a + 1, rows):
            total -= system[a, k] * system[k, 7]
        system[a, 7] = total / system[a, a]
    return True
