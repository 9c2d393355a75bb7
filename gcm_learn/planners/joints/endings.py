"""Ends of movements: a run-up from rest, the catch, the hold and a stop, each verified as a whole.

They are the roots of the second tree, so that trees solve little but moves from rest to rest. All
pieces are quadratic in time. Limits of jerk are kept later by a moving average over the movement;
a hold therefore begins half of its width earlier, and ends as much later.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from gcm_learn.arms.curves import hermite
from gcm_learn.collision.postures import free_at, least_on
from gcm_learn.compiled import njit
from gcm_learn.motion import holding
from gcm_learn.motion.joint_interception import approaches
from gcm_learn.motion.joint_verification import NOTHING, piece_fault
from gcm_learn.planners.joints import ramps
from gcm_learn.planners.joints.least_rates import least_rates, look, want
from gcm_learn.planners.joints.moves import Study
from gcm_learn.planners.joints.trees import uniform
from gcm_learn.scene import bodies
from gcm_learn.scene.shapes.choice import inner_radius
from gcm_learn.situation import Situation

STEP = 0.025  # of a hold, in which rates are linear [s]
MOST_STEPS = 400  # of a hold
FIRST = 3  # sample at which a hold begins: before it there is room for a run-up
GAIN = 0.3  # share of a hand's distance from its place that a step makes good
BRAKES = (1.02, 1.5, 2.5, 4.0)  # times of braking that are tried, in the shortest
CHANCES = 20  # stops that are drawn where even braking is not free
SLIP = 0.6  # share of the relative speed that is used
MOST = 0.95  # share of it that is used where joints cannot be as fast as the target
OFTEN = 0.6  # share of holds in which the hand is slower than the target
DEPTH = 0.25  # share of grasp and approach that is left for the hold when a posture is drawn
EASE = 1e-3  # share of the relative speed that is not used
UNPULLED, UNFREE, FAST, FORCED, SLIPS, HITS, NO_STOP, EARLY, END = range(9)  # why it is no end
FOLLOWS = 0.5  # share of touches with a stop in which the hand is as fast as the target


class Endings(NamedTuple):
    """Verified ends of movements, and work space."""

    time: np.ndarray  # (m, k) [s]
    joints: np.ndarray  # (m, k, n)
    rates: np.ndarray  # (m, k, n)
    first: np.ndarray  # (m,): first sample
    size: np.ndarray  # (m,): samples, those before the first included
    span: np.ndarray  # (m, 2): when the target is caught and let go [s]
    body: np.ndarray  # (m,): the target
    made: np.ndarray  # (1,): ends that are there
    why: np.ndarray  # (8,): draws that came to nothing, by reason
    half: float  # width of the moving average, halved [s]
    stops: bool  # whether the arm has to rest at the end
    near: np.ndarray  # (3, n): derivative of the hand
    turns: np.ndarray  # (3, n): derivative of its direction
    toward: np.ndarray  # (3,): that direction
    wanted: np.ndarray  # (6,): rates of both
    change: np.ndarray  # (n,)
    most: np.ndarray  # (n,)
    still: np.ndarray  # (n,): no rates
    excess: np.ndarray  # (2,): largest share of a limit that was wanted last, and its joint
    need: np.ndarray  # (2,): the least of these among draws that were too fast
    place: np.ndarray  # (6,): the hand in the target's frame, and its velocity there
    work: holding.Work
    aim: Study  # with room in the grasp and in the approach


def _aim_of(study: Study) -> Study:
    """Return a study in which postures are pulled well into the grasp and the approach."""
    rows, laws = study.scene.bodies.rows.copy(), study.scene.bodies
    targets = np.flatnonzero(rows[:, bodies.PART] == bodies.HAND)
    room = study.scene.limits.grasp + min(inner_radius(laws, b) for b in targets)
    rows[:, [bodies.WITHIN, bodies.WITHIN + bodies.SECOND]] *= 1.0 - DEPTH
    scene = study.scene._replace(bodies=laws._replace(rows=rows))
    return study._replace(scene=scene, catch=study.catch - DEPTH * room)


def new_endings(study: Study, situation: Situation[Any], count: int, half: float) -> Endings:
    """Return arrays for a number of ends of movements."""
    scene, n = study.scene, study.goal.size
    longest = max((t.hold.seconds for t in situation.targets if t.hold is not None), default=0.0)
    steps = min(int(np.ceil((longest + 2.0 * half) / STEP)) + 1, MOST_STEPS)
    k = FIRST + 1 + steps + 4
    return Endings(
        np.zeros((count, k)), np.zeros((count, k, n)), np.zeros((count, k, n)),
        np.zeros(count, np.int64), np.zeros(count, np.int64), np.zeros((count, 2)),
        np.zeros(count, np.int64), np.zeros(1, np.int64), np.zeros(8, np.int64), half,
        situation.end == "rest" or any(target.place for target in situation.targets),
        np.zeros((3, n)), np.zeros((3, n)), np.zeros(3), np.zeros(6), np.zeros(n), np.zeros(n),
        np.zeros(n), np.zeros(2), np.full(2, np.inf), np.zeros(6), holding.work_of(scene),
        _aim_of(study),
    )  # fmt: skip


@njit(_nrt=False)
def _matched(study, trees, ends, e, b, t):
    """Write rates that let the hand go with the target at the start of end e; whether there are."""
    q, rates, limits = ends.joints[e, FIRST], ends.rates[e, FIRST], study.scene.limits
    row, wanted = study.scene.bodies.rows, ends.wanted
    place = look(study, ends, b, t, q)
    share, held = 1.0, row[b, bodies.HOLD] >= 0.0
    if not held:
        share = uniform(trees) if uniform(trees) < FOLLOWS else 0.0
    want(study, ends, b, t, place, share)
    ends.place[3:] = 0.0
    ux, uy, uz = wanted[0], wanted[1], wanted[2]
    if held:
        fast = np.sqrt(ux * ux + uy * uy + uz * uz)
        if uniform(trees) < OFTEN and fast > 0.0:
            slower = min(SLIP * uniform(trees) * row[b, bodies.HOLD_SPEED] / fast, 1.0)
            for k in range(3):
                ends.place[3 + k] = -slower * wanted[k]
                wanted[k] -= slower * wanted[k]
    for j in range(q.size):
        ends.most[j] = limits.joint_speed[j] * (1.0 - 2.0 * ramps.EASE)
        rates[j] = 0.0
    soft = approaches(study.scene, b) > 0
    if least_rates(ends, limits.joint_speed, soft, rates):
        return True
    x, y, z = _off(ends, rates, ux, uy, uz)
    ends.place[3], ends.place[4], ends.place[5] = x, y, z
    return held and x * x + y * y + z * z <= (MOST * row[b, bodies.HOLD_SPEED]) ** 2


@njit(_nrt=False)
def _off(ends, rates, ux, uy, uz):
    """Velocity of the hand at the posture looked at, with rates (n,), in excess of another."""
    for j in range(rates.size):
        ux -= ends.near[0, j] * rates[j]
        uy -= ends.near[1, j] * rates[j]
        uz -= ends.near[2, j] * rates[j]
    return -ux, -uy, -uz


@njit(_nrt=False)
def _to_frame(ends, b, place):
    """Note where the hand is in the target's frame."""
    poses, out = ends.work.poses, ends.place
    x, y, z = place[0] - poses[b, 0], place[1] - poses[b, 1], place[2] - poses[b, 2]
    for k in range(3):
        out[k] = poses[b, 3 + k] * x + poses[b, 6 + k] * y + poses[b, 9 + k] * z


