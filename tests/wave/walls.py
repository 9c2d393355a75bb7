"""Moving walls in hand-space, and how to see that a front has leaked through one.

A point-like body at the distance s from the shoulder is touched when the point of the limb at that
distance lies in its direction.  Let phi(y) be the direction of that point at hand position y.  Then
the body is the line phi(y) = theta in hand-space, from the outer to the inner rim of the ring: a
wall without holes, whatever its thickness.  For s < rho it touches the upper arm, and the wall is
half a circle.  For rho < s < 1 - rho it touches the forearm.

Two such bodies enclose the hand in a wedge.  A front that respects them reaches every cell while
the cell is in the wedge.  A cell that is reached and not frozen while it is outside shows a leak.
The criterion needs neither distances nor tolerances.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gcm_learn.arms import Arm
from gcm_learn.charts import Lattice, hand_space
from gcm_learn.scene import Scene, pack
from gcm_learn.situation import Body, Disc, PlanarQuadratic, Polygon, Situation
from gcm_learn.wave import Front, WaveParams, front_speed, kappa_of

PARTS = {"upper arm": (1.0, 0.5), "forearm": (0.4, 0.5)}  # rho and distance s from the shoulder
TURNING = {"head on": (1, -1), "receding": (-1, 1), "sweeping": (1, 1)}
MOTIONS = ("static", *TURNING, "passing")
POINT = 1e-5  # half-width of a body of no width [forearm lengths]
CLEAR = 0.3  # walls start at least this far from the hand [rad]
BESIDE, AHEAD = 0.2, 0.9  # a passing disc flies by the shoulder at BESIDE, from and to AHEAD


@dataclass(frozen=True)
class Wall:
    """A body at the direction theta(t), seen from the shoulder."""

    body: Body
    theta: float
    """At t = 0, or at its start [rad]."""
    rate: float = 0.0
    """Angular velocity of a turning wall [rad/s]."""
    flight: float = 0.0
    """Velocity of a passing disc along its line, with the sign of its turn [forearm lengths/s]."""
    start: float = 0.0
    """When a passing disc is AHEAD [s]."""

    def at(self, t: np.ndarray) -> np.ndarray:
        """Direction at times t [rad], continuous in t."""
        side = np.sign(self.flight)
        way = abs(self.flight) * (t - self.start) - AHEAD
        passed = side * (np.arctan2(way, BESIDE) - np.arctan2(-AHEAD, BESIDE))
        return self.theta + self.rate * t + passed


@dataclass(frozen=True)
class Walls:
    """A scene whose only obstacles are two walls."""

    setting: tuple[Scene, Lattice]
    out: float
    """When the front sets out: what is excited before does not count [s]."""
    direction: np.ndarray
    """(n, n): phi [rad]."""
    pair: tuple[Wall, Wall]
    """Clockwise and counter-clockwise of the hand."""


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
    """Largest way of the walls for a radian of turn [forearm lengths]."""
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
        One of PARTS, one of MOTIONS.  Passing discs are walls for the upper arm only.
    speed : float
        Of the walls across themselves, where it is largest [cells per tau].
    width : float
        Of the walls, where it is largest [cells]; the margin comes on top.
    params : WaveParams
        For the size of the lattice, for kappa and for the disc that is excited at the start.

    Returns
    -------
    Walls
    """
    rho, distance = PARTS[part]
    lattice = Lattice(params.n, rho, "right" if rng.random() < 0.5 else "left")
    direction = limb_direction(lattice, distance)
    turn, radius = rng.uniform(-np.pi, np.pi), rng.uniform(abs(rho - 1.0) + 0.3, rho + 0.8)
    hand = (float(radius * np.cos(turn)), float(radius * np.sin(turn)))
    kappa = kappa_of(_pack((), hand, lattice, 1.0), lattice, params)
    per_radian = breadth(lattice, direction)
    rate = speed * lattice.spacing / per_radian  # [rad/tau]
    half = max(0.5 * width * lattice.spacing * distance / per_radian, POINT)
    here = float(direction[lattice.cell_of(hand)])
    out = params.start_radius / front_speed(params).fastest if params.start_radius > 0 else 0.0
    if motion == "passing":
        pair, horizon = _passing(rng, here, rate / kappa, half, out * kappa)
    else:
        # The excited disc looks wide from a hand near the shoulder.
        clear = CLEAR + 4.0 * params.start_radius * lattice.spacing
        before, after, tau = _angles(rng, motion, rate, clear)
        signs, horizon = TURNING.get(motion, (0, 0)), (out + tau) * kappa
        # These angles are those at which the walls are when the front sets out.
        starts = (here - before - signs[0] * rate * out, here + after - signs[1] * rate * out)
        low, high = (
            _turning(k, distance, half, starts[k], signs[k] * rate / kappa) for k in (0, 1)
        )
        pair = (low, high)
    scene = _pack((pair[0].body, pair[1].body), hand, lattice, horizon)
    return Walls((scene, lattice), out * kappa, direction, pair)


