"""Kernels of the goal-directed search: safe intervals of cells, straight legs that are verified.

It is safe interval path planning (Phillips and Likhachev, ICRA 2011) with any-angle legs.  Their
clearance is computed only when a label is expanded (Lazy Theta*: Nash, Koenig and Tovey, AAAI
2010).  A label is a cell in one of its safe intervals; the limb rests there for as long as it
lasts.  Its leg has been swept without sampling, so what a label says can be done.

Labels are expanded in order of F plus the time that the hand still has to move.  F is the earliest
time at which the hand can meet a target.  This is A*, with a preference for being near among the
many labels that can be at the same meeting.  Labels that cannot meet a target before the bound are
never queued.  A catch lowers the bound, and the search goes on until nothing is left.  Times in
seconds.
"""

from __future__ import annotations

import numpy as np

from gcm_learn.charts import START_RADIUS
from gcm_learn.collision.distance import segment_point2
from gcm_learn.collision.intervals import NEVER, next_free
from gcm_learn.collision.occupancy import first_touch, passes_by
from gcm_learn.collision.sweep import leg_is_free
from gcm_learn.compiled import njit
from gcm_learn.motion.interception import first_interception
from gcm_learn.planners.meetings import aim_at, comes_near, last_use, outlook
from gcm_learn.planners.sipp_labels import Aim, Hunt, SearchEnd, pop, push
from gcm_learn.scene.bodies import HAND, PART
from gcm_learn.wave.plane import STEP_I, STEP_J

MOST_SPANS = 6  # safe intervals of one cell
TRIES = 6  # of entering an interval: another way, then ever later
ENDINGS = 4  # interceptions tried from one label, ever later
NEAR = 1.0  # cells from a target: interceptions are tried from there
GAIN = 0.1  # crossings that an arrival must be sooner to open a label again
FINE = 0.2  # resolution of the end of a safe interval [crossings]
LATE = 0.5  # and of its beginning, which is late by that much


@njit(_nrt=False)
def free_until(postures, m, t, end, shortest):
    """Until when the limb of node m, which is free at t, stays so; `end` at most."""
    bodies, limb, gap, _, scratch = postures
    for b in range(bodies.rows.shape[0]):
        hx, hy, ex, ey = limb[m, 0], limb[m, 1], limb[m, 2], limb[m, 3]
        if bodies.rows[b, PART] == HAND or passes_by(
            bodies, b, hx, hy, ex, ey, gap[m], t, end, scratch
        ):
            continue
        touch = first_touch(bodies, b, hx, hy, ex, ey, gap[m], t, end, shortest, scratch)
        end = touch if touch >= 0.0 else end
    return end


@njit(_nrt=False)
def open_node(m, total, aim, ground, labels):
    """Make labels of the safe intervals of node m that are of use; return the number of labels."""
    postures, speed, start = ground.postures, ground.rules.speed, ground.n * ground.n
    limb, resolution = postures.limb, FINE * ground.spacing / speed
    x, y = limb[m, 0], limb[m, 1]
    t = np.sqrt((x - limb[start, 0]) ** 2 + (y - limb[start, 1]) ** 2) / speed
    last = last_use(aim, speed, x, y)
    ground.first[m] = total
    while t <= last and total < labels.node.size and ground.size[m] < MOST_SPANS:
        t = next_free(postures, m, t, last, LATE * ground.spacing / speed)
        if t > last:
            break
        labels.node[total], labels.since[total] = m, t
        t = labels.until[total] = free_until(postures, m, t, last, resolution)
        ground.size[m] += 1
        total += 1
        if t >= last:
            break
    return total


@njit(_nrt=False)
def entry(p, j, after, ground, labels):
    """Return when, from `after` on, the hand can come straight from label p to j, or NEVER."""
    limb, a, b = ground.postures.limb, labels.node[p], labels.node[j]
    step = np.sqrt((limb[a, 0] - limb[b, 0]) ** 2 + (limb[a, 1] - limb[b, 1]) ** 2)
    step /= ground.rules.speed
    t = max(labels.arrival[p] + step, labels.since[j], after)
    if t > labels.until[j] or t - step > labels.until[p]:
        return NEVER
    return t


@njit(_nrt=False)
def can_go(ground, t0, x0, y0, t1, x1, y1):
    """Tell whether the hand can go straight from 0 to 1."""
    time, hand, hole = ground.sweep.time, ground.sweep.hand, ground.hole
    if segment_point2(0.0, 0.0, x0, y0, x1, y1) < hole * hole:
        return False
    time[0], time[1] = t0, t1
    hand[0, 0], hand[0, 1], hand[1, 0], hand[1, 1] = x0, y0, x1, y1
    return leg_is_free(ground.scene, ground.sweep, ground.sweeps, ground.budget)


