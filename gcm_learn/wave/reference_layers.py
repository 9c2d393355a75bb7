"""The wave that may wait once more, slow and plain: what tests hold `wave.excitation` against.

The whole lattice is stepped in float64, and at every look all cells are asked for obstacles and
targets at many instants since the last one.  There is no calendar, no conservative advancement,
no block that sleeps.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from gcm_learn.handspace.lattice import hand_space
from gcm_learn.scene import bodies as k
from gcm_learn.wave.excitation import FELT
from gcm_learn.wave.inhibition import SADDLE, TICK
from gcm_learn.wave.params import EXCITED, HAND_POTENTIAL, REST, WaveParams
from gcm_learn.wave.reference import (
    CORNERS,
    EDGES,
    FINENESS,
    LOOK,
    Couplings,
    couplings,
    distances,
    euler_step,
    instants,
)
from gcm_learn.wave.solver import (
    CONTACT_RADIUS,
    LayeredFront,
    front_speed,
    kappa_of,
    rates_of,
)
from gcm_learn.wave.task import Task
from gcm_learn.wave.waiting import free_clock, start_disc


def propagate_layers_reference(task: Task, params: WaveParams) -> LayeredFront:
    """Run the wave until a target is met or the horizon; obstacles inhibit while they are there.

    Parameters
    ----------
    task : Task
        Its lattice must have ``params.n`` cells a side.
    params : WaveParams

    Returns
    -------
    LayeredFront
        As from `wave.propagate_layers`.
    """
    wave = _Wave.at_rest(task, params)
    wave.set_out()
    steps_a_look = 2 * max(1, int(0.5 * LOOK / params.step + 1e-9))
    start, steps = wave.tau, 0
    while wave.now < task.horizon and (params.until == "horizon" or wave.now < wave.met[0]):
        for _ in range(steps_a_look):
            wave.advance()
            steps += 1
            wave.tau = start + steps * params.step
        wave.look()
    return wave.front()


@dataclass
class _Wave:
    """The lattice while it is being stepped; arrays are (n, n), mental times in tau."""

    task: Task
    params: WaveParams
    clock: np.ndarray  # [s] at every TICK
    kappa: float
    slowness: float
    inside: np.ndarray
    limb: np.ndarray  # (n, n, 4)
    gap: np.ndarray
    r: np.ndarray
    z: np.ndarray
    q: np.ndarray
    coupled: Couplings
    tau: float = 0.0
    seen: float = 0.0  # until when bodies have been looked at [s]
    met: tuple[float, int, int] = (0.0, -1, -1)  # when [s], state, body
    cells: list[tuple[int, int]] = field(default_factory=list)
    via: list[int] = field(default_factory=list)
    spans: list[list[float]] = field(default_factory=list)
    arrays: dict[str, np.ndarray] = field(default_factory=dict)

    @classmethod
    def at_rest(cls, task: Task, params: WaveParams) -> _Wave:
        """A lattice at rest."""
        n, space = params.n, hand_space(task.lattice)
        inside, kappa = space.inside.reshape(n, n), kappa_of(task, params)
        rest = REST if params.start == "rest" else (0.0, 0.0)
        wave = cls(
            task,
            params,
            free_clock(params) * (task.lattice.spacing / task.fastest),
            kappa,
            1.0 / front_speed(params).fastest,
            inside,
            space.limb.reshape(n, n, 4),
            task.gaps(params.margin).reshape(n, n),
            np.full((n, n), rest[0]),
            np.full((n, n), rest[1]),
            inside * rates_of(task).reshape(n, n),
            couplings(inside, params.laplacian),
        )
        wave.met = (task.horizon, -1, -1)
        for name, value in (
            ("arrival", -1.0),  # in the present interval, negative if not reached
            ("crossing", -1.0),  # last upward crossing of the threshold
            ("opened", 0.0),  # since when the cell is not inhibited
            ("date", np.inf),  # when it is released
            ("asked", 0.0),  # since when an inhibited cell has to be looked at [s]
            ("touched", -1.0),  # when an obstacle was last there [s]
        ):
            wave.arrays[name] = np.full((n, n), value)
        wave.arrays["inhibited"] = np.zeros((n, n), dtype=bool)
        wave.arrays["felt"] = np.zeros((n, n), dtype=bool)
        wave.arrays["refused"] = np.zeros((n, n), dtype=bool)
        wave.arrays["latest"] = np.full((n, n), -1)
        return wave

    @property
    def now(self) -> float:
        """Time of the present look [s]."""
        return min(self.seconds(self.tau), self.task.horizon)

    def seconds(self, tau: float) -> float:
        """Time at a mental time [s]."""
        last = (len(self.clock) - 1) * TICK
        if tau >= last:
            return float(self.clock[-1] + (tau - last) * self.kappa)
        return float(np.interp(tau, TICK * np.arange(len(self.clock)), self.clock))

    def mental(self, t: float) -> float:
        """Mental time at a time [tau]."""
        if t >= self.clock[-1]:
            return float((len(self.clock) - 1) * TICK + (t - self.clock[-1]) / self.kappa)
        return float(np.interp(t, self.clock, TICK * np.arange(len(self.clock))))

    def set_out(self) -> None:
        """Excite the hand's cell and, as far as they are free, the cells around it."""
        a = self.arrays
        self.tau = self.params.start_radius * self.slowness
        for index, away in zip(*start_disc(self.task, self.params), strict=True):
            cell, when = divmod(int(index), self.params.n), float(away) * self.slowness
            if self.cells:
                before = self._next_door(cell)
                if before < 0.0:
                    continue
                times = np.linspace(self.seconds(before), self.seconds(when), 200)
                if self._occupied(np.array([cell]), times).any():
                    a["refused"][cell] = True
                    self._inhibit(cell, self.seconds(when))
                    continue
            self.r[cell], self.z[cell] = EXCITED if self.cells else (HAND_POTENTIAL, EXCITED[1])
            self._reach(cell, when, self._way_back(cell, when))
        self.q[self.cells[0]] = 0.0
        self._compare(self._instants())

    def advance(self) -> None:
        """Step the whole lattice once and note where the threshold was crossed."""
        before, level = self.r, self.params.threshold
        self.r, self.z = euler_step(before, self.z, self.q, self.coupled, self.params)
        up = (before < level) & (self.r >= level)
        share = (level - before[up]) / (self.r[up] - before[up])
        self.arrays["crossing"][up] = self.tau + share * self.params.step

    def look(self) -> None:
        """Compare the lattice with the world: arrivals, meetings, inhibition, releases."""
        a, level, times = self.arrays, self.params.threshold, self._instants()
        occupied = self._occupied(np.argwhere(self.inside), times)
        last = np.where(occupied, times, -1.0).max(axis=1)
        a["touched"][self.inside] = np.maximum(a["touched"][self.inside], last)
        crossed = self.inside & ~a["inhibited"] & (a["arrival"] < 0.0) & (self.r >= level)
        doors = {(i, j): self._next_door((i, j)) for i, j in np.argwhere(crossed).tolist()}
        since = {c: max(t, float(a["opened"][c])) for c, t in doors.items() if t >= 0.0}
        when = {c: max(float(a["crossing"][c]), t) for c, t in since.items()}
        via = {c: self._way_back(c, t) for c, t in when.items()}
        for cell in since:
            if self.seconds(when[cell]) > self.task.horizon:
                continue
            if a["touched"][cell] >= self.seconds(since[cell]):
                a["refused"][cell] = True
                self._inhibit(cell, self.now)
            else:
                self._reach(cell, when[cell], via[cell])
        for cell in doors.keys() - since.keys():  # charged by cells that are inhibited now
            if self.r[cell] > 0.5 * (level + EXCITED[0]):
                self.r[cell], self.z[cell] = REST
        feels = self.inside & (self.r >= FELT) & (a["arrival"] < 0.0) & ~a["felt"]
        a["felt"] |= feels
        here = np.zeros_like(self.inside)
        here[self.inside] = occupied[:, -1]
        for i, j in np.argwhere(feels & here & ~a["inhibited"]).tolist():
            a["refused"][i, j] = True
            self._inhibit((i, j), self.now)
        self._compare(times, occupied)
        reached = self.inside & (a["arrival"] >= 0.0)
        fallen = reached & (self.r < min(level, SADDLE)) & (self.q > 0.0)
        self.r[fallen], self.q[fallen] = HAND_POTENTIAL, 0.0

    def _compare(self, times: np.ndarray, occupied: np.ndarray | None = None) -> None:
        """Find what obstacles and targets do to excited and inhibited cells at some times (m,)."""
        a, cells = self.arrays, np.argwhere(self.inside)
        occupied = self._occupied(cells, times) if occupied is None else occupied
        targets = self._targets(cells, times)
        due = np.argwhere(a["inhibited"] & (a["date"] <= self.tau)).tolist()
        for c, (i, j) in enumerate(cells.tolist()):
            s = a["latest"][i, j]
            if s >= 0:
                hit = times[occupied[c] & (times >= self.spans[s][0])]
                if hit.size and self.spans[s][1] >= self.task.horizon:
                    stay = self.slowness * self.kappa if s == 0 else 0.0  # the hand has to leave
                    self.spans[s][1] = max(float(hit[0]), stay)
                self._meet(s, times, targets[c])
                if self.spans[s][1] < self.task.horizon and self.spans[s][1] <= self.now:
                    self._inhibit((i, j), self.spans[s][1])
            if a["inhibited"][i, j] and a["date"][i, j] == np.inf:
                free = times[~occupied[c] & (times >= a["asked"][i, j])]
                if free.size:
                    a["date"][i, j] = self.mental(float(free[0])) + 0.5 * self.slowness
        for i, j in due:
            self._release((i, j))
        live = self.inside & ~a["inhibited"] if self._insulates else self.inside
        self.coupled = couplings(live, self.params.laplacian)
        self.seen = self.now

    @property
    def _insulates(self) -> bool:
        return self.params.frozen == "insulating"

    def _meet(self, s: int, times: np.ndarray, targets: np.ndarray) -> None:
        """Note a meeting in state s: a target (m,), -1 for none, is near at some of the times."""
        since = max(self.spans[s][0], self.task.ignore)
        near = np.flatnonzero((targets >= 0) & (times >= since) & (times <= self.spans[s][1]))
        if near.size and times[near[0]] < self.met[0]:
            self.met = (float(times[near[0]]), s, int(targets[near[0]]))

    def _reach(self, cell: tuple[int, int], when: float, via: int) -> None:
        """Make a state of a cell that the front has come to at a mental time."""
        self.arrays["arrival"][cell], self.arrays["latest"][cell] = when, len(self.cells)
        self.cells.append(cell)
        self.via.append(via)
        self.spans.append([self.seconds(when), self.task.horizon])

    def _inhibit(self, cell: tuple[int, int], t: float) -> None:
        """Put a cell to rest from t [s] on."""
        a = self.arrays
        a["inhibited"][cell], a["felt"][cell] = True, False
        a["arrival"][cell], a["latest"][cell] = -1.0, -1
        a["date"][cell], a["asked"][cell] = np.inf, t
        self.r[cell], self.z[cell], self.q[cell] = *REST, 0.0

    def _release(self, cell: tuple[int, int]) -> None:
        """Leave a cell, still at rest, to its neighbours again."""
        a = self.arrays
        a["inhibited"][cell], a["opened"][cell] = False, self.tau
        self.r[cell], self.z[cell] = REST
        self.q[cell] = rates_of(self.task).reshape(self.q.shape)[cell]

    def _excited(self, cell: tuple[int, int]) -> bool:
        """Whether a cell, maybe beyond the border, has been reached and passes the front on."""
        i, j = cell
        n = self.params.n
        return 0 <= i < n and 0 <= j < n and self.arrays["latest"][i, j] >= 0

    def _next_door(self, cell: tuple[int, int]) -> float:
        """Earliest arrival at an edge neighbour [tau], -1 if none is excited."""
        near = [(cell[0] + i, cell[1] + j) for i, j in EDGES]
        times = [float(self.arrays["arrival"][c]) for c in near if self._excited(c)]
        return min(times, default=-1.0)

    def _way_back(self, cell: tuple[int, int], when: float) -> int:
        """State of the neighbour to which arrivals fall off most steeply, -1 if there is none."""
        (y, x), best = cell, (-1.0, -1)
        for i, j in (*EDGES, *CORNERS):
            c = (y + i, x + j)
            through = i == 0 or j == 0 or self._excited((y + i, x)) or self._excited((y, x + j))
            if self._excited(c) and through and self.arrays["arrival"][c] <= when:
                fall = (when - float(self.arrays["arrival"][c])) / np.hypot(i, j)
                if fall > best[0]:
                    best = (fall, int(self.arrays["latest"][c]))
        return best[1]

    def _instants(self) -> np.ndarray:
        """Times (m,) from the last look to this one so dense that no body goes far between two."""
        bodies, step = self.task.bodies, FINENESS * self.task.lattice.spacing
        spans = [instants(bodies, b, (self.seen, self.now), step) for b in range(len(bodies.rows))]
        return np.linspace(self.seen, self.now, max(2, *(len(times) for times in spans)))

    def _near(self, b: int, cells: np.ndarray, times: np.ndarray, gap: np.ndarray) -> np.ndarray:
        """Whether body b is within a gap (c,) of limbs, for cells (c, 2) and times (m,): (c, m)."""
        bodies, limbs = self.task.bodies, self.limb[cells[:, 0], cells[:, 1]]
        row = bodies.rows[b]
        if row[k.KIND] != k.DISC:
            dense = np.array([distances(bodies, b, limb, times) for limb in limbs])
            return dense <= gap[:, None]
        t = times[:, None]
        centre = row[k.POSITION :][:2] + row[k.VELOCITY :][:2] * t
        centre += 0.5 * row[k.ACCELERATION :][:2] * t**2
        hand, elbow = limbs[:, None, :2], limbs[:, None, 2:]
        if row[k.PART] == k.HAND:
            away = np.linalg.norm(centre - hand, axis=-1)
        else:
            upper_arm = _from_segments(centre, np.zeros_like(elbow), elbow)
            away = np.minimum(_from_segments(centre, elbow, hand), upper_arm)
        return away - row[k.SIZE] <= gap[:, None]

    def _occupied(self, cells: np.ndarray, times: np.ndarray) -> np.ndarray:
        """Whether an obstacle touches the limbs of cells (c, 2) at times (m,): (c, m) bool."""
        out, gap = np.zeros((len(cells), len(times)), dtype=bool), self.gap[tuple(cells.T)]
        for b in np.flatnonzero(self.task.bodies.rows[:, k.PART] != k.HAND).tolist():
            out |= self._near(b, cells, times, gap)
        return out

    def _targets(self, cells: np.ndarray, times: np.ndarray) -> np.ndarray:
        """Which target the hand would catch in cells (c, 2) at times (m,): (c, m), -1 if none."""
        h = self.task.lattice.spacing
        reach = max(self.task.grasp + self.params.slack * h, CONTACT_RADIUS * h)
        out = np.full((len(cells), len(times)), -1)
        for b in np.flatnonzero(self.task.bodies.rows[:, k.PART] == k.HAND).tolist():
            near = self._near(b, cells, times, np.full(len(cells), reach))
            out[near & (out < 0)] = b
        return out

    def front(self) -> LayeredFront:
        """What was reached."""
        order = np.argsort([came for came, _ in self.spans], kind="stable")
        rank = np.append(np.argsort(order), -1)
        spans = np.array(self.spans)[order]
        return LayeredFront(
            cells=np.array(self.cells)[order],
            via=rank[np.array(self.via)[order]],
            arrival=spans[:, 0],
            end=spans[:, 1],
            met_state=int(rank[self.met[1]]),
            met_body=self.met[2],
            met_time=self.met[0],
            refused=self.arrays["refused"],
        )


def _from_segments(points: np.ndarray, a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Distances (c, m) of points (m, 2) to segments from a to b (c, 1, 2)."""
    along = b - a
    share = ((points - a) * along).sum(-1) / (along * along).sum(-1)
    nearest = a + np.clip(share, 0.0, 1.0)[..., None] * along
    return np.linalg.norm(points - nearest, axis=-1)
