"""Agents of the closed loop: planners that think once, always or if they must, and commands."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal, Protocol

import numpy as np

from gcm_learn.arms import PLANAR, ByKind, SpatialArm
from gcm_learn.compiled import njit
from gcm_learn.errors import ArenaError
from gcm_learn.execution.arena.batch import way_of
from gcm_learn.execution.arena.kernels.joints import chains
from gcm_learn.execution.arena.kernels.joints.observation import observe_all
from gcm_learn.execution.arena.kernels.joints.scene import view_in, views_for
from gcm_learn.execution.arena.kernels.joints.stepping import reach_out
from gcm_learn.execution.arena.kernels.world import CAUGHT, Options, State, World, world_of
from gcm_learn.execution.arena.pool import Pool, wanted_of
from gcm_learn.execution.arena.settings import ArenaSettings, SpatialSettings
from gcm_learn.execution.loop.closed_loop import ExactPlant, Occasion
from gcm_learn.execution.loop.episode import Agent, Moment, into_frame
from gcm_learn.execution.loop.joint_leading import gripped
from gcm_learn.motion import Movement, fastest_hand, opening
from gcm_learn.planners import plan_with
from gcm_learn.scene import pack
from gcm_learn.situation import AnySituation, Situation


class OneStep:
    """The first step of an arm in space.

    Parameters
    ----------
    situation : Situation
    settings : ArenaSettings
    """

    def __init__(self, situation: Situation[SpatialArm], settings: ArenaSettings) -> None:
        scene = pack(situation)
        posture = np.concatenate([scene.limb.start, scene.limb.rates])[None]
        caught = np.full((1, len(situation.bodies)), -1.0)
        state = State(np.zeros(1, np.int64), posture, np.zeros((1, 3)), np.zeros(1), caught)
        world = world_of([scene], [opening(scene).rules], [fastest_hand(scene)], chains.rows_of)
        self.told = np.zeros((1, settings.width), np.float32)
        """As `envs.CatchArm3D` lists it (1, width)."""
        self.posture = posture[0]
        """Joints [rad] and their rates [rad/s] (2 dof,)."""
        self._world, self._arm = tuple(world), state
        self._options = settings.options
        alone = np.zeros(1, np.int64)
        observe_all(self._world, tuple(state), alone, self._options, self.told)

    def after(self, command: np.ndarray) -> np.ndarray:
        """Posture (2 dof,) after the step, as near to a command (dof,) as the limits allow."""
        out = np.empty(self.posture.size)
        _after(self._world, tuple(self._arm), command[None].astype(float), self._options, out)
        return out


@njit
def _after(world, state, command, options, out):
    """Write the posture (2 dof,) after a step of the only arm."""
    worlds, states, how = World(*world), State(*state), Options(*options)
    view = view_in(worlds, states, 0, views_for(worlds, states, 0, 1))
    end, speed, n = view.joints[0], view.rules.speed, view.joints.shape[1]
    reach_out(view.scene, speed, states.posture, 0, command, how.dt, end, view)
    out[:n], out[n:] = end, view.rates[0]


HABITS = ("once", "always", "broken")


class Answering(Protocol):
    """A planner."""

    def plan(self, situation: Any) -> Any:
        """Answer a situation; the answer's `trajectory` may be None."""


@dataclass(frozen=True)
class Planning:
    """An agent that follows the plans of a planner."""

    planner: Answering
    habit: Literal["once", "always", "broken"] = "broken"
    """Occasions to think: once; whenever the last thought is done; or when the followed plan no
    longer catches in the believed situation."""

    def __post_init__(self) -> None:
        if self.habit not in HABITS:
            raise ArenaError(f"habit: must be one of {', '.join(HABITS)} (got {self.habit!r})")

    def wants(self, occasion: Occasion) -> bool:
        """Return whether the agent thinks now."""
        if self.habit == "once":
            return occasion.thoughts == 0
        return self.habit == "always" or not holds(occasion)

    def plan(self, believed: AnySituation) -> Movement | None:
        """Return the planner's movement, or None."""
        asked: Any = self.planner
        many = wanted_of(believed).most > 1
        answer = plan_with(asked, believed) if many else asked.plan(believed)
        found: Movement | None = answer.trajectory
        holds = found is not None and any(target.hold for target in believed.targets)
        return gripped(answer) if holds else found


def holds(occasion: Occasion) -> bool:
    """Return whether the trajectory that is followed catches in the believed world.

    It is judged as an episode is: the limb at every instant until a catch. The
    arm's own limits do not change with the world.
    """
    believed = ExactPlant(occasion.believed)
    believed.follow(occasion.left, occasion.believed.horizon)
    return believed.outcome == CAUGHT