@njit(_nrt=False)
def tentative_leg_is_free(j, ground, labels):
    """Tell whether the leg that `tent` of label j stands for is free."""
    limb, a, b = ground.postures.limb, labels.node[labels.by[j]], labels.node[j]
    away = np.sqrt((limb[a, 0] - limb[b, 0]) ** 2 + (limb[a, 1] - limb[b, 1]) ** 2)
    t = labels.tent[j]
    leave = t - away / ground.rules.speed
    return can_go(ground, leave, limb[a, 0], limb[a, 1], t, limb[b, 0], limb[b, 1])


@njit(_nrt=False)
def beside_start(m, ground):
    """Tell whether a node is next to where the hand starts."""
    limb, start = ground.postures.limb, ground.n * ground.n
    away2 = (limb[m, 0] - limb[start, 0]) ** 2 + (limb[m, 1] - limb[start, 1]) ** 2
    return away2 <= (START_RADIUS * ground.spacing) ** 2


@njit(_nrt=False)
def neighbour(m, d, ground):
    """Return neighbour d of 9 of node m, the last being the start; -1 if absent or not opened."""
    n, q = ground.n, ground.n * ground.n
    if d == 8:
        return q if beside_start(m, ground) else -1
    i, j = m // n + STEP_I[d], m % n + STEP_J[d]
    q = i * n + j
    return q if 0 <= i < n and 0 <= j < n and ground.first[q] >= 0 else -1


@njit(_nrt=False)
def another_way(j, ground, labels):
    """Find the next best leg to label j after a leg has failed: from a neighbour, or later.

    Returns the time of arrival, or NEVER, and the label from which the leg comes.
    """
    m, tries = labels.node[j], labels.tries[j]
    after, best, by = labels.tent[j], NEVER, -1
    if tries > 0:
        after += 0.25 * 2.0**tries * ground.spacing / ground.rules.speed
    for e in range(9):
        q = neighbour(m, (e + 3 * tries) % 9, ground)
        for p in range(ground.first[q], ground.first[q] + ground.size[q]) if q >= 0 else range(0):
            if labels.arrival[p] < NEVER:
                t = entry(p, j, after, ground, labels)
                if t < best:
                    best, by = t, p
    return best, by


@njit
def ending(s, aim, ground, labels):
    """Go straight from label s to a target that comes near the label before the bound."""
    step, arrival, limb, m = aim.step, labels.arrival[s], ground.postures.limb, labels.node[s]
    x, y, near = limb[m, 0], limb[m, 1], NEAR * ground.spacing
    i = comes_near(aim, x, y, near, int(arrival / step))
    while i >= 0:
        end = min(step * (i + 1), aim.bound)
        found = straight_to_target(s, max(arrival, step * i), end, ground, labels)
        if found.time < NEVER:
            return found
        i = comes_near(aim, x, y, near, i + 1)
    return SearchEnd(NEVER, -1, 0.0, 0.0, 0.0, -1)


@njit
def straight_to_target(s, since, end, ground, labels):
    """Go straight from label s to a target, met in [since, end]: at once or after a wait."""
    limb, m, speed = ground.postures.limb, labels.node[s], ground.rules.speed
    x, y, come = limb[m, 0], limb[m, 1], labels.arrival[s]
    for k in range(ENDINGS):
        t, body, px, py = first_interception(ground.scene, ground.rules, x, y, come, since, end)
        if body < 0:
            break
        leave = t - np.sqrt((px - x) ** 2 + (py - y) ** 2) / speed
        if can_go(ground, come, x, y, t, px, py):
            return SearchEnd(t, s, come, px, py, body)
        if come < leave <= labels.until[s] and can_go(ground, leave, x, y, t, px, py):
            return SearchEnd(t, s, leave, px, py, body)
        since = t + 0.5 * 2.0**k * ground.spacing / speed
    return SearchEnd(NEVER, -1, 0.0, 0.0, 0.0, -1)


@njit
def _begin(ground, labels, hunt):
    """Begin to search for a catch, with no node opened yet; return the aim."""
    start, speed, bound = ground.n * ground.n, ground.rules.speed, hunt.aim.bound
    aim = aim_at(ground, bound)
    labels.node[0], labels.since[0], labels.arrival[0] = start, 0.0, 0.0
    labels.until[0] = free_until(ground.postures, start, 0.0, bound, FINE * ground.spacing / speed)
    ground.first[start], ground.size[start] = 0, 1
    hunt.total[0] = 1
    relax_from(0, aim, hunt.queue, ground, labels)
    return aim


