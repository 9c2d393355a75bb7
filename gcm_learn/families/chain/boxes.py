"""Parts in furniture: in a shelf behind a sliding door, or in a drawer that opens."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gcm_learn.families.chain.bins import DOWN, THIN, open_box
from gcm_learn.families.chain.family import ChainFamily, Story, level
from gcm_learn.families.chain.motions import shifted, sliding, staged
from gcm_learn.families.chain.stage import Stage, Way
from gcm_learn.families.ranges import Range, number, pick, pick_sign, span
from gcm_learn.families.solids import UP, axes_along, solid
from gcm_learn.situation import Body, Box

LEVEL = 0.7  # height of directions that reach into a shelf, at most


@dataclass(frozen=True)
class ShelfChain(ChainFamily):
    """A part creeps along in a shelf that is open before the hand; doors slide off some."""

    name = "shelf-chain"
    summary = "a part in a shelf, before which a door may slide off"

    directed: float = number(1.0)
    """Share of situations whose targets prescribe an approach: the hand's direction on its way."""
    depth: Range = span(0.1, 0.17, 0.02)
    """Half the depth [reaches]."""
    wide: Range = span(0.11, 0.17, 0.02)
    """Half the width [reaches]."""
    high: Range = span(0.1, 0.13, 0.02)
    """Half the height [reaches]."""
    inside: Range = span(0.3, 0.9)
    """From the front to the part [half depths]."""
    creep: Range = span(0.01, 0.1)
    """Speed of the part along the shelf [reaches/s]."""
    doors: float = number(0.4)
    """Share of shelves with a door."""
    opened: Range = span(0.5, 0.95, 0.05, 1.0)
    """Instant at which it is off the way [times of the meeting]."""

    def story(self, rng: np.random.Generator, stage: Stage) -> Story:
        """A part and a shelf."""
        way = self.way(rng, stage, lambda hands, axes: np.abs(axes[:, 2]) < LEVEL)
        axes, thin = axes_along(UP, level(way.axis)), THIN * stage.arm.reach
        sizes = tuple(stage.slot(rng, ends) for ends in (self.depth, self.wide, self.high))
        off = rng.uniform(-0.4, 0.4, 2) * sizes[1:]
        deep = (1.0 - pick(rng, self.inside)) * sizes[0]
        middle = way.meet + axes @ (deep, off[0], off[1])
        course = pick_sign(rng) * stage.size(rng, self.creep) * axes[:, 1]
        bodies = [self.ball(rng, stage, way.meet, way.when, course)]
        for name, place, half in _shelf(sizes, thin):
            bodies.append(solid(name, Box(half), middle + axes @ place, axes))
        if rng.random() < self.doors:
            bodies.append(self._door(rng, way, middle, axes, sizes, thin))
        return Story(way, tuple(bodies))

    def _door(
        self,
        rng: np.random.Generator,
        way: Way,
        middle: np.ndarray,
        axes: np.ndarray,
        sizes: tuple[float, ...],
        thin: float,
    ) -> Body:
        """Draw a board in front of the shelf that slides to one side and keeps moving."""
        depth, wide, high = sizes
        side, off = pick_sign(rng) * axes[:, 1], pick(rng, self.opened) * way.when
        place = middle - (depth + 3.0 * thin) * axes[:, 0]
        door = solid("door", Box((thin, wide + 2.0 * thin, high + 2.0 * thin)), place, axes)
        return staged(door, [(0.0, 2.0 * (wide + 2.0 * thin) / off * side, np.zeros(3))])


def _shelf(
    sizes: tuple[float, ...], thin: float
) -> list[tuple[str, tuple[float, float, float], tuple[float, float, float]]]:
    """Return a shelf's boards: name, place and half sizes, along (in, sideways, up)."""
    depth, wide, high = sizes
    return [
        ("top", (0.0, 0.0, high), (depth, wide, thin)),
        ("bottom", (0.0, 0.0, -high), (depth, wide, thin)),
        ("left side", (0.0, wide, 0.0), (depth, thin, high)),
        ("right side", (0.0, -wide, 0.0), (depth, thin, high)),
        ("back", (depth, 0.0, 0.0), (thin, wide, high)),
    ]


@dataclass(frozen=True)
class DrawerChain(ChainFamily):
    """A part lies in a drawer that comes out of a cabinet, and can be had from above then."""

    name = "drawer-chain"
    summary = "a part in a drawer that slides out of a cabinet"

    directed: float = number(1.0)
    """Share of situations whose targets prescribe an approach: the hand's direction on its way."""
    half: Range = span(0.09, 0.15, 0.02)
    """Half the sides of the drawer [reaches]."""
    low: Range = span(0.02, 0.05, 1e-3)
    """From the drawer's bottom to the part [reaches]."""
    deep: Range = span(0.05, 0.09, 1e-3)
    """Height of its walls [reaches]."""
    begins: Range = span(0.0, 0.5, most=0.9)
    """Instant at which it starts to open [times of the meeting]."""
    opened: Range = span(0.92, 1.0, 0.91, 1.0)
    """Instant at which it is open [times of the meeting]."""

    def story(self, rng: np.random.Generator, stage: Stage) -> Story:
        """A part in a drawer, and the cabinet."""
        way = self.way(rng, stage, lambda hands, axes: axes[:, 2] < DOWN)
        axes, thin = axes_along(UP, -level(way.meet)), THIN * stage.arm.reach
        x, y = (stage.slot(rng, self.half) for _ in range(2))
        tall = 0.5 * stage.size(rng, self.deep)
        bottom = way.meet - stage.size(rng, self.low) * UP
        bottom = bottom + axes @ (0.3 * x * rng.uniform(-1, 1), 0.3 * y * rng.uniform(-1, 1), 0.0)
        drawer = open_box("", bottom, axes, (x, y, tall), thin)
        part = self.ball(rng, stage, way.meet, 0.0)
        by = 2.0 * (x + 2.0 * thin) * axes[:, 0]
        begins, ends = pick(rng, self.begins) * way.when, pick(rng, self.opened) * way.when
        moving = [sliding(shifted(body, -by), begins, ends, by) for body in (part, *drawer)]
        cabinet = _cabinet(bottom - by, axes, (x, y, tall), thin)
        return Story(way, (*moving, *cabinet), under=("bottom",))


def _cabinet(
    bottom: np.ndarray, axes: np.ndarray, sizes: tuple[float, float, float], thin: float
) -> tuple[Body, ...]:
    """Return roof, sides and back around a closed drawer with its bottom at `bottom` (3,)."""
    x, y, tall = sizes
    roof = bottom + (2.0 * tall + 3.0 * thin) * UP
    middle = bottom + (tall + thin) * UP
    half, out = tall + 2.0 * thin, y + 3.0 * thin
    return (
        solid("roof", Box((x + thin, out, thin)), roof, axes),
        solid("left side", Box((x, thin, half)), middle + out * axes[:, 1], axes),
        solid("right side", Box((x, thin, half)), middle - out * axes[:, 1], axes),
        solid("back", Box((thin, out, half)), middle - (x + 3.0 * thin) * axes[:, 0], axes),
    )
