"""The closed loop: an agent perceives, thinks while the world goes on, and an arm follows.

Every period brings a percept, which renews the belief.  An agent that thinks for k
periods, or a part of the last one, has its plan k periods later.  It knows how long it will think:
the plan is for the believed situation at that time, from where the arm will be.  Meanwhile the
arm follows its old trajectory, and brakes to rest after the end of that.
"""

from __future__ import annotations

import math
import time as clock
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple, Protocol

from gcm_learn.errors import ArenaError, SituationError
from gcm_learn.execution.arena.kernels.world import CAUGHT, RUNNING
from gcm_learn.execution.arena.pool import Catch, wanted_of, without
from gcm_learn.execution.loop.belief import ACCELERATION, Belief
from gcm_learn.execution.loop.kinds import LEADS
from gcm_learn.execution.loop.perception import Perception
from gcm_learn.motion import Movement
from gcm_learn.scene import pack
from gcm_learn.situation import AnySituation

TRIES = 4  # at a plan, each of which allows for the time that the last one took
_HAIR = 1e-9  # of a period, against rounding


class LedPlant(Protocol):
    """An arm in its situation that follows trajectories."""

    @property
    def time(self) -> float:
        """Time since the start [s]."""

    @property
    def outcome(self) -> int:
        """RUNNING, CAUGHT, COLLIDED or LATE of `world`."""

    @property
    def catch_time(self) -> float | None:
        """Time of the last catch of an episode that is a success [s]."""

    @property
    def catches(self) -> Sequence[Catch]:
        """Targets that were caught, in order."""

    @property
    def carries(self) -> Collection[str]:
        """Targets in the hand; an agent does not think while it carries any."""

    def follow(self, trajectory: Movement, until: float, /) -> None:
        """Follow a trajectory until a time [s], or until the episode is over."""


class Occasion(NamedTuple):
    """Occasion at which an agent may think."""

    believed: AnySituation
    """Believed situation from now on, with the arm where its trajectory has it."""
    left: Movement
    """Rest of the trajectory that is followed, on a clock of its own; it ends at rest."""
    thoughts: int
    """Number of the agent's earlier thoughts."""


class Mind(Protocol):
    """Protocol of agents that think."""

    def wants(self, occasion: Occasion) -> bool:
        """Return whether the agent thinks now."""

    def plan(self, believed: AnySituation) -> Movement | None:
        """Return a movement from t = 0 of the believed situation on; None to go on as before."""


class Thought(NamedTuple):
    """A plan that was thought of."""

    begun: float
    """[s]"""
    took: float
    """[s]"""
    found: bool


@dataclass(frozen=True)
class Loop:
    """Settings of an episode."""

    perception: Perception
    looks: int = 10
    """Number of looks before an agent begins to think.  Two exact looks would do; inexact looks
    tell accelerations late."""
    thinking: float | None = None
    """Time that every thought takes [s]; by default its processor time."""
    acceleration: float = ACCELERATION
    """Of `Belief`."""
    latency: float = 0.0
    """Time by which commands come late [s], of which the agent does not know."""

    def __post_init__(self) -> None:
        if isinstance(self.looks, bool) or not isinstance(self.looks, int) or self.looks < 1:
            raise ArenaError(f"looks: must be an integer from 1 on (got {self.looks!r})")
        for name in ("thinking", "latency"):
            value = getattr(self, name)
            if value is not None and not 0.0 <= value < math.inf:
                raise ArenaError(f"{name}: must be from 0 on (got {value!r})")


@dataclass(frozen=True)
class Course:
    """Result of an episode."""

    outcome: int
    """CAUGHT, COLLIDED or LATE of `world`."""
    time: float
    """Time of its end [s]."""
    thoughts: tuple[Thought, ...]
    catches: tuple[Catch, ...] = ()
    """Targets that were caught, in order."""


@dataclass
class _Pending:
    """A thought that is under way."""

    due: int
    """Look from which on its plan is followed."""
    plan: Movement | None


