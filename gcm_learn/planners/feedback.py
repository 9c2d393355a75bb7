"""Lessons of failed attempts for the next map of the same situation."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from gcm_learn.charts import Chart
from gcm_learn.maps import CognitiveMap
from gcm_learn.motion import Verdict
from gcm_learn.planners.completion import Attempt
from gcm_learn.scene import Scene
from gcm_learn.wave import fastest

WIDER = (
    0.5  # added to the margin around a touch, in units of what half a cell's step moves the limb
)
AROUND = 1.6  # how far a touch widens [cells]
NEAR = 2.0  # touches nearer together than this widen ever farther [cells]


@dataclass(frozen=True)
class Exploration:
    """A map, and paths that end at the map's interception."""

    map: CognitiveMap
    attempts: Iterable[Attempt] = ()
    """Not verified, the most promising first; made on demand."""
    arrived: float = 0.0
    """Instant at which the hand is where the interception is [s]."""
    shared: float = 0.0
    """Instant until which all attempts are the same [s]."""


@dataclass(frozen=True)
class Feedback:
    """Lessons from failed attempts at a situation, for maps on one lattice.

    A limb that is touched on its path passes between the centres of cells where their neighbourhood
    is not free.  The cells around get a wider margin, and the front goes round or waits.  An
    interception is passed over if the path to it holds but none that ends it, or if the front
    comes to it again.
    """

    beyond: float = 0.0
    """Time after the horizon at which the front stops [crossings of a cell]."""
    ignore: float = 0.0
    """Interceptions before this time do not count [s]."""
    widening: np.ndarray | None = None
    """Margin (nodes,) on top of the usual one."""
    touches: tuple[tuple[float, ...], ...] = ()
    """Places of the hand when the limb was touched [forearm lengths]."""
    passed_over: int = 0
    """Number of interceptions."""
    met: float = -1.0
    """Time of the last map's interception [s]."""

    def applied(self, scene: Scene, chart: Chart) -> Scene:
        """A scene with the horizon at which the front stops."""
        horizon = scene.limits.horizon + self.beyond * chart.spacing / fastest(scene)
        return scene._replace(limits=scene.limits._replace(horizon=horizon))

    def after(
        self, found: Exploration, failures: list[tuple[Attempt, Verdict]], speed: float
    ) -> Feedback:
        """Return the feedback after all attempts at an interception have failed.

        `speed` is the hand's [forearm lengths / s].
        """
        assert found.map.interception is not None
        met = found.map.interception.time
        touched = [(v.collision_time, a) for a, v in failures if v.collision_time is not None]
        when, attempt = min(touched, key=lambda touch: touch[0], default=(np.inf, None))
        feedback = replace(self, met=met)
        if attempt is not None and when < found.arrived:
            feedback = feedback._wider(found.map.chart, attempt, when)
            if met != self.met:
                return feedback
        # Nothing to widen, or the last widening has not moved the interception.  Those that fail
        # come in rows: skip ever more of them.
        crossing = found.map.chart.spacing / speed
        ignore = met + 2**self.passed_over * crossing
        return replace(feedback, ignore=ignore, passed_over=self.passed_over + 1)

    def _wider(self, chart: Chart, attempt: Attempt, when: float) -> Feedback:
        """Widen the margin of the nodes around the hand at some time."""
        path, h = attempt.trajectory, chart.spacing
        hand = tuple(float(np.interp(when, path.time, x)) for x in path.hand.T)
        apart = [float(np.hypot.reduce(np.subtract(hand, other))) for other in self.touches]
        again = sum(away < NEAR * h for away in apart)
        away = np.abs(chart.hands - hand).max(axis=1)
        widening = np.zeros(away.size) if self.widening is None else self.widening
        widening = widening + WIDER * (away < (AROUND + again) * h)
        return replace(self, widening=widening, touches=(*self.touches, hand))
