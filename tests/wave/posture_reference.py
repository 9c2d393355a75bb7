"""The wave in space once more, slow and plain: what its kernel is held against.

The whole lattice is stepped in float64, nothing sleeps, all postures are known beforehand, and
limbs are asked about spheres at many instants.
"""

from __future__ import annotations

import itertools

import numpy as np

from gcm_learn.arms.spatial_limb import limb_at
from gcm_learn.scene.bodies import ACCELERATION, HAND, PART, POSITION, SIZE, TOP_SPEED, VELOCITY
from gcm_learn.wave.kernels import CONTACT, FREE, FROZEN
from gcm_learn.wave.params import EXCITED, HAND_POTENTIAL, REST
from gcm_learn.wave.posture_kernels import SPREAD
from gcm_learn.wave.posture_solver import (
    FEWEST,
    SLOWEST_RATE,
    START_BALL,
    kappa_in_space,
    mean_speed,
    quickest,
)
from tests.charts.steps import limbs_of

SIX = [d for d in itertools.product((-1, 0, 1), repeat=3) if np.abs(d).sum() == 1]


def shifted(a, d):
    """Every cell's neighbour at an offset (z, y, x); 0 beyond the border."""
    at = tuple(slice(1 + i, 1 + i + n) for i, n in zip(d, a.shape, strict=True))
    return np.pad(a, 1)[at]


