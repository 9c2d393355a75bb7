"""Films of a planar arm: its plane, or the solids about it."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes

from gcm_learn.arms import elbow_position
from gcm_learn.plots.figures import style
from gcm_learn.plots.figures.solid_scene import SolidFilm
from gcm_learn.plots.figures.workspace import draw_arm, draw_bodies
from gcm_learn.scene import outline
from gcm_learn.situation import Situation

HELD = 25  # instants of a film at which targets are in its picture


class PlaneFilm:
    """An arm's plane in a picture that holds the whole way of the targets.

    Parameters
    ----------
    situation : Situation
        With a planar arm.
    end : float
        Of the film [s].
    """

    def __init__(self, situation: Situation, end: float) -> None:
        self.situation, self.end = situation, end

    def frame(self, ax: Axes) -> None:
        """Frame the disc in reach, and the targets at all times."""
        situation = self.situation
        style.frame(ax, situation.arm.upper_arm)
        targets = [k for k, body in enumerate(situation.bodies) if body.role == "target"]
        times = np.linspace(0.0, self.end, HELD)
        shapes = [outline(situation, k, t) for k in targets for t in times]
        rim = np.array([ax.get_xlim(), ax.get_ylim()]).T
        held = np.concatenate([rim, *(corners for corners in shapes if corners is not None)])
        low, high = held.min(axis=0), held.max(axis=0)
        half, (x, y) = 0.5 * float((high - low).max()), 0.5 * (low + high)
        ax.set(xlim=(x - half, x + half), ylim=(y - half, y + half))

    def seen(self, points: np.ndarray) -> np.ndarray:
        """Return points (k, 2) of the arm's plane, which are the picture's."""
        return points

    def show(
        self, ax: Axes, t: float, hand: np.ndarray, pixels: int, other: np.ndarray | None = None
    ) -> None:
        """Draw time t [s] with the hand (2,), and an arm with another hand in grey."""
        arm = self.situation.arm
        draw_bodies(ax, self.situation, t)
        if other is not None:
            elbow = elbow_position(other, arm.upper_arm, arm.elbow)
            limb = np.array([(0.0, 0.0), elbow, other])
            ax.plot(*limb.T, "o-", color=style.FAINT, lw=3.0, ms=6.0, alpha=0.7, zorder=5.5)
        draw_arm(ax, arm, hand)


Film = PlaneFilm | SolidFilm
_FILMS: dict[bool, type[Film]] = {False: PlaneFilm, True: SolidFilm}


def film_of(situation: Situation, end: float) -> Film:
    """Return the film of a planar arm until `end` [s], of its plane or of the solids about it."""
    return _FILMS[situation.is_solid](situation, end)
