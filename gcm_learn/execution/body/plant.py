"""An arm with mass in a situation: a plant of MuJoCo."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from gcm_learn.arms import rotation_of
from gcm_learn.compiled import njit
from gcm_learn.errors import PhysicsError
from gcm_learn.execution.arena.kernels.world import CAUGHT, COLLIDED, GONE, RUNNING
from gcm_learn.execution.arena.pool import Catch, wanted_of
from gcm_learn.execution.body.kinds import MECHANICS, misfit, strongest
from gcm_learn.execution.body.laws import Laws, first_met_in, grasped, laws
from gcm_learn.execution.body.model import CATCHER, STEP, codes_of, coupling_of, model_of, mujoco
from gcm_learn.execution.body.motors import Controller, following
from gcm_learn.motion import Movement
from gcm_learn.scene import PART, pack
from gcm_learn.situation import AnyArmBody, Situation

AFTER = 0.5
"""Time for which the world goes on after the horizon [s]."""
ITSELF = "itself"
"""Name of what an arm touches whose own links overlap."""
CHUNK = 15
"""Steps after which it is asked whether the episode is over."""
BLOCK = 4 * CHUNK
"""Steps for which a plan's torques are found at once: after a catch they are not needed."""
FAR = 1e3
"""Distance of targets that were taken away from the arm, and from one another [m]."""
BRINK = 0.5
"""Share of what a joint lacks to its greatest speed that a pushing motor may add in a step."""


@dataclass(frozen=True)
class Contact:
    """The first contact of limb and obstacle."""

    name: str
    """Of the obstacle; `ITSELF` where links of the arm touch each other."""
    time: float
    """[s]"""


