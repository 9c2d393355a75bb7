"""Bins into which a chain puts the targets that it has caught."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from gcm_learn.arms import Chain
from gcm_learn.families.chain.stage import Stage, Way
from gcm_learn.families.layout import TRIES
from gcm_learn.families.ranges import Range, Ranges, number, pick, pick_angle, span
from gcm_learn.families.solids import UP, axes_along, solid, triple
from gcm_learn.situation import Body, Box, Place, Situation

THIN = 0.0085  # half the thickness of boards [reaches]
DOWN = -0.4  # height of directions in which a hand reaches into a drawer or a bin, at most
SIDES = ((0, 1.0), (0, -1.0), (1, 1.0), (1, -1.0))


@dataclass(frozen=True)
class Bins(Ranges):
    """Bins that are open above, and places in them; lengths in reaches."""

    share: float = number(0.0)
    """Share of situations with holds in which a bin stands; all targets are to be put into it."""
    within: Range = span(0.02, 0.03, 1e-6)
    """Largest distance of a target from its place, just over the rim."""
    half: Range = span(0.08, 0.12, 0.01)
    """Half the sides of bins."""
    deep: Range = span(0.06, 0.1, 0.01)
    """Depth of bins."""
    over: Range = span(0.03, 0.05)
    """From the rim up to the place."""
    away: Range = span(0.25, 1.0, most=3.0)
    """From the meeting to the place."""
    lift: Range = span(0.15, 0.3, 1e-3)
    """Time for which a carried target may touch what it lay on [s]."""

    def ask(
        self, rng: np.random.Generator, stage: Stage, way: Way, situation: Situation[Chain],
        under: tuple[str, ...],
    ) -> Situation[Chain]:  # fmt: skip
        """Return the situation with a bin and places, or unchanged if there is no room for a bin.

        Targets lie on the obstacles `under`; only obstacles that the situation has count.
        """
        under = tuple(body.name for body in situation.obstacles if body.name in under)
        others = [body for body in situation.bodies if body not in stage.floor]
        hands, axes = stage.hands()
        near, far = np.array(self.away) * stage.arm.reach
        gaps = np.linalg.norm(hands - way.meet, axis=1)
        ends = np.flatnonzero((axes[:, 2] < DOWN) & (gaps > near) & (gaps < far))
        for k in rng.permutation(ends)[:TRIES]:
            bin_ = self._bin(rng, stage, hands[k])
            other = way._replace(end=stage.joints[k], when=stage.horizon)
            if stage.fits(way, bin_) and stage.fits(other, (*others, *bin_)):
                place = Place(triple(hands[k]), stage.size(rng, self.within))
                lift = pick(rng, self.lift) if under else None
                bodies = (
                    replace(body, place=place, ignore=under, ignore_for=lift)
                    if body.role == "target"
                    else body
                    for body in situation.bodies
                )
                return replace(situation, bodies=(*bodies, *bin_))
        return situation

    def _bin(self, rng: np.random.Generator, stage: Stage, place: np.ndarray) -> list[Body]:
        """Draw a bin below a place (3,)."""
        sizes = [stage.slot(rng, self.half) for _ in range(2)]
        deep, angle = stage.size(rng, self.deep), pick_angle(rng)
        bottom = place - (deep + stage.size(rng, self.over)) * UP
        axes = axes_along(UP, (np.cos(angle), np.sin(angle), 0.0))
        thin = THIN * stage.arm.reach
        return open_box("bin ", bottom, axes, (sizes[0], sizes[1], 0.5 * deep), thin)


def open_box(
    name: str, bottom: np.ndarray, axes: np.ndarray, sizes: tuple[float, float, float], thin: float
) -> list[Body]:
    """Return the bottom and the four walls of a box that is open above.

    The point `bottom` (3,) is the middle of the bottom. The third of the axes (3, 3) is up. Sizes
    are half the sides and half the height, `thin` is half the thickness of the boards.
    """
    x, y, tall = sizes
    boards = [solid(f"{name}bottom", Box((x, y, thin)), bottom, axes)]
    for k, side in SIDES:
        size = [x, y, tall]
        size[k] = thin
        place = bottom + side * (x, y)[k] * axes[:, k] + tall * UP
        board = solid(f"{name}wall {len(boards)}", Box((size[0], size[1], size[2])), place, axes)
        boards.append(board)
    return boards