@njit
def search(ground, labels, hunt, gain, most):
    """Begin, or go on, to find the earliest catch, to within `gain`, until nothing is left.

    Parameters
    ----------
    ground, labels : Ground, Labels
        What was asked for and reached.
    hunt : Hunt
    gain : float
        [s]
    most : int
        Labels that are taken up at most.

    Returns
    -------
    catch : SearchEnd
        The earliest that was found now.
    hunt : Hunt
        With which the search can go on.
    taken : int
        Labels that were taken up.
    """
    speed, limb = ground.rules.speed, ground.postures.limb
    near = NEAR * ground.spacing
    caught, taken = SearchEnd(NEVER, -1, 0.0, 0.0, 0.0, -1), 0
    aim = _begin(ground, labels, hunt) if hunt.total[0] == 0 else hunt.aim
    queue, total = hunt.queue, hunt.total[0]
    while queue.size[0] > 0 and taken < most:
        t, s = pop(queue)
        if s < 0:
            if ground.first[-1 - s] < 0:
                total = open_node(-1 - s, total, aim, ground, labels)
                relax_into(-1 - s, aim, queue, ground, labels)
            continue
        m = labels.node[s]
        if t != labels.tent[s] or outlook(aim, speed, limb[m, 0], limb[m, 1], t)[0] >= NEVER:
            continue
        taken += 1
        if not tentative_leg_is_free(s, ground, labels):
            labels.tries[s] += 1
            t, labels.by[s] = another_way(s, ground, labels)
            labels.tent[s] = NEVER
            if t < labels.arrival[s] and labels.tries[s] <= TRIES:
                queue_label(s, t, aim, queue, ground, labels)
            continue
        labels.arrival[s], labels.via[s] = t, labels.by[s]
        if comes_near(aim, limb[m, 0], limb[m, 1], near, int(t / aim.step)) >= 0:
            found = ending(s, aim, ground, labels)
            if found.time < NEVER:
                caught = found
                if found.time <= gain:
                    break
                aim = Aim(aim.ways, aim.step, found.time - gain)
        relax_from(s, aim, queue, ground, labels)
    hunt.total[0] = total
    return caught, Hunt(aim, queue, hunt.total), taken


@njit(_nrt=False)
def queue_label(k, t, aim, queue, ground, labels):
    """Queue label k, to be reached at t, unless no target can be met from there any more."""
    limb, m = ground.postures.limb, labels.node[k]
    ahead, away = outlook(aim, ground.rules.speed, limb[m, 0], limb[m, 1], t)
    if ahead < NEVER:
        labels.tent[k] = t
        push(queue, ahead + away, t, k)


@njit(_nrt=False)
def relax(s, q, aim, queue, ground, labels):
    """Queue the safe intervals of node q that label s, or the label before s, reaches sooner."""
    tolerance = GAIN * ground.spacing / ground.rules.speed
    for k in range(ground.first[q], ground.first[q] + ground.size[q]):
        t, by, tries = entry(s, k, 0.0, ground, labels), s, 1
        if labels.via[s] >= 0:
            past = entry(labels.via[s], k, 0.0, ground, labels)
            if past <= t:
                t, by, tries = past, labels.via[s], 0
        if t < min(labels.tent[k], labels.arrival[k] - tolerance):
            labels.by[k], labels.tries[k] = by, tries
            queue_label(k, t, aim, queue, ground, labels)


@njit(_nrt=False)
def relax_into(q, aim, queue, ground, labels):
    """Relax all labels around node q, which has just been opened, into the safe intervals of q."""
    for d in range(9):
        m = neighbour(q, d, ground)
        for p in range(ground.first[m], ground.first[m] + ground.size[m]) if m >= 0 else range(0):
            if labels.arrival[p] < NEVER:
                relax(p, q, aim, queue, ground, labels)


@njit(_nrt=False)
def relax_from(s, aim, queue, ground, labels):
    """Relax label s into the opened nodes around it; queue each unopened node as a whole."""
    n, m, limb, speed = ground.n, labels.node[s], ground.postures.limb, ground.rules.speed
    wide, row, column = 1, m // n, m % n
    if s == 0:
        wide = int(START_RADIUS) + 1
        row = int((limb[m, 1] - limb[0, 1]) / ground.spacing + 0.5)
        column = int((limb[m, 0] - limb[0, 0]) / ground.spacing + 0.5)
    p = max(labels.via[s], 0)
    a = labels.node[p]
    for i in range(max(row - wide, 0), min(row + wide + 1, n)):
        for j in range(max(column - wide, 0), min(column + wide + 1, n)):
            q = i * n + j
            if q == m or not ground.inside[q] or (s == 0 and not beside_start(q, ground)):
                continue
            if ground.first[q] >= 0:
                relax(s, q, aim, queue, ground, labels)
                continue
            x, y = limb[q, 0], limb[q, 1]
            t = labels.arrival[p] + np.sqrt((limb[a, 0] - x) ** 2 + (limb[a, 1] - y) ** 2) / speed
            if t < ground.soonest[q]:
                ahead, away = outlook(aim, speed, x, y, t)
                if ahead < NEVER:
                    ground.soonest[q] = t
                    push(queue, ahead + away, t, -1 - q)