class PhysicalPlant:
    """One arm with mass in one situation; at first it rests, or moves with `arm.joint_rates`.

    Until a hand touches them, targets are exactly where their motion laws have them; obstacles
    always are.  Caught: the hand is within grasp of a target by the horizon; collided: a limb
    touched an obstacle before.  With several targets, each one but the last is gone once it is
    caught.

    Parameters
    ----------
    situation : Situation
    body : ArmBody or ChainBody
    controller : Controller
    believed : ArmBody or ChainBody, optional
        Body that the controller assumes; by default the true one.
    most : int, optional
        Number of catches that are enough, see `wanted_of`.
    until : float
        End of the episode, if it is after the horizon [s].

    Raises
    ------
    MissingExtraError
    PhysicsError
    """

    grips, carries = False, frozenset[str]()
    """True if the hand is a gripper, and targets in it."""

    def __init__(
        self,
        situation: Situation[Any],
        body: AnyArmBody,
        controller: Controller = Controller(),  # noqa: B008 -- frozen
        *,
        believed: AnyArmBody | None = None,
        most: int | None = None,
        until: float = 0.0,
    ) -> None:
        reason = misfit(situation.arm, body)
        if reason:
            raise PhysicsError(f"body {body.name!r}: does not fit: {reason}")
        self.situation, self.body = situation, body
        self.wanted = wanted_of(situation, most)
        self.fastest = np.array(situation.arm.max_joint_speed)
        """Of the joints (dof,) [rad/s; lengths/s of prismatic ones, as in all logs]."""
        self.metric = MECHANICS.of(situation).metric(situation.arm, body.metres)
        """Metres or radians of MuJoCo per unit of each coordinate (dof,)."""
        self.strongest = strongest(situation.arm, body)
        """Torques of the motors (dof,) [N m]."""
        self.motors = following(controller, situation.arm, believed or body)
        self._model = model_of(situation.arm, body, situation.bodies, self.grips)
        self._coupling = coupling_of(self._model, situation.arm, body.metres)
        self._codes = codes_of(self._model, len(situation.bodies))
        self._data = mujoco().MjData(self._model)
        self._end = max(situation.horizon, until)
        count = round((self._end + AFTER) / STEP) + 1
        times = np.arange(count) * STEP
        self._scene = pack(situation, float(times[-1]))
        self._laws = self._law = laws(self._scene, times, body.metres)
        self._numbers = [b for b, one in enumerate(situation.bodies) if one.role == "target"]
        self._places = self._scene.bodies.rows[:, PART].copy()
        self._parts = tuple(map(tuple, self._scene))
        self._poses = np.zeros((len(situation.bodies), 12))
        dof = len(self.fastest)
        self.joints_log = np.empty((count, dof))
        """Joints at every step until now (`steps` + 1 rows are filled) [rad]."""
        self.rates_log = np.empty((count, dof))
        self.torques_log = np.empty((count, dof))
        """Torques during every step [N m]."""
        self.loads_log = np.empty((count, self._laws.moves.shape[1]))
        """Force [N] and torque (in its frame) [N m] of touches and grips on every target."""
        self.targets_log = np.empty((count, self._laws.targets.shape[1]))
        """Of every target position [m] and quaternion, in the frame of the base."""
        self._states = np.empty((CHUNK, self._model.nq))  # after every step of a chunk
        self._speeds = np.empty((CHUNK, self._model.nv))
        self.begin()

    def begin(self) -> None:
        """Go back to t = 0; the logs are overwritten from then on."""
        mujoco().mj_resetData(self._model, self._data)
        self.steps = 0
        """Number of steps so far."""
        self.outcome = RUNNING
        self.catches: list[Catch] = []
        """Targets that were caught, in order."""
        self.contact: Contact | None = None
        """Before the last catch that is asked for."""
        self.later_contact: Contact | None = None
        """After it."""
        self._held = list(range(len(self._numbers)))  # targets that do not go their own way
        self._gone: dict[int, int] = {}  # targets that were taken away, and after which steps
        self._scene.bodies.rows[:, PART] = self._places
        if self.wanted.most > 1:  # targets are taken away in the tables
            tables = (self._laws.targets.copy(), self._laws.moves.copy())
            self._law = Laws(self._laws.obstacles, self._laws.turns, *tables)
        arm, data, dof = self.situation.arm, self._data, len(self.fastest)
        rates = np.array(arm.joint_rates or (0.0,) * dof)
        self._coupling.place(data, arm.joints * self.metric, rates * self.metric)
        m = self._coupling.size
        data.qpos[m:], data.qvel[m:] = self._laws.targets[0], self._laws.moves[0]
        self.joints_log[0], self.rates_log[0] = arm.joints, rates
        self.targets_log[0] = self._laws.targets[0]
        self._judge(0, None)

    @property
    def time(self) -> float:
        """Time since the start [s]."""
        return self.steps * STEP

    @property
    def catch_time(self) -> float | None:
        """Time of the last catch of an episode that is a success [s]."""
        return self.catches[-1].time if self.outcome == CAUGHT else None

    @property
    def catch_body(self) -> str | None:
        """Target of that catch."""
        return self.catches[-1].body if self.outcome == CAUGHT else None

    @property
    def joints(self) -> np.ndarray:
        """(dof,) [rad]"""
        return self.joints_log[self.steps].copy()

    @property
    def rates(self) -> np.ndarray:
        """(dof,) [rad/s]"""
        return self.rates_log[self.steps].copy()

    @property
    def hand(self) -> np.ndarray:
        """(3,) in the world, in the arm's unit."""
        hand: np.ndarray = self.movement_to(self.steps).hand[-1]
        return hand

    @property
    def ended(self) -> int:
        """Step of the last catch or of the contact; the last step if there was neither."""
        if len(self.catches) == self.wanted.most:
            return round(self.catches[-1].time / STEP)
        return self.steps if self.contact is None else round(self.contact.time / STEP)

    @property
    def movement(self) -> Movement:
        """Movement of the arm until it `ended`; linear between steps."""
        return self.movement_to(self.ended)

    def movement_to(self, last: int) -> Movement:
        """Return the movement of the arm until a step."""
        steps = np.arange(last + 1)
        return Movement(self.situation.arm, steps * STEP, self.joints_log[steps].copy())

    def follow(self, plan: Movement, until: float) -> None:
        """Follow a plan on the plant's clock, until a time [s] or the end of the episode."""
        times = np.arange(self.steps, self._steps_until(until) + 1) * STEP
        if times.size < 2:
            return
        joints, rates, forces = plan.states_at(times)
        self._gains(self.motors.kp, self.motors.kd)
        going = self.outcome == RUNNING
        for k in range(0, times.size - 1, BLOCK):
            now = slice(k, min(k + BLOCK, times.size - 1))
            wanted = self.motors.commands(joints[now], rates[now], forces[now])
            # damping acts on the rate at the end of a step, everything else on the state before it
            wanted += self.motors.kd * (rates[now.start + 1 : now.stop + 1] - rates[now])
            self._advance(wanted)
            if going and self.outcome != RUNNING:
                return

    def push(self, torques: np.ndarray, until: float) -> None:
        """Apply torques (dof,) [N m], cut at the motors' limits.

        A motor never pushes a joint beyond its `max_joint_speed`: near it the torque outward falls
        to none. Gravity, other joints and what was before may still be faster.
        """
        free = np.zeros(len(self.fastest))
        self._gains(free, free)
        given = np.tile(torques, (self._steps_until(until) - self.steps, 1))
        self._advance(given, pushed=True)

    def turn(self, rates: np.ndarray, until: float) -> None:
        """Servo the joints to rates (dof,) [rad/s], the arm's weight being held."""
        rates = np.clip(rates, -self.fastest, self.fastest)
        torques = self.motors.holding(self.joints) + self.motors.kd * rates
        self._gains(np.zeros(len(self.fastest)), self.motors.kd)
        self._advance(np.tile(torques, (self._steps_until(until) - self.steps, 1)))

    def holds(self, name: str, first: int, last: int) -> bool:
        """Return whether a target is within grasp at all steps from `first` to `last`."""
        b = self.number_of(name)
        at = 7 * self._numbers.index(b)
        rows = self.targets_log[first : last + 1, at : at + 7]
        turns = np.array([rotation_of(turn).ravel() for turn in rows[:, 3:].tolist()])
        poses = np.hstack([rows[:, :3] / self.body.metres, turns])
        joints, room = self.joints_log[first : last + 1], np.zeros((b + 1, 12))
        return last <= self.steps and bool(grasped(self._scene, b, joints, poses, room))

    def number_of(self, name: str) -> int:
        """Return the index of a body of the situation by its name."""
        return [body.name for body in self.situation.bodies].index(name)

    def _steps_until(self, until: float) -> int:
        return min(round(until / STEP), len(self.joints_log) - 1)

    def _gains(self, kp: np.ndarray, kd: np.ndarray) -> None:
        gains = self._model.actuator_biasprm
        gains[:, 1], gains[:, 2] = -kp / self.metric, -kd / self.metric

    def _advance(self, commands: np.ndarray, pushed: bool = False) -> None:
        """Step with commands (n, dof) until the episode ends; after its end, with all of them."""
        going, chunk = self.outcome == RUNNING, CHUNK if self.wanted.most == 1 else 1
        library = mujoco()
        library.set_mju_user_warning(lambda message: None)  # what goes wrong becomes an error
        try:
            for k in range(0, len(commands), chunk):
                before = self.steps
                touched = self._run(commands[k : k + chunk], pushed)
                if going:
                    self._judge(before + 1, touched)
                    if self.outcome != RUNNING:
                        return
                elif touched is not None:
                    self._note_late(touched)
        finally:
            library.set_mju_user_warning(None)

    def _run(self, commands: np.ndarray, pushed: bool) -> tuple[int, int] | None:
        """Step the physics; return the limb's first contact (see `_contacts`) and its step."""
        model, data, step = self._model, self._data, mujoco().mj_step
        first, last = self.steps, self.steps + len(commands)
        inside, after = slice(first, last), slice(first + 1, last + 1)
        qpos, qvel, ctrl, force = data.qpos, data.qvel, data.ctrl, data.actuator_force
        pulls = data.qfrc_constraint[self._coupling.size :]
        places, turns, own = data.mocap_pos, data.mocap_quat, self._coupling.own
        at, moving = qpos[self._coupling.size :], qvel[self._coupling.size :]
        found, law = None, [table[inside] for table in self._law]
        held = dict.fromkeys(self._held, last)  # until which step each target is
        logs = self.torques_log[inside], self.loads_log[inside], self._states, self._speeds
        rows = zip(commands, *law, *logs, strict=False)
        top, slope = self.fastest * self.metric, BRINK * self.motors.inertia / STEP / self.metric
        for k, (command, place, turn, target, move, *told) in enumerate(rows, first):
            if pushed:
                _spare(command, qvel[own], top, slope)
            ctrl[:], places[:], turns[:] = command, place, turn
            if len(self._held) == len(self._numbers):
                at[:], moving[:] = target, move
            else:
                _hold(self._held, at, target, 7)
                _hold(self._held, moving, move, 6)
            step(model, data)
            told[0][:], told[1][:], told[2][:], told[3][:] = force, pulls, qpos, qvel
            if data.ncon:
                limb, hands = self._contacts()
                if hands:
                    held |= dict.fromkeys(self._let_go(hands), k)
                if found is None and limb is not None:
                    found = limb, k
        self.steps, n = last, last - first
        self.joints_log[after] = self._states[:n, own] / self.metric
        self.rates_log[after] = self._speeds[:n, own] / self.metric
        self.targets_log[after] = self._states[:n, self._coupling.size :]
        self._log_held(first, last, held)
        if data.warning.number.any() or not np.isfinite(self.joints_log[self.steps]).all():
            raise PhysicsError(f"physics: some numbers are not finite at t = {self.time:.3f} s")
        return found

    def _log_held(self, first: int, last: int, held: dict[int, int]) -> None:
        """Log targets where their laws have them, until the steps to which they are held."""
        for j, until in held.items():
            rows, columns = slice(first + 1, until + 1), slice(7 * j, 7 * j + 7)
            self.targets_log[rows, columns] = self._laws.targets[rows, columns]
        for j, since in self._gone.items():  # it stays where it was caught
            columns = slice(7 * j, 7 * j + 7)
            self.targets_log[first + 1 : last + 1, columns] = self.targets_log[since, columns]

    def _contacts(self) -> tuple[int | None, list[int]]:
        """Return the obstacle that the limb touches (LINK: itself), and the targets at the hand."""
        limb, hands, codes = None, [], self._codes
        for first, second in self._data.contact.geom.tolist():
            touching, touched = sorted((codes[first], codes[second]))
            if touching == CATCHER:
                hands.append(touched)
            else:
                limb = touched
        return limb, hands

    def _let_go(self, touched: list[int]) -> list[int]:
        """Return the targets that go their own way from now on, as a hand touched bodies.

        All of them do where one catch is enough.
        """
        gone = [j for j in self._held
                if self.wanted.most == 1 or self._numbers[j] in touched]  # fmt: skip
        self._held = [j for j in self._held if j not in gone]
        return gone

    def _take_away(self, b: int, k: int) -> None:
        """Move a target that was caught at step k far off, where it touches nothing."""
        j = self._numbers.index(b)
        self._scene.bodies.rows[b, PART] = GONE
        self._gone[j] = k
        self._held = sorted({*self._held, j})
        self._law.targets[:, 7 * j : 7 * j + 3] = FAR * (j + 1)
        self._law.moves[:, 6 * j : 6 * j + 6] = 0.0

    def _judge(self, first: int, touched: tuple[int, int] | None) -> None:
        """See whether the episode is over, after the steps from `first` on."""
        step = -1 if touched is None else touched[1]
        last = min(self.steps, round(self.situation.horizon / STEP))
        limb, limits = self._scene.limb.__class__, self._scene.limits.__class__
        first_met, k = first_met_in(limb, limits), first
        while k >= 0 and self.outcome == RUNNING:
            k, b = first_met(self._parts, self.joints_log, k, last, STEP, self._poses)
            if touched is not None and not 0 <= k < step:
                self.outcome, self.contact = COLLIDED, self._contact_of(touched)
                return
            if k >= 0:
                self._met(b, k)
        if k < 0 and (self.steps > round(self._end / STEP) or self.time >= self._end):
            self.outcome = self.wanted.at_horizon(len(self.catches))
        if touched is not None:
            self._note_late(touched)

    def _met(self, b: int, k: int) -> None:
        """Note a target within grasp at step k, which is caught."""
        self.catches.append(Catch(self.situation.bodies[b].name, k * STEP))
        if len(self.catches) == self.wanted.most:
            self.outcome = CAUGHT
        else:
            self._take_away(b, k)

    def _note_late(self, touched: tuple[int, int]) -> None:
        if self.later_contact is None:
            self.later_contact = self._contact_of(touched)

    def _contact_of(self, touched: tuple[int, int]) -> Contact:
        what, step = touched
        return Contact(ITSELF if what < 0 else self.situation.bodies[what].name, step * STEP)


def _hold(held: list[int], here: np.ndarray, there: np.ndarray, width: int) -> None:
    """Put the numbers of targets that are held to where they belong."""
    for j in held:
        here[width * j : width * j + width] = there[width * j : width * j + width]


@njit
def _spare(torques, rates, top, slope):
    """Cut torques (dof,) that would push joints beyond their greatest speeds (dof,)."""
    for j in range(torques.size):
        high, low = slope[j] * (top[j] - rates[j]), -slope[j] * (top[j] + rates[j])
        torques[j] = min(max(torques[j], min(low, 0.0)), max(high, 0.0))