@dataclass(frozen=True)
class Commanding:
    """An agent that commands rates of a spatial arm's joints in every period: a learned policy.

    Its observation is that of the arena in the believed world, and its commands are cut to the
    arm's limits as there.
    """

    policy: Callable[[np.ndarray], np.ndarray]
    """Commands (1, 4) under observations (1, width), in greatest joint speeds."""
    settings: ArenaSettings = field(default_factory=SpatialSettings)
    """Of its observations; a command holds for a step."""

    def wants(self, occasion: Occasion) -> bool:
        """Return True: the agent commands in every period."""
        return True

    def plan(self, believed: Any) -> Movement | None:
        """Return the movement of the next step; after the step the arm would come to rest."""
        step = OneStep(believed, self.settings)
        posture = np.stack([step.posture, step.after(self.policy(step.told)[0])])
        return way_of(believed.arm, np.array([0.0, self.settings.dt]), posture)


class HandFollower:
    """Agent that follows trajectories of planar arms step by step.

    Parameters
    ----------
    plans : sequence of Movement
        One for each arm, in canonical coordinates.
    speed : (n,) ndarray
        Of the hands [forearms/s].
    dt : float
        Of a step [s].
    """

    def __init__(self, plans: Sequence[Movement], speed: np.ndarray, dt: float) -> None:
        most = max(len(plan.time) for plan in plans)
        self._speed, self._dt = speed, dt
        self._end = np.array([plan.duration for plan in plans])
        # Shorter ones are filled up with their ends.
        self._time = np.full((len(plans), most), np.inf)
        self._hand = np.empty((len(plans), most, 2))
        for row, plan in enumerate(plans):
            self._time[row, : len(plan.time)] = plan.time
            self._hand[row] = plan.hand[-1]
            self._hand[row, : len(plan.time)] = plan.hand

    def act(self, moment: Moment) -> np.ndarray:
        """Velocities (n, 2) that bring hands to where they should be in a step."""
        wanted = self._velocity(moment.time, moment.hand) / self._speed[:, None]
        return into_frame(moment.hand, wanted)

    def _velocity(self, t: np.ndarray, hand: np.ndarray) -> np.ndarray:
        """Velocities (n, 2) [forearms/s].

        A step in which a plan ends is as fast as its last piece, and goes on beyond it.
        """
        until = np.where(t < self._end - 1e-9, np.minimum(t + self._dt, self._end), t + self._dt)
        rows = np.arange(len(t))
        k1 = np.clip((self._time <= until[:, None]).sum(axis=1), 1, self._time.shape[1] - 1)
        t0, t1 = self._time[rows, k1 - 1], self._time[rows, k1]
        span = np.where(np.isfinite(t1), t1 - t0, 1.0)
        share = np.clip((until - t0) / np.where(span > 0.0, span, 1.0), 0.0, 1.0)[:, None]
        share[~np.isfinite(t1)] = 0.0
        goal = self._hand[rows, k1 - 1] * (1.0 - share) + self._hand[rows, k1] * share
        return (goal - hand) / np.maximum(until - t, 1e-9)[:, None]


class JointFollower:
    """Agent that follows trajectories in the joints step by step.

    Parameters
    ----------
    plans : sequence of Movement
        One for each arm.
    dt : float
        Of a step [s].
    """

    def __init__(self, plans: Sequence[Movement], dt: float) -> None:
        self._dt = dt
        self._top = np.array([plan.arm.max_joint_speed for plan in plans])
        most = int(np.ceil(max(plan.duration for plan in plans) / dt)) + 1
        dof = self._top.shape[1]
        self._joints = np.empty((len(plans), most + 1, dof))
        self._rates = np.full((len(plans), most + 1, dof), np.nan)
        for row, plan in enumerate(plans):
            times = dt * np.arange(most + 1)
            inside = np.minimum(times, plan.duration)
            joints, rates, _ = plan.states_at(inside)
            # a step in which a plan ends goes on beyond it, as fast as its last piece
            over = np.argmax(times >= plan.duration)
            if over > 0 and times[over] > plan.duration:
                last = plan.duration - times[over - 1]
                joints[over:] = joints[over - 1] + (joints[over] - joints[over - 1]) * dt / last
            self._joints[row] = joints
            if plan.rates is not None:
                self._rates[row] = rates

    def act(self, moment: Moment) -> np.ndarray:
        """Rates (n, dof) that bring joints to where they should be in a step, in greatest speeds.

        Under limits of acceleration these are the rates of the plans at that time.
        """
        rows, dof = np.arange(len(moment.time)), self._top.shape[1]
        k = np.rint(moment.time / self._dt).astype(int) + 1
        k = np.minimum(k, self._joints.shape[1] - 1)
        even = (self._joints[rows, k] - moment.posture[:, :dof]) / self._dt
        rates = self._rates[rows, k]
        return np.where(np.isnan(rates), even, rates) / self._top


_FOLLOWERS: ByKind[Callable[[Any, Pool, float], Agent]] = ByKind(
    {PLANAR: lambda plans, pool, dt: HandFollower(plans, pool.speed, dt)},
    default=lambda plans, pool, dt: JointFollower(plans, dt),
    who="the arena",
)


def follower_of(plans: Sequence[Any], pool: Pool, dt: float) -> Agent:
    """Return an agent that follows trajectories step by step.

    Parameters
    ----------
    plans : sequence of Movement
        One for each situation of the pool, in its coordinates.
    pool : Pool
    dt : float
        Of a step [s].
    """
    return _FOLLOWERS.of(pool.kind)(plans, pool, dt)
