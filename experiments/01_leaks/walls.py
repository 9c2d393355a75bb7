"""Moving walls in hand-space, and how to see that a front has leaked through one.

A point-like body at the distance s from the shoulder is touched when the point of the limb at that
distance lies in its direction.  So with phi(y) for the direction of that point at hand position y,
the body is the line phi(y) = theta in hand-space, which runs from the outer to the inner rim of the
ring: a wall without holes, whatever its thickness.  For s < rho it is the upper arm that is touched
(the wall is half a circle); for rho < s < 1 - rho it is the forearm.

Two such bodies, spinning about the shoulder, enclose the hand in a wedge.  A front that respects
them reaches every cell while the cell is in the wedge; a cell that is reached and not frozen while
it is outside shows a leak.  There are no other false or missed alarms to weigh: the criterion needs
neither distances nor tolerances.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gcm_learn.arm.lattice import Lattice, hand_space
from gcm_learn.situation import Arm, Body, Disc, PlanarQuadratic, Polygon, Situation
from gcm_learn.situation.bodies import pack
from gcm_learn.wave import Front, Task, WaveParams, kappa_of
from gcm_learn.wave.kernels import FREE

PARTS = {"upper arm": (1.0, 0.5), "forearm": (0.4, 0.5)}  # rho and distance s from the shoulder
MOTIONS = {"static": (0, 0), "head on": (1, -1), "receding": (-1, 1), "sweeping": (1, 1)}
POINT = 1e-5  # half-width of a body of no width [forearm lengths]
CLEAR = 0.3  # walls start at least this far from the hand [rad]


@dataclass(frozen=True)
class Walls:
    """A task whose only obstacles are two walls."""

    task: Task
    direction: np.ndarray
    """(n, n): phi [rad]."""
    start: tuple[float, float]
    """theta of the clockwise and the counter-clockwise wall at t = 0 [rad]; the first is below."""
    rate: tuple[float, float]
    """Their angular velocities [rad/s]."""


def limb_direction(lattice: Lattice, distance: float) -> np.ndarray:
    """Direction (n, n) of the limb's point at a distance from the shoulder, for every hand [rad].

    The distance must be less than the upper arm's length, or more and less than 1 - rho.
    """
    hand, elbow = np.split(hand_space(lattice).limb.reshape(lattice.n, lattice.n, 4), 2, axis=-1)
    if distance > lattice.upper_arm:
        forearm = hand - elbow
        # Solve |elbow + s forearm| = distance for the s in [0, 1]; the forearm's length is 1.
        half, rest = (elbow * forearm).sum(-1), lattice.upper_arm**2 - distance**2
        elbow = elbow + (np.sqrt(half**2 - rest) - half)[..., None] * forearm
    return np.arctan2(elbow[..., 1], elbow[..., 0])


def breadth(lattice: Lattice, direction: np.ndarray) -> float:
    """How far walls move for a radian of turn, where they move most [forearm lengths]."""
    slope = np.zeros_like(direction)
    for axis in (0, 1):
        step = np.angle(np.exp(1j * (np.roll(direction, -1, axis) - np.roll(direction, 1, axis))))
        slope += (step / (2.0 * lattice.spacing)) ** 2
    ring = hand_space(lattice).inside.reshape(direction.shape)
    return float(1.0 / np.sqrt(slope[ring].min()))


def draw(
    rng: np.random.Generator,
    part: str,
    motion: str,
    speed: float,
    width: float,
    params: WaveParams,
) -> Walls:
    """Draw a hand and two walls around it.

    Parameters
    ----------
    rng : numpy.random.Generator
    part, motion : str
        One of PARTS, one of MOTIONS.
    speed : float
        Of the walls across themselves, where it is largest [cells per tau].
    width : float
        Of the walls, where it is largest [cells]; the margin comes on top.
    params : WaveParams
        For the size of the lattice, for kappa and for the time at which the front sets out.

    Returns
    -------
    Walls
    """
    rho, distance = PARTS[part]
    elbow = "right" if rng.random() < 0.5 else "left"
    lattice = Lattice(params.n, rho, elbow)
    direction = limb_direction(lattice, distance)
    turn = rng.uniform(-np.pi, np.pi)
    radius = rng.uniform(abs(rho - 1.0) + 0.3, rho + 0.8)
    hand = (float(radius * np.cos(turn)), float(radius * np.sin(turn)))
    free = Task(_pack((), hand, lattice, 1.0), lattice, hand, speed=1.0, horizon=1.0)
    kappa = kappa_of(free, params)
    reach = breadth(lattice, direction)
    rate = speed * lattice.spacing / kappa / reach
    before, after, horizon = _angles(rng, motion, rate * kappa)
    here = float(direction[lattice.cell_of(*hand)])
    start, rates = (here - before, here + after), tuple(rate * s for s in MOTIONS[motion])
    half = max(0.5 * width * lattice.spacing * distance / reach, POINT)
    walls = tuple(_wall(k, distance, half, start[k], rates[k]) for k in (0, 1))
    bodies = _pack(walls, hand, lattice, horizon * kappa)
    task = Task(bodies, lattice, hand, speed=1.0, horizon=horizon * kappa)
    return Walls(task, direction, start, (rates[0], rates[1]))


def _angles(rng: np.random.Generator, motion: str, rate: float) -> tuple[float, float, float]:
    """Angles between hand and walls at t = 0 and a horizon [tau], for a rate [rad/tau].

    Approaching walls are to meet the front when it has some size, if there is room for that: they
    start far off, but leave a sector on the far side in which a leak is seen.
    """
    near = rng.uniform(CLEAR, 1.0, size=2)
    meet = rng.uniform(20.0, 90.0) * rate
    if motion == "static":
        return *(near + rng.uniform(0.0, 1.5, size=2)), 400.0
    if motion == "head on":
        return *np.minimum(near + meet, rng.uniform(2.0, 3.0, size=2)), 400.0
    if motion == "receding":
        return *near, min(400.0, (5.5 - near.sum()) / (2.0 * rate))
    return min(near[0] + meet, rng.uniform(3.0, 4.3)), near[1], 400.0


def _wall(index: int, distance: float, half: float, start: float, rate: float) -> Body:
    """A square of half-width `half` that spins about the shoulder."""
    corners = ((distance + half, 0.0), (distance, half), (distance - half, 0.0), (distance, -half))
    motion = PlanarQuadratic((0.0, 0.0), (0.0, 0.0), (0.0, 0.0), start, rate)
    return Body("obstacle", f"wall {index}", Polygon(corners), motion)


def _pack(walls, hand, lattice, horizon):
    """Pack walls; a target out of reach makes the situation valid."""
    away = PlanarQuadratic((9.0, 0.0), (0.0, 0.0), (0.0, 0.0))
    target = Body("target", "far away", Disc(0.1), away)
    arm = Arm(hand, 1.0, upper_arm=lattice.upper_arm, elbow=lattice.elbow)
    return pack(Situation("walls", horizon, arm, (*walls, target)))


def leaked_cells(walls: Walls, front: Front, since: float = 0.0) -> int:
    """Count the cells that a front reached on the far side of a wall.

    Parameters
    ----------
    walls : Walls
    front : Front
    since : float
        When the front set out; what was excited at the start does not count [s].

    Returns
    -------
    int
    """
    t = front.arrival
    low, high = (a + w * t for a, w in zip(walls.start, walls.rate, strict=True))
    inside = np.mod(walls.direction - low, 2.0 * np.pi) < high - low
    return int(np.count_nonzero((front.state == FREE) & (t > since) & ~inside))