def _angles(
    rng: np.random.Generator, motion: str, rate: float, clear: float
) -> tuple[float, float, float]:
    """Angles between hand and walls, and a horizon [tau], for a rate [rad/tau].

    Approaching walls should meet the front when it has some size.  They start far off, but leave a
    sector on the far side in which a leak is seen.
    """
    near = rng.uniform(clear, clear + 0.7, size=2)
    meet = rng.uniform(20.0, 90.0) * rate
    if motion == "static":
        return *(near + rng.uniform(0.0, 1.5, size=2)), 400.0
    if motion == "head on":
        return *np.minimum(near + meet, rng.uniform(2.0, 3.0, size=2)), 400.0
    if motion == "receding":
        return *near, min(400.0, (5.5 - near.sum()) / (2.0 * rate))
    return min(near[0] + meet, rng.uniform(3.0, 4.3)), near[1], 400.0


def _turning(index: int, distance: float, half: float, start: float, rate: float) -> Wall:
    """A square of half-width `half` that spins about the shoulder; a disc when it rests."""
    still = (0.0, 0.0)
    if rate == 0.0:
        place = (float(distance * np.cos(start)), float(distance * np.sin(start)))
        body = Body("obstacle", f"wall {index}", Disc(half), PlanarQuadratic(place, still, still))
        return Wall(body, start)
    corners = ((distance + half, 0.0), (distance, half), (distance - half, 0.0), (distance, -half))
    motion = PlanarQuadratic(still, still, still, start, rate)
    return Wall(Body("obstacle", f"wall {index}", Polygon(corners), motion), start, rate)


def _passing(
    rng: np.random.Generator, here: float, rate: float, half: float, out: float
) -> tuple[tuple[Wall, Wall], float]:
    """A disc that flies by the shoulder, its direction turning past the hand's, and one at rest."""
    side = 1.0 if rng.random() < 0.5 else -1.0  # +1: the clockwise wall moves, counter-clockwise
    start = here - side * rng.uniform(CLEAR, 1.5)
    middle = start + side * np.arctan2(AHEAD, BESIDE)  # its direction when it is nearest
    normal = np.array([np.cos(middle), np.sin(middle)])
    along = side * np.array([-normal[1], normal[0]])
    velocity = rate * BESIDE * along
    place = BESIDE * normal - AHEAD * along - out * velocity
    motion = PlanarQuadratic(
        (float(place[0]), float(place[1])), (float(velocity[0]), float(velocity[1])), (0.0, 0.0)
    )
    disc = Body("obstacle", "wall 0", Disc(half * BESIDE / 0.5), motion)
    mover = Wall(disc, start, flight=side * rate * BESIDE, start=out)
    rest = _turning(1, 0.5, half, here + side * rng.uniform(0.5, 2.5), 0.0)
    pair = (mover, rest) if side > 0 else (rest, mover)
    return pair, out + 2.0 * AHEAD / (rate * BESIDE)


def _pack(
    walls: tuple[Body, ...], hand: tuple[float, float], lattice: Lattice, horizon: float
) -> Scene:
    """Pack walls; a target out of reach makes the situation valid."""
    away = PlanarQuadratic((9.0, 0.0), (0.0, 0.0), (0.0, 0.0))
    target = Body("target", "far away", Disc(0.1), away)
    arm = Arm(hand, 1.0, upper_arm=lattice.upper_arm, elbow=lattice.elbow, grasp=0.0)
    return pack(Situation("walls", horizon, arm, (*walls, target)))


def leaked_cells(walls: Walls, front: Front) -> int:
    """Count the cells that a front reached on the far side of a wall."""
    t = front.first
    low, high = (wall.at(t) for wall in walls.pair)
    inside = np.mod(walls.direction - low, 2.0 * np.pi) < high - low
    return int(np.count_nonzero(~(front.refused | front.met) & (t > walls.out) & ~inside))
