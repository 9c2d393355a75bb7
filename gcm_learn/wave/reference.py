"""Both waves once more, slow and plain: what tests hold the kernels against.

The kernels are float32, step only the blocks of cells near the front, and search a span of time by
conservative advancement.  Each of these could go wrong without being seen.  Here the whole lattice
is stepped (`wave.stepping`), and every step is searched for arrivals.
"""

from __future__ import annotations

import numpy as np

from gcm_learn.charts import Lattice
from gcm_learn.scene import Scene
from gcm_learn.wave.excitation import FELT
from gcm_learn.wave.front import Front, first_arrivals
from gcm_learn.wave.inhibition import SADDLE, TICK
from gcm_learn.wave.kernels import CONTACT, FREE, FROZEN
from gcm_learn.wave.limits import fastest_in_plane
from gcm_learn.wave.params import EXCITED, HAND_POTENTIAL, REST, WaveParams
from gcm_learn.wave.solver import front_speed
from gcm_learn.wave.stepping import CORNERS, EDGES, Cell, Stepped, couplings
from gcm_learn.wave.waiting import free_clock

LOOK = 1.2  # the front is checked about this often [tau]


def propagate_reference(
    scene: Scene, lattice: Lattice, params: WaveParams, *, wait: bool = False
) -> Front:
    """Run the wave of Eq. 10 from the hand until contact or the horizon.

    Parameters
    ----------
    scene : Scene
    lattice : Lattice
        Of ``params.n`` cells a side.
    params : WaveParams
    wait : bool
        Obstacles inhibit while they are there, instead of freezing for ever.

    Returns
    -------
    Front
        As from `wave.propagate` or `wave.propagate_layers`, with arrivals in float64.
    """
    wave = (_Waiting if wait else _Freezing)(scene, lattice, params)
    start = wave.tau
    while wave.goes_on():
        for _ in range(2 * max(1, int(0.5 * LOOK / params.step + 1e-9))):
            wave.advance()
            wave.tau = start + wave.steps * params.step
        wave.look()
    return wave.front()


class _Freezing(Stepped):
    """The published wave: cells that an obstacle has met are frozen for ever."""

    def __init__(self, scene: Scene, lattice: Lattice, params: WaveParams) -> None:
        super().__init__(scene, lattice, params)
        self.live = self.inside.copy()
        self.state = np.full(lattice.shape, FREE, dtype=np.uint8)
        self.contact: tuple[float, int, int] | None = None  # when [tau], cell, body
        for i, (cell, when) in enumerate(self.disc()):
            self.r[cell], self.z[cell] = EXCITED if i > 0 else (HAND_POTENTIAL, self.z[cell])
            self.q[cell], self.arrival[cell] = self.q[cell] * (i > 0), when

    def goes_on(self) -> bool:
        """Return whether anything is left to do."""
        late = self.tau >= self.scene.limits.horizon / self.kappa
        return not late and (self.contact is None or self.params.until == "horizon")

    def passes_on(self, cell: Cell) -> bool:
        """Return whether a cell has been reached and passes the front on."""
        return bool(self.live[cell] and self.arrival[cell] >= 0.0)

    def look(self) -> None:
        """Record arrivals and apply Eq. 11 to them."""
        now = min(self.tau, self.scene.limits.horizon / self.kappa)
        new = self.live & (self.arrival < 0.0) & (self.r >= self.params.threshold)
        doors = {(i, j): self.next_door((i, j)) for i, j in np.argwhere(new).tolist()}
        since = {cell: time for cell, time in doors.items() if time >= 0.0}
        for cell, time in since.items():
            self.arrival[cell] = max(self.crossing[cell], time)
        contacts = []
        for cell, before in since.items():
            span, here = (before * self.kappa, now * self.kappa), np.array([cell])
            if any(self.near(b, here, self.instants(b, span)).any() for b in self.obstacles):
                self._take_out(cell, FROZEN)
                continue
            time, body = self._met(here, span)
            if body >= 0:
                self._take_out(cell, CONTACT)
                index = cell[0] * self.params.n + cell[1]
                contacts.append((max(time / self.kappa, float(self.arrival[cell])), index, body))
        if self.contact is None and contacts:
            self.contact = min(contacts)
        if self.insulates and since:
            self.coupled = couplings(self.live, self.params.laplacian)

    def _take_out(self, cell: Cell, state: int) -> None:
        self.state[cell], self.q[cell] = state, 0.0
        self.live[cell] = not self.insulates

    def _met(self, cell: np.ndarray, span: tuple[float, float]) -> tuple[float, int]:
        """First target near the hand in a span [s]: (time, body), body -1 if none."""
        first = (span[1], -1)
        for b in self.targets:
            times = self.instants(b, span)
            near = self.near(b, cell, times)[0]
            if near.any() and (first[1] < 0 or times[near][0] < first[0]):
                first = (float(times[near][0]), b)
        return first

    def front(self) -> Front:
        """Return the reached states."""
        time, cell, body = (-1.0, -1, -1) if self.contact is None else self.contact
        arrival = (self.arrival * self.kappa).ravel()
        met = (cell, body, time * self.kappa)
        state = self.state.ravel()
        return first_arrivals(
            self.lattice,
            arrival,
            state == FROZEN,
            state == CONTACT,
            met,
            horizon=self.scene.limits.horizon,
            steps=self.steps,
        )


