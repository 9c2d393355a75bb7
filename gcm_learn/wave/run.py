"""Numbers by which a wave is run, and when it is looked at."""

from __future__ import annotations

from typing import NamedTuple

from gcm_learn.compiled import njit


class Run(NamedTuple):
    """Numbers by which a wave is run, in the plane and in space."""

    held: bool  # frozen or inhibited cells are seen by their neighbours instead of being cut out
    diffusion: float
    epsilon: float
    quiet: float  # change of a potential [1/tau] below which a block counts as settled
    step: float  # [tau]
    lag: float  # from look to look [tau]
    slowness: float  # of the fastest front [tau per cell]
    threshold: float


@njit(_nrt=False)
def rhythm(run):
    """Pairs of Euler steps between two looks at the front, and looks between renewals of blocks."""
    return int(0.5 * run.lag / run.step + 0.5), max(1, int(3.6 / run.lag))
