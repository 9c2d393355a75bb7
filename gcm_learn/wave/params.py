"""Parameters of the FitzHugh-Nagumo lattice (Eq. 10), each with its source, and of marching."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, NamedTuple

from gcm_learn.compiled import njit
from gcm_learn.errors import LatticeError

REST = (0.0, -2.0 / 7.0)  # stable rest state (r, z) of Eq. 10 (erratum 8)
HAND_POTENTIAL = 5.0  # clamped potential of the hand's neuron (Sect. 2.3.2)
EXCITED = (3.0, 1.0 / 7.0)  # excited state (r, z) behind the front (erratum 8)
CHESSBOARD = {5: ("8", 8.0), 9: ("16/3", 16.0 / 3.0)}
"""Largest eigenvalue of the discrete Laplacian of so many points, in words and as a number."""


@dataclass(frozen=True)
class WaveParams:
    """Parameters of the wave; the defaults are the paper's where the paper gives them."""

    n: int = 80
    """Cells along a side of the lattice (Sect. 2.3.2)."""
    diffusion: float = 0.2
    """d of Eq. 10 (Sect. 2.3.2). Propagation fails at 0.045 and below (erratum 9)."""
    epsilon: float = 0.04
    """Rate of the recovery variable in Eq. 10 (Sect. 2.3.2)."""
    step: float = 0.2
    """Euler step [tau]. Not in the paper; late by 0.6 tau at 0.2, at d = 0.2 stable to 0.86
    (erratum 10)."""
    threshold: float = 1.0
    """r_th, the potential whose crossing is the arrival. Not in the paper; at 1 every frozen
    cell has an arrival (erratum 11)."""
    laplacian: Literal[5, 9] = 5
    """Points of the discrete Laplacian. The paper only says "discrete 2D Laplacian"; 5 is the
    usual reading, 9 halves the anisotropy of the front (erratum 9)."""
    start: Literal["rest", "printed"] = "rest"
    """Initial state: the true rest state, or the printed r = z = 0, which is not at rest and
    delays the front by about 6 tau (erratum 8)."""
    start_radius: float = 0.0
    """Radius of the disc that is excited at the start [cells]. 0 is the paper's single neuron,
    whose wave needs some 20 tau to become one (erratum 9)."""
    frozen: Literal["insulating", "held"] = "insulating"
    """Effect of a frozen neuron on its neighbours. "held" is Eq. 10 to the letter: q = 0 keeps r
    where it was, and the neighbours go on seeing it, which can leak through a wall (erratum 14).
    "insulating" also cuts the couplings, so walls hold and narrow gaps stay passable."""
    margin: float = 1.0
    """Widening of obstacles, in units of what half a cell's step moves the limb; 1 closes the
    space between two cells (erratum 14), 0 tests the cells' centres only."""
    slack: float = 0.0
    """Distance beyond the grasp at which a target still makes a contact [cells]. Needed only where
    no cell's centre is within grasp, e.g. at the rim; the path's end is refined exactly anyway."""
    until: Literal["contact", "horizon"] = "contact"
    """Stop at the first contact with a target (Sect. 3.1) or explore to the horizon (Fig. 4)."""

    def __post_init__(self) -> None:
        checks = (
            (0.05 <= self.diffusion <= 1.0, "diffusion", self.diffusion, "in 0.05..1"),
            (0.0 < self.epsilon <= 0.1, "epsilon", self.epsilon, "in 0..0.1"),
            (0.0 < self.step <= 0.9, "step", self.step, "in 0..0.9 [tau]"),
            (0.5 <= self.threshold <= 2.0, "threshold", self.threshold, "in 0.5..2"),
            (self.laplacian in (5, 9), "laplacian", self.laplacian, "5 or 9"),
            (self.start in ("rest", "printed"), "start", self.start, "'rest' or 'printed'"),
            (0.0 <= self.start_radius <= 10.0, "start_radius", self.start_radius, "in 0..10"),
            (
                self.frozen in ("insulating", "held"),
                "frozen",
                self.frozen,
                "'insulating' or 'held'",
            ),
            (0.0 <= self.margin <= 10.0, "margin", self.margin, "in 0..10"),
            (0.0 <= self.slack <= 2.0, "slack", self.slack, "in 0..2 [cells]"),
            (self.until in ("contact", "horizon"), "until", self.until, "'contact' or 'horizon'"),
        )
        for good, name, value, wanted in checks:
            if not good:
                raise LatticeError(f"wave parameter {name} must be {wanted}, got {value!r}")
        self._check_stability()

    def _check_stability(self) -> None:
        """Refuse a step in which a pattern from cell to cell grows instead of settling.

        Von Neumann: behind the front a deviation relaxes with 5/7 in every neuron (at r = 3 the
        slope of Eq. 10).  By diffusion it relaxes with at most d times the Laplacian's largest
        eigenvalue, that of a chessboard.  Cells that are cut out or held only lower it.  Euler
        needs step times the sum to be at most 2; the recovery, which is slow, grants a hundredth
        more.
        """
        told, largest = CHESSBOARD[self.laplacian]
        if self.step * (5.0 / 7.0 + largest * self.diffusion) > 2.0:
            raise LatticeError(
                f"step {self.step} is unstable with diffusion {self.diffusion} on {self.laplacian} "
                f"points: explicit Euler needs step * (5/7 + {told} diffusion) <= 2"
            )


@dataclass(frozen=True)
class MarchingParams:
    """Parameters of causal marching.

    A spatial arm's moves count as blocked once 2 million distances have been computed for a map.
    Crowded scenes take a tenth of that; a body that spins at 1e5 rad/s would take minutes.
    """

    n: int = 80
    """Cells along a side of the lattice."""
    margin: float = 1.0
    """Widening of obstacles, as for the wave."""
    lookback: float = 1.0
    """Since when a cell must have been free: 1 covers the whole time since the front was next door
    (erratum 14), 0 the instant of its arrival only."""
    slack: float = 0.0
    """Distance beyond the grasp at which a target still makes a contact [cells]."""
    until: Literal["contact", "horizon"] = "contact"
    """Stop at the first contact with a target or explore to the horizon."""


class WaveRun(NamedTuple):
    """Numbers by which a wave is run."""

    held: bool  # frozen cells are seen by their neighbours instead of being cut out
    diffusion: float
    epsilon: float
    quiet: float  # change of a potential [1/tau] below which a block counts as settled
    step: float  # [tau]
    lag: float  # from look to look [tau]
    slowness: float  # of the fastest front [tau per cell]
    threshold: float


@njit(_nrt=False)
def rhythm(run):
    """Pairs of Euler steps between checks of the front, and checks between renewals of blocks."""
    return int(0.5 * run.lag / run.step + 0.5), max(1, int(3.6 / run.lag))
