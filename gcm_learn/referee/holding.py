"""Hand and target side by side: catches at an instant, and holds with proof at every instant.

Between two instants a vector stays as near to its chord as its second derivative allows.  Size,
distance to a convex solid and distance of two directions are greatest at an end of a chord.
"""

from __future__ import annotations

import math

import numpy as np

from gcm_learn.referee.chain import Geometry
from gcm_learn.referee.curves import Curve
from gcm_learn.referee.limits import point_bounds
from gcm_learn.referee.motions import Body, into
from gcm_learn.referee.rotations import Array, unit
from gcm_learn.referee.shapes import point_gaps
from gcm_learn.referee.tolerances import MOMENT, NEAR, WORK, Complaint


class Grip:
    """A hand beside a target along a movement, and the hold and approaches to keep.

    Columns hold the measures. They are the relative speed if the target has a hold, the distance
    to its solid, and for each approach the distance of two directions of length 1.
    """

    def __init__(
        self, geometry: Geometry, curve: Curve, hand: tuple[int, Array], axis: Array, body: Body
    ) -> None:
        self.geometry, self.curve, self.hand, self.body = geometry, curve, hand, body
        self.hold = body.given.get("hold")
        self.axes = [
            (unit(asked["hand"]) if "hand" in asked else axis, unit(asked["axis"]))
            for asked in body.approaches
        ]

    def complaints(
        self, grasp: float, slack: float, near: float, first: float, last: float
    ) -> list[Complaint]:
        """Return complaints about a catch that is held from first to last.

        Parameters
        ----------
        grasp : float
            Allowed distance, kept to `slack`.
        near : float
            What is granted to angles.
        """
        self.grasp = grasp
        most = self._most(slack, near)
        if last > first:
            return self._held(first, last, most)
        sides = np.array([-MOMENT, MOMENT]) if self.hold else np.zeros(1)
        values, _ = self._measured(np.full(len(sides), first), first + sides)
        best = (values - most).max(axis=1).argmin()  # one side suffices
        return self._words(values[best], most, first)

    def _most(self, slack: float, near: float) -> Array:
        """Return the most that is allowed of each column."""
        most = [] if self.hold is None else [self.hold["relative_speed"] * (1.0 + NEAR) + NEAR]
        most.append(self.grasp + slack)
        for asked in self.body.approaches:
            angle = asked["within"] + near * max(1.0, asked["within"])
            most.append(2.0 * math.sin(0.5 * angle) if angle < math.pi else math.inf)
        return np.array(most)

    def _held(self, first: float, last: float, most: Array) -> list[Complaint]:
        edges = self._edges(first, last)
        low, high, spent = edges[:-1], edges[1:], 0
        while len(low):
            spent += len(low)
            inside = 0.5 * (low + high)
            ends = [self._measured(t, inside) for t in (low, high)]
            values = np.maximum(ends[0][0], ends[1][0])
            if not (values <= most).all():
                row = int((values - most).max(axis=1).argmax())
                return self._words(values[row], most, float(low[row]))
            if spent > WORK:
                return [Complaint("catches", f"the hold of {self.body.name} cannot be decided")]
            bows = self._bows(inside, high - low, values, np.maximum(ends[0][1], ends[1][1]))
            kept = ~(values + bows <= most).all(axis=1)
            low, high, inside = low[kept], high[kept], inside[kept]
            low, high = np.concatenate([low, inside]), np.concatenate([inside, high])
        return []

    def _edges(self, first: float, last: float) -> Array:
        """Return times between which hand and target move smoothly."""
        breaks, knots = self.body.law.breaks, self.curve.knots
        breaks = breaks[(breaks > first + MOMENT) & (breaks < last - MOMENT)]
        knots = knots[(knots > first) & (knots < last)]
        return np.unique(np.concatenate([[first], breaks, knots, [last]]))

    def _measured(self, times: Array, inside: Array) -> tuple[Array, Array]:
        """Return the columns (k, m) at times (k,), and distances (k,) of hand and centre.

        Where pieces meet, those that hold at times `inside` (k,) count.
        """
        piece, _ = self.curve.pieces(inside)
        since = times - self.curve.knots[piece]
        joints, rates = self.curve.within(piece, since), self.curve.rates(piece, since)
        centre, turn, velocity, spin = self.body.law.states(times, inside)
        frames, origins = self.geometry.frames(joints)
        frame = frames[self.hand[0]]
        apart = origins[self.hand[0]] + frame @ self.hand[1] - centre
        columns = []
        if self.hold is not None:
            own = self.geometry.velocity(joints, rates, *self.hand)
            columns.append(np.linalg.norm(own - velocity - np.cross(spin, apart), axis=1))
        columns.append(point_gaps(self.body.shape, into(np.zeros(3), turn, apart)))
        columns += [np.linalg.norm(frame @ mine - turn @ its, axis=1) for mine, its in self.axes]
        return np.stack(columns, axis=1), np.linalg.norm(apart, axis=1)

    def _bows(self, inside: Array, span: Array, values: Array, apart: Array) -> Array:
        """Return bounds (k, m) by which columns exceed their values at both ends of intervals."""
        piece, _ = self.curve.pieces(inside)
        places, turns = point_bounds(self.geometry, self.curve, self.hand)
        (h1, h2, h3), (x, y, _) = [[b[piece] for b in bounds] for bounds in (places, turns)]
        (c1, c2, c3), (w, w1, w2) = self.body.law.most
        r1, r2 = h1 + c1, h2 + c2
        r = apart + span * r1
        eighth = span**2 / 8.0
        speed = (h3 + c3 + w2 * r + 2.0 * w1 * r1 + w * r2) * eighth
        place = (r2 + w1 * r + w * r1 + w * (values[:, 0] + speed)) * eighth
        angle = ((x + w) ** 2 + y + w1) * eighth
        return np.stack([speed, place, *[angle] * len(self.axes)], axis=1)

    def _words(self, values: Array, most: Array, at: float) -> list[Complaint]:
        """Return a complaint for each column whose value (m,) is above the most allowed."""
        name, words = self.body.name, []
        if self.hold is not None:
            asked = self.hold["relative_speed"]
            words.append(f"does not move with {name}: {values[0]:.9g} apart, allowed {asked:g}")
        away = values[len(words)]
        words.append(f"misses {name}: {away:.9g} away, grasp {self.grasp:g}")
        for asked in self.body.approaches:
            angle = 2.0 * math.asin(min(0.5 * values[len(words)], 1.0))
            within = asked["within"]
            words.append(f"approaches {name} at an angle of {angle:.9g}, allowed {within:g}")
        wrong = ~(values <= most)
        return [Complaint("catch_body", words[k], at) for k in np.flatnonzero(wrong)]
