"""Inexact perception for planar arms: places and velocities of bodies, observed every 50 ms.

An observation has the bodies' true places and velocities, each with an error of its own. An agent
knows laws of motion and shapes. The world goes on as it is, and judges the hand. An agent may plan
once, or again at each observation, and by the last one alone or by all of them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from gcm_learn import seeding
from gcm_learn.evaluation.suites import Entry
from gcm_learn.execution import (
    OUTCOMES,
    Moment,
    Settings,
    into_frame,
    plant_of,
    pool_for,
    run_episode,
)
from gcm_learn.motion import Movement
from gcm_learn.planners import Attempt, Planner, Problem, checked
from gcm_learn.scene import later
from gcm_learn.situation import Body, Pendulum, PlanarQuadratic, Situation, SolidQuadratic

PERIOD = 0.05  # between two observations [s]
STEP = 0.01  # of the world [s]
FASTER = 2.0  # errors of velocities [hand speeds] over those of places [forearms]


@dataclass(frozen=True)
class Noise:
    """How inexact perception is."""

    place: float
    """Standard deviation of each coordinate of a body's place [forearms]; that of velocities
    is twice the number [hand speeds]."""
    caution: float = 0.0
    """By how many of these deviations agents think the limb thicker than it is."""

    def seen(self, situation: Situation, rng: np.random.Generator) -> Situation:
        """Return a situation as it is perceived."""
        fast = FASTER * self.place * situation.arm.max_hand_speed
        bodies = tuple(
            replace(body, motion=_perturbed(_tracked(body), self.place, fast, rng))
            for body in situation.bodies
        )
        return replace(situation, bodies=bodies)

    def careful(self, situation: Situation, share: float = 1.0) -> Situation:
        """Return a situation with a thicker limb, for a share of one observation's errors."""
        thicker = situation.arm.thickness + self.caution * self.place * share
        return replace(situation, arm=replace(situation.arm, thickness=thicker))


Tracked = PlanarQuadratic | SolidQuadratic | Pendulum


def _tracked(body: Body) -> Tracked:
    """Return the motion of a body; those beside a planar arm follow one law."""
    assert isinstance(body.motion, Tracked)
    return body.motion


def _perturbed(motion: Tracked, place: float, fast: float, rng: np.random.Generator) -> Tracked:
    """A motion with an error of place and velocity; of a pendulum along its arc."""
    if isinstance(motion, Pendulum):
        off, faster = rng.normal(size=2) / max(motion.hang_distance, 1e-3)
        return replace(motion, angle=motion.angle + place * off, rate=motion.rate + fast * faster)
    count = len(motion.position)
    off, faster = place * rng.normal(size=count), fast * rng.normal(size=count)
    if not any(motion.velocity):
        faster = np.zeros(count)  # that it rests is seen
    changed: dict[str, Any] = {
        "position": tuple((np.array(motion.position) + off).tolist()),
        "velocity": tuple((np.array(motion.velocity) + faster).tolist()),
    }
    return replace(motion, **changed)


class _Memory:
    """All observations as one, each weighted by its variance at present (Kalman, 1960).

    Places and velocities are equally inexact along all axes. So one matrix of variances serves all
    moving bodies, in units of an observation's variances. Of bodies that rest only the place is
    unknown, and the mean of all observations is the best estimate.
    """

    def __init__(self, speed: float) -> None:
        self._one = np.diag([1.0, (FASTER * speed) ** 2])
        self._spread = self._one.copy()
        self._known: Situation | None = None
        self._since, self._count = 0.0, 0

    @property
    def share(self) -> float:
        """Deviation of a moving body's place over that of one observation."""
        return float(np.sqrt(self._spread[0, 0]))

    def joined(self, seen: Situation, t: float) -> Situation:
        """Return the situation that is known at t, from this observation and all earlier ones."""
        self._count += 1
        if self._known is None:
            self._known, self._since = seen, t
            return seen
        span = t - self._since
        shift = np.array([[1.0, span], [0.0, 1.0]])
        before = shift @ self._spread @ shift.T
        gain = before @ np.linalg.inv(before + self._one)
        self._spread = before - gain @ before
        mean = np.array([[1.0 / self._count, 0.0], [0.0, 0.0]])
        bodies = tuple(
            replace(new, motion=_blend(_tracked(old), _tracked(new), gain, mean))
            for old, new in zip(later(self._known, span).bodies, seen.bodies, strict=True)
        )
        self._known, self._since = replace(seen, bodies=bodies), t
        return self._known


