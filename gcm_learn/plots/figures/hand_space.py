"""Hand-space: the arm is a point there, and obstacles are extended."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import to_rgba
from matplotlib.image import AxesImage
from matplotlib.patches import Circle

from gcm_learn.arms import Arm
from gcm_learn.charts import Lattice, occupied_cells
from gcm_learn.plots.figures import style
from gcm_learn.plots.figures.workspace import draw_bodies
from gcm_learn.situation import Situation

FINE = 320  # cells a side: a point-like obstacle's image is a curve, 1/80 is the finest to see


def draw_hand_space(ax: Axes, situation: Situation, t: float = 0.0) -> Axes:
    """Draw extended obstacles, the obstacles themselves and targets at one instant.

    Parameters
    ----------
    ax : Axes
    situation : Situation
    t : float
        Time [s].

    Returns
    -------
    Axes
    """
    style.frame(ax, situation.arm.upper_arm)
    draw_extended(ax, situation, t)
    draw_bodies(ax, situation, t)
    draw_hand(ax, situation.arm.hand)
    return ax


def draw_extended(
    ax: Axes, situation: Situation, t: float, *, alpha: float = 0.85, n: int = FINE
) -> AxesImage:
    """Draw the hand positions that obstacles forbid at time t [s] (Eq. 9 for the whole limb)."""
    image = extended_image(situation, t, alpha=alpha, n=n)
    return show_image(ax, image, situation.arm)


def extended_image(
    situation: Situation, t: float, *, alpha: float = 0.85, n: int = FINE
) -> np.ndarray:
    """Return an RGBA image (n, n, 4) of the extended obstacles, clear where the hand may be."""
    lattice = lattice_of(situation.arm, n)
    occupied = occupied_cells(situation, lattice, t)[_drawn_over_rim(lattice)]
    return occupied[..., None] * np.array(to_rgba(style.EXTENDED, alpha))


@lru_cache(maxsize=8)
def _drawn_over_rim(lattice: Lattice) -> tuple[np.ndarray, np.ndarray]:
    """Return index arrays with which cells just outside the rim repeat cells just inside.

    An image that is then clipped with the rim's circle has no steps of cells at its edge.
    """
    x, y = np.meshgrid(lattice.centres, lattice.centres)
    h, reach, radius = lattice.spacing, lattice.upper_arm + 1.0, np.hypot(x, y)
    beyond = (radius > reach) & (radius < reach + 2 * h)
    pull = np.where(beyond, (reach - 0.75 * h) / radius, 1.0)
    row, column = ((pull * v + reach) / h for v in (y, x))
    return row.astype(int), column.astype(int)


def show_image(ax: Axes, image: np.ndarray, arm: Arm, zorder: float = 2.0) -> AxesImage:
    """Lay an image over the reachable disc."""
    reach = arm.reach
    shown = ax.imshow(
        image, origin="lower", extent=(-reach, reach, -reach, reach), zorder=zorder,
        interpolation="antialiased",
    )  # fmt: skip
    shown.set_clip_path(Circle((0, 0), reach, transform=ax.transData))
    return shown


def draw_hand(ax: Axes, hand: tuple[float, ...] | np.ndarray) -> None:
    """Draw the hand as a point; in hand-space the whole arm is this point."""
    ax.plot([hand[0]], [hand[1]], "o", color="black", mec="white", mew=1.0, ms=7.5, zorder=12)


def lattice_of(arm: Arm, n: int) -> Lattice:
    """Return a lattice over an arm's hand-space."""
    return Lattice(n, arm.upper_arm, arm.elbow)