class Reference:
    """A wave in space; arrays are (n, n, n), mental times in tau."""

    def __init__(self, scene, lattice, params):
        self.scene, self.lattice, self.params, shape = scene, lattice, params, lattice.shape
        self.kappa = kappa_in_space(scene, lattice, params)
        self.inside, self.limbs = lattice.inside.reshape(shape), limbs_of(lattice)
        self.live, self.state = self.inside.copy(), np.full(shape, FREE)
        self.r, self.z = np.full(shape, REST[0]), np.full(shape, REST[1])
        self.q, self.arrival = self.rates(), np.full(shape, -1.0)
        self.contact = (np.inf, -1, -1)
        self.tau = self.set_out()
        self.end = scene.limits.horizon / self.kappa

    def rates(self):
        """Mean speed over the steps from a cell, as a share of the front's."""
        joints = self.lattice.joints.reshape(*self.inside.shape, 4).astype(float)
        unit, total, count = self.lattice.spacing / quickest(self.scene, self.lattice), 0.0, 0.0
        for d in SIX:
            there = shifted(self.inside, d) & self.inside
            far = np.stack([shifted(joints[..., j], d) for j in range(4)], axis=-1)
            there = there & (np.abs(far - joints).max(axis=-1) <= self.lattice.nodes.leap)
            turning = (np.abs(far - joints) / self.scene.limits.joint_speed).max(axis=-1)
            total = total + there * np.minimum(unit / np.maximum(turning, 1e-300), 1.0)
            count = count + there
        rate = np.where(count > 0, np.maximum(total / np.maximum(count, 1), SLOWEST_RATE), 1.0)
        return rate * self.inside

    def set_out(self):
        limb, last, home = self.scene.limb, 0.0, None
        hand = np.array(limb_at(limb, limb.start)[3:])
        away = np.linalg.norm(self.lattice.hands - hand, axis=1) / self.lattice.spacing
        radius, excited = max(self.params.start_radius, START_BALL), 0
        for m in np.argsort(away, kind="stable"):
            cell = tuple(int(i) for i in np.unravel_index(m, self.inside.shape))
            enough = away[m] > radius and excited >= FEWEST
            if enough or away[m] > 2.0 * radius + SPREAD or not self.inside[cell]:
                continue
            if home is None:
                home = cell
                slowness = 1.0 / mean_speed(self.params, 0.5 * self.lattice.n) / self.q[cell]
                self.r[cell], self.q[cell], self.arrival[cell] = HAND_POTENTIAL, 0.0, 0.0
                continue
            before, when = self.next_door(cell), away[m] * slowness
            if before >= 0.0:
                (self.r[cell], self.z[cell]), self.arrival[cell] = EXCITED, when
                self.judge([(cell, before)], when)
                excited += self.state[cell] == FREE
                last = max(last, when)
        return last + slowness

    def run(self):
        """Go on to the horizon, or to the first contact."""
        p, looks, begin = self.params, 0, self.tau
        steps = 2 * max(1, int(0.6 / p.step + 1e-9))
        while self.tau < self.end and (self.contact[1] < 0 or p.until == "horizon"):
            self.crossing = np.full(self.r.shape, np.inf)
            for k in range(steps):
                self.advance(begin + (looks * steps + k) * p.step)
            looks += 1
            self.tau = begin + looks * steps * p.step
            self.look(min(self.tau, self.end))
        return self

    def advance(self, tau):
        p, r = self.params, self.r
        flow = sum((shifted(self.live, d) & self.live) * (shifted(r, d) - r) for d in SIX)
        change = (((4.0 - r) * r - 2.0) * r - 2.0) / 7.0 - self.z + p.diffusion * flow
        self.z = self.z + p.step * p.epsilon * self.q * (r - 7.0 * self.z - 2.0)
        self.r = r + p.step * self.q * change
        up = (r < p.threshold) & (self.r >= p.threshold)
        self.crossing[up] = tau + p.step * (p.threshold - r[up]) / (self.r[up] - r[up])

    def around(self, cell):
        """Neighbours of a cell that pass the front on, and whether a step leads from them."""
        n, joints, leap = self.r.shape[0], self.lattice.joints, self.lattice.nodes.leap
        near = [tuple(np.add(cell, d)) for d in SIX]
        near = [c for c in near if min(c) >= 0 and max(c) < n and self.live[c]]
        m = np.ravel_multi_index(cell, self.r.shape)
        for c in near:
            if self.arrival[c] >= 0.0:
                turn = np.abs(joints[m] - joints[np.ravel_multi_index(c, self.r.shape)])
                yield c, turn.max() <= leap

    def next_door(self, cell):
        return min((self.arrival[c] for c, step in self.around(cell) if step), default=-1.0)

    def look(self, now):
        new = self.live & (self.arrival < 0.0) & (self.r >= self.params.threshold)
        found = [(tuple(c), self.next_door(tuple(c))) for c in np.argwhere(new).tolist()]
        for cell, before in found:
            if before < 0.0 and any(True for _ in self.around(cell)):
                self.take_out(cell, FREE)  # it was stirred by cells from which no step leads to it
        found = [(cell, before) for cell, before in found if before >= 0.0]
        for cell, before in found:
            self.arrival[cell] = max(self.crossing[cell], before)
        self.judge(found, now)

    def judge(self, found, now):
        rows, h = self.scene.bodies.rows, self.lattice.spacing
        grasp = max(self.scene.limits.grasp, self.lattice.half_diagonal * h)
        for cell, before in found:
            m, span = np.ravel_multi_index(cell, self.r.shape), np.array([before, now]) * self.kappa
            for b in np.flatnonzero(rows[:, PART] != HAND):
                gap = self.scene.limb.thickness + self.params.margin * self.stride(cell)
                if (self.distances(b, m, self.instants(b, span)) <= gap).any():
                    self.take_out(cell, FROZEN)
                    break
            else:
                for b in np.flatnonzero(rows[:, PART] == HAND):
                    times = self.instants(b, span)
                    near = self.distances(b, m, times, hand=True) <= grasp
                    if near.any():
                        self.take_out(cell, CONTACT)
                        when = max(times[near][0], self.arrival[cell] * self.kappa)
                        self.contact = min(self.contact, (when, m, b))

    def stride(self, cell):
        """Half the elbow's way from neighbours that have been reached, at least half a step."""
        m, ways = np.ravel_multi_index(cell, self.r.shape), [0.5 * self.lattice.spacing]
        for c, _ in self.around(cell):
            other = self.limbs[np.ravel_multi_index(c, self.r.shape), 1]
            ways.append(0.5 * np.linalg.norm(self.limbs[m, 1] - other))
        return min(max(ways), 2.0 * self.lattice.spacing)

    def take_out(self, cell, state):
        self.state[cell], self.live[cell], self.q[cell] = state, False, 0.0

    def instants(self, b, span):
        way = self.scene.bodies.rows[b, TOP_SPEED] * (span[1] - span[0])
        return np.linspace(*span, 2 + int(way / (0.02 * self.lattice.spacing)))

    def distances(self, b, m, times, hand=False):
        row, t = self.scene.bodies.rows[b], times[:, None]
        centre = row[POSITION:][:3] + row[VELOCITY:][:3] * t + 0.5 * row[ACCELERATION:][:3] * t**2
        joints = self.limbs[m, -1:].repeat(2, axis=0) if hand else self.limbs[m]
        away = [from_bone(centre, *ends) for ends in itertools.pairwise(joints)]
        return np.min(away, axis=0) - row[SIZE]


def from_bone(points, a, b):
    """Distances (k,) of points (k, 3) to the segment from a to b."""
    along, size = b - a, max(float((b - a) @ (b - a)), 1e-300)
    share = np.clip((points - a) @ along / size, 0.0, 1.0)
    return np.linalg.norm(points - a - share[:, None] * along, axis=1)
