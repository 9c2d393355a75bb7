"""A gripper: a weld of hand and target that closes at the end of a hold and opens at the place."""

from __future__ import annotations

from math import ceil
from typing import Any, NamedTuple

import numpy as np

from gcm_learn.arms import quaternion_of, rotation_of
from gcm_learn.execution.arena.kernels.world import CAUGHT, GONE, RUNNING
from gcm_learn.execution.arena.pool import Catch
from gcm_learn.execution.body.laws import Laws
from gcm_learn.execution.body.model import LINK, STEP, mujoco
from gcm_learn.execution.body.plant import PhysicalPlant
from gcm_learn.execution.loop.joint_leading import Gripping
from gcm_learn.motion import Movement
from gcm_learn.scene import PART

HAIR = 1e-6  # share of a step by which a grip may come before its time
BLOW = 0.01
"""Time in which a weld stops what moves in the hand [s]; most of it takes a single step."""


class Gripped(NamedTuple):
    """Result of a grip."""

    closed: float
    """When the gripper closed [s]."""
    opened: float | None
    """When it put the target down [s]."""
    off_place: float | None
    """Distance of the target from its place then [m]."""
    impulse: float | None = None
    """Force on the target over `BLOW`, less what carrying it takes [N s]."""
    torque: float | None = None
    """Largest torque that this puts on a joint [N m; N for a prismatic joint]."""