class _Waiting(Stepped):
    """The wave that may wait: cells are inhibited while obstacles are there."""

    def __init__(self, scene: Scene, lattice: Lattice, params: WaveParams) -> None:
        super().__init__(scene, lattice, params)
        self.clock = free_clock(params) * (
            lattice.spacing / fastest_in_plane(scene)
        )  # [s] at every TICK
        self.slowness = 1.0 / front_speed(params).fastest
        self.seen = 0.0  # until when bodies have been checked [s]
        self.met = (scene.limits.horizon, -1, -1)  # when [s], state, body
        self.cells: list[Cell] = []
        self.via: list[int] = []
        self.spans: list[list[float]] = []
        shape = lattice.shape
        self.opened = np.zeros(shape)  # since when the cell is not inhibited
        self.date = np.full(shape, np.inf)  # when it is released
        self.asked = np.zeros(shape)  # since when an inhibited cell has to be checked [s]
        self.touched = np.full(shape, -1.0)  # when an obstacle was last there [s]
        self.inhibited, self.felt, self.refused = np.zeros((3, *shape), dtype=bool)
        self.latest = np.full(shape, -1)  # state, -1 if not reached
        self._set_out()

    def goes_on(self) -> bool:
        """Return whether anything is left to do."""
        end = self.scene.limits.horizon if self.params.until == "horizon" else self.met[0]
        return self.now < end

    def passes_on(self, cell: Cell) -> bool:
        """Return whether a cell has been reached and passes the front on."""
        return bool(self.latest[cell] >= 0)

    @property
    def now(self) -> float:
        """Time of the present look [s]."""
        return min(self.seconds(self.tau), self.scene.limits.horizon)

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

    def _set_out(self) -> None:
        """Excite the hand's cell and, as far as they are free, the cells around it."""
        for cell, when in self.disc():
            if self.cells:
                before = self.next_door(cell)
                if before < 0.0:
                    continue
                times = np.linspace(self.seconds(before), self.seconds(when), 200)
                if self._occupied(np.array([cell]), times).any():
                    self.refused[cell] = True
                    self._inhibit(cell, self.seconds(when))
                    continue
            self.r[cell], self.z[cell] = EXCITED if self.cells else (HAND_POTENTIAL, EXCITED[1])
            self._reach(cell, when, self._way_back(cell, when))
        self.q[self.cells[0]] = 0.0
        self._compare(self._times())

    def look(self) -> None:
        """Compare the lattice with the world: arrivals, meetings, inhibition, releases."""
        level, times = self.params.threshold, self._times()
        occupied = self._occupied(np.argwhere(self.inside), times)
        last = np.where(occupied, times, -1.0).max(axis=1)
        self.touched[self.inside] = np.maximum(self.touched[self.inside], last)
        crossed = self.inside & ~self.inhibited & (self.arrival < 0.0) & (self.r >= level)
        doors = {(i, j): self.next_door((i, j)) for i, j in np.argwhere(crossed).tolist()}
        since = {c: max(t, float(self.opened[c])) for c, t in doors.items() if t >= 0.0}
        when = {c: max(float(self.crossing[c]), t) for c, t in since.items()}
        via = {c: self._way_back(c, t) for c, t in when.items()}
        for cell in since:
            if self.seconds(when[cell]) > self.scene.limits.horizon:
                continue
            if self.touched[cell] >= self.seconds(since[cell]):
                self.refused[cell] = True
                self._inhibit(cell, self.now)
            else:
                self._reach(cell, when[cell], via[cell])
        for cell in doors.keys() - since.keys():  # charged by cells that are inhibited now
            if self.r[cell] > 0.5 * (level + EXCITED[0]):
                self.r[cell], self.z[cell] = REST
        feels = self.inside & (self.r >= FELT) & (self.arrival < 0.0) & ~self.felt
        self.felt |= feels
        here = np.zeros_like(self.inside)
        here[self.inside] = occupied[:, -1]
        for i, j in np.argwhere(feels & here & ~self.inhibited).tolist():
            self.refused[i, j] = True
            self._inhibit((i, j), self.now)
        self._compare(times, occupied)
        reached = self.inside & (self.arrival >= 0.0)
        fallen = reached & (self.r < min(level, SADDLE)) & (self.q > 0.0)
        self.r[fallen], self.q[fallen] = HAND_POTENTIAL, 0.0

    def _compare(self, times: np.ndarray, occupied: np.ndarray | None = None) -> None:
        """Find what obstacles and targets do to excited and inhibited cells at some times (m,)."""
        cells = np.argwhere(self.inside)
        occupied = self._occupied(cells, times) if occupied is None else occupied
        targets = self._targets(cells, times)
        due = np.argwhere(self.inhibited & (self.date <= self.tau)).tolist()
        for c, (i, j) in enumerate(cells.tolist()):
            s = self.latest[i, j]
            if s >= 0:
                hit = times[occupied[c] & (times >= self.spans[s][0])]
                if hit.size and self.spans[s][1] >= self.scene.limits.horizon:
                    stay = self.slowness * self.kappa if s == 0 else 0.0  # the hand has to leave
                    self.spans[s][1] = max(float(hit[0]), stay)
                self._meet(s, times, targets[c])
                if self.spans[s][1] < self.scene.limits.horizon and self.spans[s][1] <= self.now:
                    self._inhibit((i, j), self.spans[s][1])
            if self.inhibited[i, j] and self.date[i, j] == np.inf:
                free = times[~occupied[c] & (times >= self.asked[i, j])]
                if free.size:
                    self.date[i, j] = self.mental(float(free[0])) + 0.5 * self.slowness
        for i, j in due:
            self._release((i, j))
        live = self.inside & ~self.inhibited if self.insulates else self.inside
        self.coupled = couplings(live, self.params.laplacian)
        self.seen = self.now

    def _meet(self, s: int, times: np.ndarray, targets: np.ndarray) -> None:
        """Note a meeting in state s: a target (m,), -1 for none, is near at some of the times."""
        since = max(self.spans[s][0], 0.0)
        near = np.flatnonzero((targets >= 0) & (times >= since) & (times <= self.spans[s][1]))
        if near.size and times[near[0]] < self.met[0]:
            self.met = (float(times[near[0]]), s, int(targets[near[0]]))

    def _reach(self, cell: tuple[int, int], when: float, via: int) -> None:
        """Make a state of a cell that the front has come to at a mental time."""
        self.arrival[cell], self.latest[cell] = when, len(self.cells)
        self.cells.append(cell)
        self.via.append(via)
        self.spans.append([self.seconds(when), self.scene.limits.horizon])

    def _inhibit(self, cell: tuple[int, int], t: float) -> None:
        """Put a cell to rest from t [s] on."""
        self.inhibited[cell], self.felt[cell] = True, False
        self.arrival[cell], self.latest[cell] = -1.0, -1
        self.date[cell], self.asked[cell] = np.inf, t
        self.r[cell], self.z[cell], self.q[cell] = *REST, 0.0

    def _release(self, cell: tuple[int, int]) -> None:
        """Leave a cell, still at rest, to its neighbours again."""
        self.inhibited[cell], self.opened[cell] = False, self.tau
        self.r[cell], self.z[cell] = REST
        self.q[cell] = self.rate[cell]

    def _way_back(self, cell: tuple[int, int], when: float) -> int:
        """State of the neighbour to which arrivals fall off most steeply, -1 without one."""
        (y, x), best = cell, (-1.0, -1)
        for i, j in (*EDGES, *CORNERS):
            c = (y + i, x + j)
            through = i == 0 or j == 0 or self._passes((y + i, x)) or self._passes((y, x + j))
            if self._passes(c) and through and self.arrival[c] <= when:
                fall = (when - float(self.arrival[c])) / np.hypot(i, j)
                if fall > best[0]:
                    best = (fall, int(self.latest[c]))
        return best[1]

    def _passes(self, cell: Cell) -> bool:
        """Return whether a cell, maybe beyond the border, passes the front on."""
        return self.within(cell) and self.passes_on(cell)

    def _times(self) -> np.ndarray:
        """Times (m,) from the last look to this one so dense that no body goes far between two."""
        span = (self.seen, self.now)
        count = max(len(self.instants(b, span)) for b in range(len(self.scene.bodies.rows)))
        return np.linspace(*span, max(2, count))

    def _occupied(self, cells: np.ndarray, times: np.ndarray) -> np.ndarray:
        """Mark (c, m) at which times (m,) an obstacle touches the limbs of cells (c, 2)."""
        out = np.zeros((len(cells), len(times)), dtype=bool)
        for b in self.obstacles:
            out |= self.near(b, cells, times)
        return out

    def _targets(self, cells: np.ndarray, times: np.ndarray) -> np.ndarray:
        """Find the target that the hand would catch in cells (c, 2) at times (m,): (c, m) or -1."""
        out = np.full((len(cells), len(times)), -1)
        for b in self.targets:
            out[self.near(b, cells, times) & (out < 0)] = b
        return out

    def front(self) -> Front:
        """Return the reached states."""
        order = np.argsort([came for came, _ in self.spans], kind="stable")
        rank = np.append(np.argsort(order), -1)
        spans, cells = np.array(self.spans)[order], np.array(self.cells)[order]
        met = np.zeros(self.lattice.shape, dtype=bool)
        if self.met[1] >= 0:
            met[self.cells[self.met[1]]] = True
        return Front(
            chart=self.lattice,
            waits=True,
            nodes=np.ravel_multi_index(tuple(cells.T), self.lattice.shape),
            via=rank[np.array(self.via)[order]],
            arrival=spans[:, 0],
            end=spans[:, 1],
            refused=self.refused,
            met=met,
            met_state=int(rank[self.met[1]]),
            met_body=self.met[2],
            met_time=self.met[0],
            steps=self.steps,
        )
