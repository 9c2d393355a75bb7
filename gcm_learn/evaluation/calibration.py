"""Margins that cover the errors of a predictor, by split conformal prediction.

The score of a window is its largest error, each over a shape ``w + (1 - w) t / horizon``.  So the
margin holds at all times of a window at once; Cleaveland et al. (AAAI 2024) learn a weight for each
time.  Its size is a quantile of the scores of other windows (Lei et al., J. Amer. Statist. Assoc.
113, 2018).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gcm_learn import seeding
from gcm_learn.errors import FieldError
from gcm_learn.evaluation.statistics import Interval, wilson
from gcm_learn.outside import Window, laws_of, places_of
from gcm_learn.situation import Margin

SHAPES = tuple(k / 20.0 for k in range(21))
FOR_SHAPE = 0.2  # of the first half


@dataclass(frozen=True)
class Calibration:
    """Calibrated margin, with its coverage of tracks that had no part in the calibration."""

    margin: Margin
    shape: float
    """Share of the margin at the horizon that is there at t = 0."""
    chosen: int
    calibrated: int
    """Numbers of tracks that chose the shape, and that made the size."""
    within: int
    held_out: int
    """Number of tracks without a part in both, of which `within` stay within the margin."""

    @property
    def covered(self) -> Interval:
        """Share of held-out tracks that stay within the margin, with Wilson's interval."""
        return wilson(self.within, self.held_out)


def split(count: int, seed: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return indices of windows for the shape, for the quantile, and held out: the second half."""
    order, half = seeding.rng(seed, 0).permutation(count), (count + 1) // 2
    first = round(FOR_SHAPE * half)
    return order[:first], order[first:half], order[half:]


def quantile(scores: np.ndarray, cover: float) -> float:
    """Return the score of rank ceil((n + 1) cover) of n, infinite if there are too few."""
    rank = math.ceil((len(scores) + 1) * cover - 1e-9)
    return float(np.sort(scores)[rank - 1]) if rank <= len(scores) else math.inf


def calibrate(
    windows: Sequence[Window],
    predictor: str,
    cover: float = 0.95,
    seed: int = 0,
    shapes: Sequence[float] = SHAPES,
) -> Calibration:
    """Return the margin within which a share of tracks stays, from half of the windows.

    Parameters
    ----------
    windows : sequence of Window
        One of each track, all with the same horizon.
    predictor : str
        A name of `outside.PREDICTORS`.
    cover : float
        Share of tracks that stay within over the whole horizon.
    seed : int
        Of the halves.
    shapes : sequence of float
        Among them w is chosen; 1 is a constant margin.

    Raises
    ------
    UnknownNameError, FieldError
    """
    for_shape, for_margin, held_out = split(len(windows), seed)
    if not len(for_shape) or quantile(np.zeros(len(for_margin)), cover) > 0.0:
        reason = f"{len(windows)} are too few for a cover of {cover:g}"
        raise FieldError("tracks", f"{reason} ({len(for_margin)} make the margin)")
    horizon, pairs = windows[0].times[-1], zip(windows, laws_of(windows, predictor), strict=True)
    offs = [np.linalg.norm(places_of(law, w.times) - w.places, axis=1) for w, law in pairs]
    shares = [window.times / horizon for window in windows]

    def scores(shape: float) -> np.ndarray:
        with np.errstate(divide="ignore", invalid="ignore"):
            found = [off / (shape + (1.0 - shape) * s) for off, s in zip(offs, shares, strict=True)]
        return np.array([np.nanmax(score) for score in found])

    def mean(shape: float) -> float:
        wide = np.quantile(scores(shape)[for_shape], cover, method="higher")
        return float(wide) * (1.0 + shape)

    shape = min(shapes, key=mean)
    found = scores(shape)
    wide = quantile(found[for_margin], cover)
    margin = Margin(wide * shape, wide * (1.0 - shape) / horizon)
    within = int((found[held_out] <= wide).sum())
    return Calibration(margin, shape, len(for_shape), len(for_margin), within, len(held_out))
