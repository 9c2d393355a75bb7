"""Effects of obstacles on a wave that may wait: they inhibit cells while they are there.

In the published wave a cell on which front and obstacle meet is frozen for ever, and a cell that
was excited before is never checked again.  Here the excited region is at every moment the set of
places where the hand can be.  An obstacle puts a cell to rest, and cuts it off, for as long as it
is there.  Then excited neighbours excite the cell once more.

No cell is checked at every look.  When the front arrives, conservative advancement finds the time
until which the cell is safe, and after that the time at which it will be free again.  These dates
stand in a calendar of looks.  Times are mental [tau] for the lattice and in seconds for bodies.
The wave itself is in `wave.excitation`.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gcm_learn.collision.intervals import NEVER, next_free
from gcm_learn.collision.occupancy import Postures
from gcm_learn.compiled import njit
from gcm_learn.wave.kernels import CLAMPED, entry_of, insulate, live_weight
from gcm_learn.wave.params import REST
from gcm_learn.wave.stencil import BLOCK

ARRIVAL, END = 0, 1  # columns of a state's span of time [s]
TOTAL, PENDING, LOOK = 0, 1, 2  # entries of a book's tally
UNFELT = np.float32(-1.0)  # instead of the arrival of a cell that the front is not near to
TICK = 0.5  # of the clock [tau]
SLOTS = 256  # of the calendar, a power of two; later dates wait for their turn
REST_R, REST_Z = (np.float32(v) for v in REST)
SADDLE = 1.0  # potential between rest and excitation (erratum 8)
STEP_I = np.array([-1, 0, 0, 1, -1, -1, 1, 1])  # the four edge neighbours first
STEP_J = np.array([0, -1, 1, 0, -1, 1, -1, 1])


class World(NamedTuple):
    """The bodies and the times of their contacts; times in seconds."""

    postures: Postures
    clock: np.ndarray  # time at every TICK of mental time
    kappa: float  # seconds per tau after that
    shortest: float  # resolution of searches
    grasp: float  # distance at which a target is met
    ignore: float  # meetings before this do not count
    end: float  # horizon
    explore: bool  # go on after a target is met


class Book(NamedTuple):
    """Cells and states that are known."""

    latest: np.ndarray  # (n * n,): the state a cell is excited in, -1 if none
    opened: np.ndarray  # (n * n,): since when a cell is not inhibited [tau]
    heads: np.ndarray  # (SLOTS,): first cell of a day's list in the calendar, -1 if none
    following: np.ndarray  # (n * n,): next cell of the list
    dates: np.ndarray  # (n * n,): check at which a cell's turn comes
    states: np.ndarray  # (m, 2): cell and predecessor
    spans: np.ndarray  # (m, 2): arrival and end of the safe interval [s]
    refused: np.ndarray  # (n * n,) bool: an obstacle was there when a front came
    tally: np.ndarray  # numbers of states and of dates, and the look


class Batch(NamedTuple):
    """The cells that are reached together."""

    cells: np.ndarray
    via: np.ndarray  # predecessors: states
    since: np.ndarray
    when: np.ndarray
    until: np.ndarray
    blocked: np.ndarray


@njit
def seconds(tau, world):
    """Time [s] at a mental time [tau]."""
    last = world.clock.size - 1
    place = tau / TICK
    if place >= last:
        return world.clock[last] + (tau - last * TICK) * world.kappa
    i = int(place)
    return world.clock[i] + (place - i) * (world.clock[i + 1] - world.clock[i])


@njit
def mental(t, world):
    """Mental time [tau] at a time [s], the last one if there are many."""
    last = world.clock.size - 1
    if t >= world.clock[last]:
        return last * TICK + (t - world.clock[last]) / world.kappa
    i = np.searchsorted(world.clock, t, side="right") - 1
    return TICK * (i + (t - world.clock[i]) / (world.clock[i + 1] - world.clock[i]))


@njit
def make_date(m, tau, ground, book):
    """Note that a cell's turn comes at the first look from `tau` on, in the future at any rate."""
    look = book.tally[LOOK]
    ahead = np.ceil((tau - ground.start) / ground.run.lag)
    date = max(look + 1, int(min(ahead, 1e15)))
    slot = date & (SLOTS - 1)
    book.dates[m], book.following[m] = date, book.heads[slot]
    book.heads[slot] = m
    book.tally[PENDING] += 1


