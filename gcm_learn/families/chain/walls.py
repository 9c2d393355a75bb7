"""Openings to reach through: a window of bars with a shutter, and a gate of two leaves."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gcm_learn.families import ranges
from gcm_learn.families.chain.family import ChainFamily, Story, facing
from gcm_learn.families.chain.motions import shifted, sliding, staged
from gcm_learn.families.chain.stage import Stage, Way
from gcm_learn.families.solids import STILL, axes_along, solid, unit_vector
from gcm_learn.situation import Body, Box, Capsule


@dataclass(frozen=True)
class WindowChain(ChainFamily):
    """The hand has to go through a window of bars, past which a shutter slides."""

    name = "window-chain"
    summary = "a part behind a window of bars, past which a shutter slides"

    directed: float = ranges.number(1.0)
    """Share of situations whose targets prescribe an approach: the hand's direction on its way."""
    behind: ranges.Range = ranges.span(0.06, 0.14, 0.01)
    """From the bars to the meeting [reaches]."""
    opening: ranges.Range = ranges.span(0.12, 0.16, 0.02)
    """Half the width and the height of the window [reaches]."""
    bar: ranges.Range = ranges.span(0.014, 0.014, 1e-3)
    """Radius of bars [reaches]."""
    length: ranges.Range = ranges.span(0.25, 0.35, 0.02)
    """Half the length of bars [reaches]."""
    more: ranges.Counts = ranges.counts(0, 2)
    """Number of bars beside the window."""
    drift: ranges.Range = ranges.span(0.01, 0.2)
    """Speed of the part [reaches/s]."""
    shutters: float = ranges.number(0.6)
    """Share of windows with a shutter."""
    shutter: ranges.Range = ranges.span(0.035, 0.06, 1e-3)
    """Radius of shutters [reaches]."""
    passes: ranges.Range = ranges.span(0.2, 0.8, 0.01)
    """Instant at which a shutter is in the middle [times of the meeting]."""

    def story(self, rng: np.random.Generator, stage: Stage) -> Story:
        """A part, bars, a shutter."""
        way = self.way(rng, stage)
        course = stage.size(rng, self.drift) * unit_vector(rng.normal(size=3))
        axes = facing(way)
        middle = way.meet - stage.size(rng, self.behind) * axes[:, 0]
        wide, high = (stage.slot(rng, self.opening) for _ in range(2))
        bodies = [self.ball(rng, stage, way.meet, way.when, course)]
        bodies += self._bars(rng, stage, middle, axes, (wide, high))
        if rng.random() < self.shutters:
            bodies.append(self._shutter(rng, stage, way, middle, axes, (wide, high)))
        return Story(way, tuple(bodies))

    def _bars(
        self,
        rng: np.random.Generator,
        stage: Stage,
        middle: np.ndarray,
        axes: np.ndarray,
        sizes: tuple[float, float],
    ) -> list[Body]:
        """Draw four bars around the window, and further upright bars beside it."""
        places = [(1, sizes[0]), (1, -sizes[0]), (2, sizes[1]), (2, -sizes[1])]
        for k in range(ranges.pick_count(rng, self.more)):
            places.append((1, (-1.0) ** k * (2 + k // 2) * sizes[0]))
        bodies = []
        for k, (across, far) in enumerate(places):
            shape = Capsule(stage.size(rng, self.bar), stage.size(rng, self.length))
            turned = axes_along(axes[:, 3 - across])
            bodies.append(solid(f"bar {k + 1}", shape, middle + far * axes[:, across], turned))
        return bodies

    def _shutter(
        self,
        rng: np.random.Generator,
        stage: Stage,
        way: Way,
        middle: np.ndarray,
        axes: np.ndarray,
        sizes: tuple[float, float],
    ) -> Body:
        """Draw a thick bar that slides over the window and has left it at the meeting."""
        k, radius = int(rng.integers(1, 3)), stage.size(rng, self.shutter)
        passes = ranges.pick(rng, self.passes) * way.when
        far = 1.1 * sizes[k - 1] + radius
        speed = ranges.pick_sign(rng) * far / (way.when - passes)
        shape = Capsule(radius, sizes[2 - k])
        turned = axes_along(axes[:, 3 - k])
        return solid("shutter", shape, middle, turned, when=passes, velocity=speed * axes[:, k])


@dataclass(frozen=True)
class GateChain(ChainFamily):
    """Two leaves of a gate slide apart before the hand, and some close again."""

    name = "gate-chain"
    summary = "a part behind a gate whose two leaves slide apart and may close again"

    behind: ranges.Range = ranges.span(0.05, 0.14, 0.01)
    """From the gate to the meeting [reaches]."""
    opening: ranges.Range = ranges.span(0.1, 0.17, 0.02)
    """Half the width when it is open [reaches]."""
    leaf: ranges.Range = ranges.span(0.15, 0.3, 0.02)
    """Half the width and the height of a leaf [reaches]."""
    begins: ranges.Range = ranges.span(0.0, 0.6, most=0.9)
    """Instant at which it starts to open [times of the meeting]."""
    opened: ranges.Range = ranges.span(0.92, 1.0, 0.91, 1.0)
    """Instant at which it is open [times of the meeting]."""
    closing: float = ranges.number(0.4)
    """Share of gates that close again after the meeting."""
    drift: ranges.Range = ranges.span(0.0, 0.15)
    """Speed of the part [reaches/s]."""

    def story(self, rng: np.random.Generator, stage: Stage) -> Story:
        """A part and two leaves."""
        way = self.way(rng, stage)
        course = stage.size(rng, self.drift) * unit_vector(rng.normal(size=3))
        bodies = [self.ball(rng, stage, way.meet, way.when, course)]
        axes, thin = facing(way), 0.012 * stage.arm.reach
        middle = way.meet - stage.size(rng, self.behind) * axes[:, 0]
        wide, high = (stage.size(rng, self.leaf) for _ in range(2))
        gap = stage.slot(rng, self.opening)
        k = int(rng.integers(1, 3))
        size = [thin, high, high]
        size[k] = wide
        begins, ends = (ranges.pick(rng, r) * way.when for r in (self.begins, self.opened))
        closes = rng.random() < self.closing
        for name, side in (("left leaf", 1.0), ("right leaf", -1.0)):
            by = side * gap * axes[:, k]
            leaf = solid(name, Box((size[0], size[1], size[2])), middle, axes)
            leaf = shifted(leaf, side * wide * axes[:, k])
            bodies.append(
                _closing(leaf, begins, ends, by, way.when)
                if closes
                else sliding(leaf, begins, ends, by)
            )
        return Story(way, tuple(bodies))


def _closing(leaf: Body, begins: float, ends: float, by: np.ndarray, when: float) -> Body:
    """A leaf that opens between two times and closes after the meeting, as fast [s]."""
    span = ends - begins
    stays = max(when + 0.05 * span, ends + 1e-3)
    laws = [(begins, by / span, STILL), (ends, STILL, STILL), (stays, -by / span, STILL)]
    if begins > 0.0:
        laws.insert(0, (0.0, STILL, STILL))
    return staged(leaf, [*laws, (stays + span, STILL, STILL)])