@njit(_nrt=False)
def _from_frame(ends, b, since):
    """Place (3) where the hand should be, `since` the begin of the hold [s]."""
    poses, at = ends.work.poses, ends.place
    return (
        poses[b, 0] + poses[b, 3] * at[0] + poses[b, 4] * at[1] + poses[b, 5] * at[2]
        + at[3] * since,
        poses[b, 1] + poses[b, 6] * at[0] + poses[b, 7] * at[1] + poses[b, 8] * at[2]
        + at[4] * since,
        poses[b, 2] + poses[b, 9] * at[0] + poses[b, 10] * at[1] + poses[b, 11] * at[2]
        + at[5] * since,
    )  # fmt: skip


@njit(_nrt=False)
def _follow(study, ends, e, b, since, until):
    """Write the hold of end e; return the hold's last sample, -1 if limits of joints forbid it."""
    scene, limits = study.scene, study.scene.limits
    limb, wanted, change = scene.limb, ends.wanted, ends.change
    steps = min(int(np.ceil((until - since) / STEP - 1e-9)), ends.time.shape[1] - FIRST - 5)
    ends.time[e, FIRST] = since
    if steps <= 0:
        return FIRST
    _to_frame(ends, b, look(study, ends, b, since, ends.joints[e, FIRST]))
    span, soft = (until - since) / steps, approaches(scene, b) > 0
    for j in range(change.size):
        ends.most[j] = limits.joint_acceleration[j] * (1.0 - 2.0 * ramps.EASE) * span
    for i in range(FIRST, FIRST + steps):
        q, v, p, w = (
            ends.joints[e, i],
            ends.rates[e, i],
            ends.joints[e, i + 1],
            ends.rates[e, i + 1],
        )
        t = since + span * (i + 1 - FIRST)
        for j in range(q.size):
            p[j] = q[j] + span * v[j]
        hand = look(study, ends, b, t, p)
        place = _from_frame(ends, b, t - since)
        want(study, ends, b, t, place, 1.0)
        ux, uy, uz = wanted[0], wanted[1], wanted[2]
        for k in range(3):
            wanted[k] += ends.place[3 + k] + GAIN * (place[k] - hand[k]) / span
        for k in range(3):
            for j in range(q.size):
                wanted[k] -= ends.near[k, j] * v[j]
                wanted[3 + k] -= ends.turns[k, j] * v[j]
            wanted[k] /= 1.0 + 0.5 * GAIN
        kept = least_rates(ends, limits.joint_acceleration, soft, change)
        for j in range(q.size):
            top = limits.joint_speed[j] * (1.0 - ramps.EASE)
            w[j] = min(max(v[j] + change[j], -top), top)
            kept = kept and w[j] == v[j] + change[j]
            p[j] = q[j] + 0.5 * span * (v[j] + w[j])
            if not limb.low[j] <= p[j] <= limb.high[j]:
                return -1
        x, y, z = _off(ends, w, ux, uy, uz)
        if not kept and x * x + y * y + z * z > scene.bodies.rows[b, bodies.HOLD_SPEED] ** 2:
            return -1
        ends.time[e, i + 1] = t
    ends.time[e, FIRST + steps] = until
    return FIRST + steps