class _Episode:
    """An episode under way."""

    def __init__(self, mind: Mind, situation: AnySituation, loop: Loop) -> None:
        self.mind, self.loop, self.arm = mind, loop, situation.arm
        self.lead = LEADS.of(situation)
        self.belief = Belief(situation, loop.perception, loop.acceleration)
        self.horizon, self.period = situation.horizon, loop.perception.period
        self.followed = self.lead.at_first(self.arm)
        self.thoughts: list[Thought] = []
        self.pending: _Pending | None = None
        self.caught: Sequence[Catch] = ()

    def think(self, look: int, caught: Sequence[Catch]) -> None:
        """Take up the plan that is due, then let the agent think if it wants to.

        Caught targets are known, and left out of the believed situation.
        """
        self.caught = caught
        self._take_up(look)
        if self.pending is None and self.belief.looks >= self.loop.looks:
            now, since = look * self.period, clock.process_time()
            left, believed = self.lead.rest_of(self.followed, now), self._believed(now)
            if believed is None:
                return
            if self.mind.wants(Occasion(believed, left, len(self.thoughts))):
                self._plan(look, clock.process_time() - since)
                self._take_up(look)  # where thinking takes no time

    def _take_up(self, look: int) -> None:
        if self.pending is not None and self.pending.due <= look:
            if self.pending.plan is not None:
                self.followed = self.pending.plan
            self.pending = None

    def _plan(self, look: int, spent: float) -> None:
        """Let the agent plan, after it spent `spent` [s] on the decision to think."""
        ahead = self._periods(self.loop.thinking if self.loop.thinking is not None else spent)
        plan, took = None, 0.0
        for _ in range(TRIES):
            start = (look + ahead) * self.period
            if start >= self.horizon:
                plan = None
                break
            since, believed = clock.process_time(), self._believed(start)
            plan = None if believed is None else self.mind.plan(believed)
            took = spent + clock.process_time() - since
            if self.loop.thinking is not None:
                took = self.loop.thinking
            needed = self._periods(took)
            if plan is None or needed <= ahead:
                ahead = max(ahead, needed)
                break
            plan, ahead = None, needed
        self.thoughts.append(Thought(look * self.period, took, plan is not None))
        if plan is not None:
            plan = self.lead.begun(self.arm, plan, start)
        self.pending = _Pending(look + ahead, plan)

    def _periods(self, span: float) -> int:
        """Return the number of periods in a time [s], rounded up."""
        return math.ceil(span / self.period - _HAIR)

    def _believed(self, t: float) -> AnySituation | None:
        """Return the believed situation from t on, with the arm where its trajectory has it at t.

        None while the hand moves faster than its limit, which may happen as the arm brakes after
        the end of a plan.
        """
        try:
            believed = self.belief.situation(t, self.lead.led(self.arm, self.followed, t))
        except SituationError as error:
            if not error.field.endswith("rates"):
                raise
            return None
        return without(believed, self.caught)


def run_closed_loop(
    mind: Mind, plant: LedPlant, situation: AnySituation, loop: Loop, seed: int, *index: int
) -> Course:
    """Let an agent act until the episode is over.

    Parameters
    ----------
    mind : Mind
    plant : LedPlant
        At t = 0 of the situation.
    situation : Situation
        The true situation; the agent knows only its percepts.
    loop : Loop
    seed : int
    *index : int
        Of the errors of perception.
    """
    episode = _Episode(mind, situation, loop)
    period, look, sent = loop.perception.period, 0, [episode.followed]
    while plant.outcome == RUNNING:
        percept = loop.perception.told(situation, look, seed, *index)
        if percept is not None:
            episode.belief.join(percept)
        if look * period < situation.horizon and not plant.carries:
            episode.think(look, plant.catches)
        sent.append(episode.followed)
        for moves, until in _arriving(sent, look, period, loop.latency):
            plant.follow(moves, until)
        look += 1
    ended = plant.time if plant.catch_time is None else plant.catch_time
    return Course(plant.outcome, ended, tuple(episode.thoughts), tuple(plant.catches))


def _arriving(
    sent: Sequence[Movement], look: int, period: float, latency: float
) -> Iterator[tuple[Movement, float]]:
    """Yield commands that arrive in the period after a look, and until when they hold [s]."""
    whole = math.floor(latency / period + _HAIR)
    rest = latency - whole * period
    for k, until in ((look - whole, look * period + rest), (look - whole + 1, (look + 1) * period)):
        if until > (look + _HAIR) * period:
            moves = sent[max(k, 0)]
            yield replace(moves, time=moves.time + latency), until


JUMP = 1e-6  # distance of arm and trajectory where it is taken up [rad, or forearm lengths]


class ExactPlant:
    """A kinematic arm in its situation that follows trajectories exactly: a `LedPlant`.

    A catch is the first moment at which a target is within grasp, a collision the first one at
    which the limb touches an obstacle.

    Parameters
    ----------
    situation : Situation
    most : int, optional
        Number of catches that are enough, see `wanted_of`.
    """

    def __init__(self, situation: AnySituation, most: int | None = None) -> None:
        self.situation, self.wanted = situation, wanted_of(situation, most)
        self.time = 0.0
        self.arm = situation.arm
        """As it stands and moves at that time."""
        self.outcome = RUNNING
        self.catches: list[Catch] = []
        """Targets that were caught, in order."""
        self._lead = LEADS.of(situation)
        self._left = situation
        self._events = self._lead.events(pack(situation))

    @property
    def catch_time(self) -> float | None:
        """Time of the last catch of an episode that is a success [s]."""
        return self.catches[-1].time if self.outcome == CAUGHT else None

    carries = ()

    def follow(self, trajectory: Movement, until: float) -> None:
        """Follow a trajectory until a time, or until the episode is over.

        Parameters
        ----------
        trajectory : Movement
            On the plant's clock; at the present time it is where the arm is.
        until : float
            [s]
        """
        off = self._lead.gap(self.arm, trajectory, self.time)
        if off > JUMP:
            raise ValueError(f"trajectory: is {off:.2g} away from the arm at {self.time:g} s")
        horizon = self.situation.horizon
        end = min(until, horizon)
        while self.outcome == RUNNING and end > self.time:
            outcome, self.time, body = self._events.first(trajectory, self.time, end)
            self.arm = self._lead.led(self.arm, trajectory, self.time)
            if outcome == CAUGHT:
                self.catches.append(Catch(self._left.bodies[body].name, self.time))
                if len(self.catches) < self.wanted.most:
                    self._left = without(self._left, [self.catches[-1]])
                    self._events = self._lead.events(pack(self._left))
                    continue
            self.outcome = outcome
        if self.outcome == RUNNING and self.time >= horizon:
            self.outcome = self.wanted.at_horizon(len(self.catches))