@njit
def inhibit(m, t, ground, world, book):
    """Put a cell to rest for as long as an obstacle is there, from t [s] on."""
    B, W, plane = ground.B, ground.W, ground.plane
    k = entry_of(m, ground)
    if ground.run.held:
        B[k + 3 * plane] = 0.0
        wake(k, m, ground)  # its neighbours lose what it gave them
        B[k] = REST_R
    else:
        insulate(B, k, W, plane, ground.points)
    B[k + 2 * plane] = REST_Z
    B[k + 5 * plane] = UNFELT
    book.latest[m] = -1
    look = ground.run.lag * world.kappa  # shorter spans of freedom are of no use
    free = next_free(world.postures, m, t, world.end, look)
    if free < NEVER:
        # An excited neighbour needs half a crossing to excite a cell at rest, the hand a whole one.
        make_date(m, mental(free, world) + 0.5 * ground.run.slowness, ground, book)


@njit
def release(m, tau, ground, book):
    """Undo the inhibition of a cell; it is at rest, and its neighbours may excite it."""
    B, W, plane = ground.B, ground.W, ground.plane
    k = entry_of(m, ground)
    B[k + 3 * plane] = ground.run.step * ground.rate[m]
    if not ground.run.held:
        for d in range(8):
            e = k + STEP_I[d] * W + STEP_J[d]
            B[e + 4 * plane] += live_weight(ground.points, d > 3)
    B[k], B[k + 2 * plane] = REST_R, REST_Z
    book.opened[m] = tau
    wake(k, m, ground)


@njit(forceinline=True)
def wake(k, m, ground):
    """Have a cell's block stepped, and its neighbours': to `find_runs` the cell is in motion."""
    ground.active[k // ground.W, (m % ground.n) // BLOCK] = True
    ground.B[k + ground.plane] = ground.B[k] + np.float32(1.0)


@njit
def turn_page(tau, ground, world, book):
    """Do what is due at this look; returns whether anything has to wake up.

    A cell that is excited is to be inhibited, one that is not is to be released.
    """
    look, woken = book.tally[LOOK], False
    slot = look & (SLOTS - 1)
    m = book.heads[slot]
    book.heads[slot] = -1
    while m >= 0:
        after = book.following[m]
        if book.dates[m] > look:  # a later turn of the calendar
            book.following[m] = book.heads[slot]
            book.heads[slot] = m
        else:
            book.tally[PENDING] -= 1
            book.dates[m] = -1
            s = book.latest[m]
            if s >= 0:
                inhibit(m, book.spans[s, END], ground, world, book)
                woken |= ground.run.held
            else:
                release(m, tau, ground, book)
                woken = True
        m = after
    return woken


@njit
def leap(ground, world, book):
    """Number of looks until the next date, or else until the horizon."""
    soonest = int(min((mental(world.end, world) - ground.start) / ground.run.lag + 2.0, 1e15))
    for m in range(book.dates.size):
        if book.dates[m] >= 0:
            soonest = min(soonest, book.dates[m])
    return max(soonest - book.tally[LOOK] - 1, 0)


@njit
def hold_up(runs, lo, hi, ground):
    """Clamp reached cells that lose their excitation, as the hand's neuron is clamped.

    A pocket of few cells next to many at rest is too small to excite them and would go out; but the
    hand still waits there.
    """
    B = ground.B
    arrival, rate = np.uint64(5 * ground.plane), np.uint64(3 * ground.plane)
    lost = np.float32(min(ground.run.threshold, SADDLE))
    for run in range(runs):
        fallen = np.int32(0)
        for k in range(lo[run], hi[run]):
            fallen += np.int32(
                (B[k] < lost)
                & (B[k + arrival] >= np.float32(0.0))
                & (B[k + rate] > np.float32(0.0))
            )
        if fallen == 0:
            continue
        for k in range(lo[run], hi[run]):
            if B[k] < lost and B[k + arrival] >= 0.0 and B[k + rate] > 0.0:
                B[k], B[k + rate] = CLAMPED, 0.0