@njit(_nrt=False)
def _pass_by(study, ends, e, t):
    """Let end e pass the drawn posture at t [s] with the rates there; return the last sample."""
    q, v, half = ends.joints[e, FIRST], ends.rates[e, FIRST], ends.half
    ends.time[e, FIRST] = t - half
    if half == 0.0:
        return FIRST
    ends.time[e, FIRST + 1] = t + half
    for j in range(q.size):
        q[j] -= half * v[j]
        ends.joints[e, FIRST + 1, j] = q[j] + 2.0 * half * v[j]
        ends.rates[e, FIRST + 1, j] = v[j]
    return FIRST + 1


@njit(_nrt=False)
def _piece_of(study, ends, e, i):
    """Write the move between samples i and i + 1 of end e into the desk; return its duration."""
    span = ends.time[e, i + 1] - ends.time[e, i]
    hermite(
        ends.joints[e, i], ends.rates[e, i], ends.joints[e, i + 1], ends.rates[e, i + 1], span,
        study.desk.curve,
    )  # fmt: skip
    return span


@njit(_nrt=False)
def _piece_is_free(study, ends, e, i):
    """Return whether the move between samples i and i + 1 keeps limits and touches nothing."""
    span, desk = _piece_of(study, ends, e, i), study.desk
    if piece_fault(study.scene, desk.curve, span, desk.joints) != NOTHING:
        return False
    since = ends.time[e, i]
    best, _ = least_on(study.scene, since, since + span, study.touch, 1e300, 1e300, desk)
    return best > study.touch


@njit(_nrt=False)
def _keeps_hold(study, ends, e, b, last):
    """Return whether the hold of end e stays within the limits that target b sets for holds."""
    speed = study.scene.bodies.rows[b, bodies.HOLD_SPEED] * (1.0 - EASE)
    for i in range(FIRST, last):
        span, since = _piece_of(study, ends, e, i), ends.time[e, i]
        fault = holding.hold_fault_on(
            study.scene, b, since, since + span, study.desk.curve, span, since,
            (study.catch, speed), ends.work,
        )  # fmt: skip
        if fault != holding.KEPT:
            return False
    return True


@njit(_nrt=False)
def braking(limits, rates, stretch):
    """Time in which joints with these rates (n,) rest if all brake evenly [s]."""
    least = 0.0
    for j in range(rates.size):
        most = limits.joint_acceleration[j] * (1.0 - 2.0 * ramps.EASE)
        least = max(least, abs(rates[j]) / most)
    return stretch * least


@njit(_nrt=False)
def _rest_after(ends, e, i, m, span):
    """Let sample m, next to sample i, be at rest `span` later, or earlier if that is negative."""
    ends.time[e, m] = ends.time[e, i] + span
    for j in range(ends.joints.shape[2]):
        ends.joints[e, m, j] = ends.joints[e, i, j] + 0.5 * span * ends.rates[e, i, j]
        ends.rates[e, m, j] = 0.0