def _blend(old: Tracked, new: Tracked, gain: np.ndarray, mean: np.ndarray) -> Tracked:
    """Return the expected motion, moved towards the observed one."""
    if isinstance(old, Pendulum) or isinstance(new, Pendulum):
        assert isinstance(old, Pendulum) and isinstance(new, Pendulum)
        off = gain @ np.array([new.angle - old.angle, new.rate - old.rate])
        return replace(new, angle=old.angle + float(off[0]), rate=old.rate + float(off[1]))
    there = np.array([old.position, old.velocity])
    if not any(new.velocity):  # it rests, and that is seen
        gain, there[1] = mean, 0.0
    place, velocity = there + gain @ (np.array([new.position, new.velocity]) - there)
    changed: dict[str, Any] = {
        "position": tuple(place.tolist()), "velocity": tuple(velocity.tolist())
    }  # fmt: skip
    return replace(new, **changed)


@dataclass(frozen=True)
class Habit:
    """Use of observations by an agent."""

    replan: bool = False
    """If true, it plans at every observation, else at the first one only."""
    remember: bool = False
    """If true, an observation is joined with earlier ones."""


class _Agent:
    """Follows the last plan that it found."""

    def __init__(
        self, planner: Planner, entry: Entry, noise: Noise, habit: Habit, seed: int
    ) -> None:
        self.planner, self.entry, self.noise = planner, entry, noise
        self.habit, self._seed = habit, seed
        self._memory = _Memory(entry.situation.arm.max_hand_speed)
        self._plan: Movement | None = None
        self._since = 0.0
        self._seen = 0

    def observe(self, t: float, hand: np.ndarray) -> None:
        """See the world at t, and plan."""
        if self._seen and not self.habit.replan:
            return
        source = seeding.rng(self._seed, self.entry.index, self._seen)
        self._seen += 1
        now = later(self.entry.situation, t, (float(hand[0]), float(hand[1])))
        seen, share = self.noise.seen(now, source), 1.0
        if self.habit.remember:
            seen, share = self._memory.joined(seen, t), self._memory.share
        tries = [self.noise.careful(seen, share), seen] if self.noise.caution > 0.0 else [seen]
        for situation in tries:
            kept, new = self._kept(situation, t), self.planner.plan(situation).trajectory
            if kept is None or (new is not None and new.duration < kept.duration):
                kept = new
            if kept is not None:
                self._plan, self._since = kept, t
                return

    def _kept(self, situation: Situation, t: float) -> Movement | None:
        """Return the rest of the present plan, if it still catches in the known situation.

        An agent that always changes to new plans, even to later catches, never arrives.
        """
        at = t - self._since
        if self._plan is None or at >= self._plan.duration - 1e-9:
            return None
        rest = self._plan.time > at
        time = np.append(0.0, self._plan.time[rest] - at)
        hand = np.vstack([situation.arm.hand, self._plan.hand[rest]])
        left = Movement.of_hand(situation.arm, time, hand)
        problem = Problem(situation, "kept")
        for index, body in enumerate(situation.bodies):
            if body.role == "target":
                plan, _ = checked(problem, Attempt(left, index))
                if plan is not None:
                    return plan.trajectory
        return None

    def velocity(self, t: float, hand: np.ndarray) -> np.ndarray:
        """Return the velocity (2,) along the plan for a step; rest without a plan, or after it."""
        if self._plan is None:
            return np.zeros(2)
        at = t - self._since
        if at >= self._plan.duration - 1e-9:
            return np.zeros(2)
        end = min(at + STEP, self._plan.duration)
        return (self._plan.hand_at(end) - hand) / (end - at)


class _Agents:
    """One for each arm."""

    def __init__(self, agents: Sequence[_Agent], speed: np.ndarray) -> None:
        self._agents, self._speed, self._steps = agents, speed, 0

    def act(self, moment: Moment) -> np.ndarray:
        """Velocities (n, 2), after an observation where it is time for one."""
        wanted = np.zeros(moment.hand.shape)
        for e in np.flatnonzero(moment.running).tolist():
            t, hand = float(moment.time[e]), moment.hand[e].copy()
            if self._steps % round(PERIOD / STEP) == 0:
                self._agents[e].observe(t, hand)
            wanted[e] = self._agents[e].velocity(t, hand) / self._speed[e]
        self._steps += 1
        return into_frame(moment.hand, wanted)


def under_noise(
    planner: Planner, entries: Sequence[Entry], noise: Noise, habit: Habit, seed: int = 0
) -> list[str]:
    """Outcomes of following a planner that sees inexactly.

    Parameters
    ----------
    planner : Planner
    entries : sequence of Entry
        Their situations are in canonical form.
    noise : Noise
    habit : Habit
    seed : int
        Of the errors; the same for all planners.

    Returns
    -------
    list of str
        caught, touched or late.
    """
    agents = [_Agent(planner, entry, noise, habit, seed) for entry in entries]
    settings = Settings(dt=STEP, slots=0)
    pool = pool_for(settings, [entry.situation for entry in entries])
    plant = plant_of(pool, len(entries), settings)
    episodes = run_episode(_Agents(agents, pool.speed), plant, np.arange(len(entries)))
    return [OUTCOMES[o] for o in episodes.outcomes]
