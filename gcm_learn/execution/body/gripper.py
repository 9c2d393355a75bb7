"""A gripper: a weld of hand and target that closes at the end of a hold and opens at the place."""

from __future__ import annotations

from collections.abc import Callable
from math import ceil
from typing import Any, NamedTuple

import numpy as np

from gcm_learn.arms import rotation_of
from gcm_learn.execution.arena.kernels.world import CAUGHT, GONE, RUNNING
from gcm_learn.execution.arena.pool import Catch
from gcm_learn.execution.body.laws import Laws
from gcm_learn.execution.body.model import LINK, STEP, mujoco
from gcm_learn.execution.body.plant import PhysicalPlant
from gcm_learn.execution.loop.joint_leading import Gripping
from gcm_learn.motion import Movement
from gcm_learn.scene import PART

HAIR = 1e-6
"""Share of a step by which a grip may come before its time."""
BLOW = 0.01
"""Time in which a weld stops what moves in the hand [s]; most of it takes a single step."""


class Blow(NamedTuple):
    """Effect of hand and target on each other as the gripper closes."""

    impulse: float
    """Force on the target over time, less what carrying it takes [N s]."""
    torque: float
    """Largest torque that it puts on a joint [N m; N for a prismatic joint]."""


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
        self._levers: dict[int, np.ndarray] = {}  # torques of joints by wrenches on targets (6, n)
        super().begin()
        tables = (self._laws.targets.copy(), self._laws.moves.copy())
        self._law = Laws(self._laws.obstacles, self._laws.turns, *tables)

    @property
    def ended(self) -> int:
        """As `PhysicalPlant` says; the last catch ends as the target is gripped or put down."""
        return self.over if self.outcome == CAUGHT else super().ended

    def follow(self, plan: Movement, until: float) -> None:
        """Follow a plan until a time [s] or until it is over; grip and put down as it says."""
        going = self.outcome == RUNNING
        for step, name, act in self._acts(plan):
            if self.steps < step <= round(until / STEP):
                super().follow(plan, step * STEP)
                if self.steps == step:
                    act(name)
                if going and self.outcome != RUNNING:
                    return
        super().follow(plan, until)

    def _acts(self, plan: Movement) -> list[tuple[int, str, Callable[[str], None]]]:
        """Return the steps after which the gripper closes and opens, in order."""
        acts = []
        for grip in plan.grips if isinstance(plan, Gripping) else ():
            for after, act in ((grip.closes, self._close), (grip.opens, self._open)):
                if after is not None:
                    acts.append((ceil((plan.time[0] + after) / STEP - HAIR), grip.body, act))
        return sorted(acts, key=lambda one: one[0])

    def _close(self, name: str) -> None:
        """Grip a target that is within grasp."""
        b, k = self.number_of(name), self.steps
        j = self._numbers.index(b)
        if b not in self._within or name in self.closed or not self.holds(name, k, k):
            return
        self.closed[name] = k
        self._held.remove(j)
        self._weld(b, j, k)
        if self.situation.bodies[b].place is None:
            self._succeed(b)

    def _weld(self, b: int, j: int, k: int) -> None:
        """Weld a target to the hand, as it moves by its law at step k."""
        library, model, data, m = mujoco(), self._model, self._data, self._coupling.size
        data.qpos[m + 7 * j : m + 7 * j + 7] = self._law.targets[k, 7 * j : 7 * j + 7]
        data.qvel[m + 6 * j : m + 6 * j + 6] = self._law.moves[k, 6 * j : 6 * j + 6]
        library.mj_kinematics(model, data)
        weld = model.eq(f"grip{b}")
        hand, target = int(weld.obj1id[0]), int(weld.obj2id[0])
        turn, away = np.empty(4), data.xpos[target] - data.xpos[hand]
        library.mju_negQuat(turn, data.xquat[hand])
        library.mju_mulQuat(turn, turn.copy(), data.xquat[target])
        place = data.xmat[hand].reshape(3, 3).T @ away
        library.mj_comPos(model, data)
        levers = np.zeros((6, model.nv))
        library.mj_jac(model, data, levers[:3], levers[3:], data.xpos[target], hand)
        levers[3:] = data.xmat[target].reshape(3, 3).T @ levers[3:]
        self._levers[b] = levers[:, :m] @ self._coupling.factors
        model.eq_data[weld.id, :10] = [0.0, 0.0, 0.0, *place, *turn]
        data.eq_active[weld.id] = 1

    def _open(self, name: str) -> None:
        """Put down a target; it rests from now on."""
        if name not in self.closed or name in self.opened:
            return
        b, k = self.number_of(name), self.steps
        j = self._numbers.index(b)
        self.opened[name] = k
        self._data.eq_active[self._model.eq(f"grip{b}").id] = 0
        self._gone[j], self._held = k, sorted({*self._held, j})
        self._law.targets[:, 7 * j : 7 * j + 7] = self.targets_log[k, 7 * j : 7 * j + 7]
        self._law.moves[:, 6 * j : 6 * j + 6] = 0.0
        place: Any = self.situation.bodies[b].place
        if self.off_place(name) <= place.within * self.body.metres:
            self._succeed(b)

    def off_place(self, name: str) -> float:
        """Return how far a target is from its place now [m]."""
        b = self.number_of(name)
        place: Any = self.situation.bodies[b].place
        j, base = self._numbers.index(b), self.situation.arm.base
        away = rotation_of(base.rotation).T @ (np.array(place.position) - np.array(base.origin))
        here = self.targets_log[self.steps, 7 * j : 7 * j + 3]
        return float(np.linalg.norm(here - self.body.metres * away))

    def blow(self, name: str) -> Blow:
        """Return the blow that the grip of a target gave."""
        at, n, b = self.closed[name], round(BLOW / STEP), self.number_of(name)
        j = 6 * self._numbers.index(b)
        loads = self.loads_log[at : at + 2 * n, j : j + 6]
        pulls = loads[:n] - loads[n:].mean(axis=0)
        impulse = np.linalg.norm(pulls[:, :3].sum(axis=0)) * STEP
        return Blow(float(impulse), float(np.abs(pulls @ self._levers[b]).max()))

    def _met(self, b: int, k: int) -> None:
        """Note a target that is within grasp, which is not caught before it is gripped."""
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
        limb, carried = None, self.closed.keys() - self.opened.keys()
        for geoms in self._data.contact.geom.tolist():
            first, second = sorted(self._codes[geom] for geom in geoms)
            if first == LINK:
                limb = second
            elif carried & {self.situation.bodies[b].name for b in (first, second)}:
                limb = first if second in self._numbers else second
        return limb, []