@njit(_nrt=False)
def _stopped(study, trees, ends, e, last):
    """Append a free stop to end e after sample `last`; return the new last sample, -1 if none."""
    limits, moves = study.scene.limits, trees.moves
    v, q, p = ends.rates[e, last], ends.joints[e, last], ends.joints[e, last + 4]
    if braking(limits, v, 1.0) < ramps.SHORTEST:
        v[:] = 0.0
        return last
    for stretch in BRAKES:
        _rest_after(ends, e, last, last + 1, braking(limits, v, stretch))
        if _piece_is_free(study, ends, e, last):
            return last + 1
    since = ends.time[e, last]
    for _ in range(CHANCES):
        span = braking(limits, v, 1.0 + 4.0 * uniform(trees))
        for j in range(q.size):
            p[j] = (
                q[j]
                + 0.5 * span * v[j]
                + (uniform(trees) - 0.5) * span * span * 0.5 * (limits.joint_acceleration[j])
            )
        pieces = ramps.ramp(limits, q, v, p, ends.still, span, ramps.GIVEN, moves)
        if pieces > 0 and ramps.ramp_is_free(study, moves, pieces, since):
            for i in range(1, pieces + 1):
                _copy(ends, e, last + i, moves, i, since)
            return last + pieces
    return -1


@njit(_nrt=False)
def _copy(ends, e, m, moves, i, since):
    """Make sample i of a move sample m of an end."""
    ends.time[e, m] = since + moves.time[i]
    for j in range(ends.joints.shape[2]):
        ends.joints[e, m, j], ends.rates[e, m, j] = moves.joints[i, j], moves.rates[i, j]


@njit(_nrt=False)
def _run_up(study, ends, e):
    """Prepend a free move from rest to end e; return the first sample, `FIRST` if none is free."""
    v, low, high = ends.rates[e, FIRST], study.scene.limb.low, study.scene.limb.high
    if braking(study.scene.limits, v, 1.0) < ramps.SHORTEST:
        return FIRST
    for stretch in BRAKES:
        span = braking(study.scene.limits, v, stretch)
        _rest_after(ends, e, FIRST, FIRST - 1, -span)
        inside = ends.time[e, FIRST - 1] >= ends.half
        for j in range(v.size):
            inside = inside and low[j] <= ends.joints[e, FIRST - 1, j] <= high[j]
        if inside and _piece_is_free(study, ends, e, FIRST - 1):
            return FIRST - 1
    return FIRST


@njit(_nrt=False)
def ended(study, trees, ends, b, t):
    """Make an end of a movement that catches target b with the drawn posture at t [s].

    Returns
    -------
    int
        Number of the end; -1 if there is none.
    """
    e, rows = ends.made[0], study.scene.bodies.rows
    since, seconds = t - ends.half, rows[b, bodies.HOLD]
    if e == ends.body.size or since <= ends.half:
        return -1
    for j in range(trees.drawn.size):
        ends.joints[e, FIRST, j] = trees.drawn[j]
    first, last, why = FIRST, FIRST, END
    if not free_at(study.scene, trees.drawn, since, study.touch, study.desk):
        why = UNFREE
    elif not _matched(study, trees, ends, e, b, since):
        why = FAST
        if ends.excess[0] < ends.need[0]:
            ends.need[0], ends.need[1] = ends.excess[0], ends.excess[1]
    else:
        if seconds < 0.0:
            last = _pass_by(study, ends, e, t)
        else:
            last = _follow(study, ends, e, b, since, t + seconds + ends.half)
        if last < 0:
            why = FORCED
        elif seconds >= 0.0 and not _keeps_hold(study, ends, e, b, last):
            why = SLIPS
        for i in range(FIRST, last):
            if why == END and not _piece_is_free(study, ends, e, i):
                why = HITS
    if why == END and ends.stops:
        last = _stopped(study, trees, ends, e, last)
        why = NO_STOP if last < 0 else END
    if why == END:
        first = _run_up(study, ends, e)
        limb, limits = study.scene.limb, study.scene.limits
        spare = ends.time[e, first] - ends.half
        if spare <= 0.0 or not ramps.may_ramp(
            limits, limb.start, limb.rates, ends.joints[e, first], spare, False
        ):
            why = EARLY
    if why != END:
        ends.why[why] += 1
        return -1
    ends.first[e], ends.size[e], ends.body[e] = first, last + 1, b
    ends.span[e, 0], ends.span[e, 1] = t, t + max(seconds, 0.0)
    ends.made[0] = e + 1
    return e