class GrippingPlant(PhysicalPlant):
    """An arm with a gripper.

    Targets go their own way until the gripper closes, and touch nothing. It closes where a movement
    says so (`Gripping`), about a target that is within grasp: a weld holds the target where it is
    in the hand. When the gripper opens, the target rests where it is. Caught is what is gripped, or
    put down within its place where it has one. A carried target collides as a link does.
    """

    grips = True

    def begin(self) -> None:
        """Go back to t = 0, the gripper open."""
        self.over = 0
        """Step at which the last target was gripped or put down."""
        self.closed: dict[str, int] = {}
        """Targets that were gripped, and after how many steps."""
        self.opened: dict[str, int] = {}
        """Targets that were put down, and after how many steps."""
        self._within: dict[int, int] = {}  # steps at which targets first were within grasp
        self._levers = np.empty((6, 0))  # torques of joints by a wrench on the last target (6, n)
        super().begin()
        tables = (self._laws.targets.copy(), self._laws.moves.copy())
        self._law = Laws(self._laws.obstacles, self._laws.turns, *tables)

    @property
    def ended(self) -> int:
        """As `PhysicalPlant` says; the last catch ends as the target is gripped or put down."""
        return self.over if self.outcome == CAUGHT else super().ended

    @property
    def carries(self) -> set[str]:  # type: ignore[override]
        """Targets in the hand."""
        return self.closed.keys() - self.opened.keys()

    def follow(self, plan: Movement, until: float) -> None:
        """Follow a plan with its grips, until a time [s] or the end of the episode."""
        going, acts = self.outcome == RUNNING, []
        for grip in plan.grips if isinstance(plan, Gripping) else ():
            for after, act in ((grip.closes, self._close), (grip.opens, self._open)):
                if after is not None:
                    acts.append((ceil((plan.time[0] + after) / STEP - HAIR), grip.body, act))
        for step, name, act in sorted(acts, key=lambda one: one[0]):
            if self.steps < step <= round(until / STEP):
                super().follow(plan, step * STEP)
                if self.steps == step:
                    act(name)
                if going and self.outcome != RUNNING:
                    return
        super().follow(plan, until)

    def _close(self, name: str) -> None:
        """Weld a target to the hand, if it is within grasp."""
        b, k, library, data = self.number_of(name), self.steps, mujoco(), self._data
        if b not in self._within or name in self.closed or not self.holds(name, k, k):
            return
        j, m = self._numbers.index(b), self._coupling.size
        data.qpos[m + 7 * j : m + 7 * j + 7] = self._law.targets[k, 7 * j : 7 * j + 7]
        data.qvel[m + 6 * j : m + 6 * j + 6] = self._law.moves[k, 6 * j : 6 * j + 6]
        library.mj_kinematics(self._model, data)
        library.mj_comPos(self._model, data)
        weld, levers = self._model.eq(f"grip{b}"), np.zeros((6, self._model.nv))
        hand, target = int(weld.obj1id[0]), int(weld.obj2id[0])
        turns = [data.xmat[body].reshape(3, 3) for body in (hand, target)]
        place = turns[0].T @ (data.xpos[target] - data.xpos[hand])
        self._model.eq_data[weld.id, 3:10] = [*place, *quaternion_of(turns[0].T @ turns[1])]
        data.eq_active[weld.id] = 1
        library.mj_jac(self._model, data, levers[:3], levers[3:], data.xpos[target], hand)
        levers[3:] = turns[1].T @ levers[3:]
        self._levers = levers[:, :m] @ self._coupling.factors
        self.closed[name] = k
        self._held.remove(j)
        if self.situation.bodies[b].place is None:
            self._succeed(b)

    def _open(self, name: str) -> None:
        """Put down a target; it rests from now on."""
        if name not in self.carries:
            return
        b, k = self.number_of(name), self.steps
        j = self._numbers.index(b)
        self.opened[name] = k
        self._data.eq_active[self._model.eq(f"grip{b}").id] = 0
        self._gone[j], self._held = k, sorted({*self._held, j})
        self._law.targets[:, 7 * j : 7 * j + 7] = self.targets_log[k, 7 * j : 7 * j + 7]
        self._law.moves[:, 6 * j : 6 * j + 6] = 0.0
        place: Any = self.situation.bodies[b].place
        if self._off_place(name) <= place.within * self.body.metres:
            self._succeed(b)

    def _off_place(self, name: str) -> float:
        """Return the distance of a target from its place when it was put down [m]."""
        b, base = self.number_of(name), self.situation.arm.base
        place: Any = self.situation.bodies[b].place
        away, j = np.array(place.position) - np.array(base.origin), self._numbers.index(b)
        here = self.targets_log[self.opened[name], 7 * j : 7 * j + 3]
        return float(np.linalg.norm(here - self.body.metres * rotation_of(base.rotation).T @ away))

    @property
    def gripped(self) -> Gripped | None:
        """Result of the last grip, or None; impulse and torque are set once the blow is over."""
        if not self.closed:
            return None
        (*_, (name, at)), n = self.closed.items(), round(BLOW / STEP)
        j, opened = 6 * self._numbers.index(self.number_of(name)), self.opened.get(name)
        off = None if opened is None else self._off_place(name)
        told = Gripped(at * STEP, None if opened is None else opened * STEP, off)
        if self.steps < at + 2 * n:
            return told
        loads = self.loads_log[at : at + 2 * n, j : j + 6]
        pulls = loads[:n] - loads[n:].mean(axis=0)
        impulse = np.linalg.norm(pulls[:, :3].sum(axis=0)) * STEP
        torque = np.abs(pulls @ self._levers).max()
        return told._replace(impulse=float(impulse), torque=float(torque))

    def _met(self, b: int, k: int) -> None:
        """Note that target b is within grasp at step k; it is not caught before it is gripped."""
        self._within[b] = k
        self._scene.bodies.rows[b, PART] = GONE

    def _succeed(self, b: int) -> None:
        """Note a catch."""
        self.catches.append(Catch(self.situation.bodies[b].name, self._within[b] * STEP))
        self.over = self.steps
        if self.outcome == RUNNING and len(self.catches) == self.wanted.most:
            self.outcome = CAUGHT

    def _contacts(self) -> tuple[int | None, list[int]]:
        """As `PhysicalPlant` says; a target touches obstacles only while it is carried."""
        limb, carried = None, self.carries
        for geoms in self._data.contact.geom.tolist():
            first, second = sorted(self._codes[geom] for geom in geoms)
            if first == LINK:
                limb = second
            elif carried & {self.situation.bodies[b].name for b in (first, second)}:
                limb = first if second in self._numbers else second
        return limb, []
