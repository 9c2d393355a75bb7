"""From a path through hand-space to a verified catch."""

from __future__ import annotations

import math
import time as clock
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from gcm_learn import motion
from gcm_learn.arms import Arm, kind_of
from gcm_learn.collision import UNLIMITED, WORK
from gcm_learn.maps import CognitiveMap
from gcm_learn.planners.joints.moves import Study, study_of
from gcm_learn.planners.plan import GAIN, Deadline, Plan, end_of, in_plane, refused
from gcm_learn.scene import Bodies, Scene, pack
from gcm_learn.situation import AnySituation, Situation

CATCH_STEP = 0.25  # of an instant: catches along a path are found finer than interceptions
_MORE_TRIES = 60  # later interceptions tried when joint limits forbid the first


class Task:
    """Planning problem: a situation, packed for planning, with its rules, clock and budget."""

    situation: Any

    def __init__(
        self,
        situation: AnySituation,
        planner: str,
        scene: Scene | None = None,
        deadline: Deadline | None = None,
    ) -> None:
        self.started, self.deadline = clock.perf_counter(), deadline
        self.nodes = 0
        """See `Plan`."""
        self.gain = GAIN * situation.horizon
        """By how much a catch must be earlier to be looked for [s]."""
        self.budget = np.full(1, WORK if deadline is None else UNLIMITED)
        """Distances (1,) along moves that may still be computed; negative when they are spent.
        A deadline takes their place."""
        self.situation = situation
        self.planner = planner
        self.scene: Scene = pack(situation) if scene is None else scene

    @property
    def over(self) -> bool:
        """Return whether the deadline has come."""
        return self.deadline is not None and self.deadline.over

    def slices(self, size: int, whole: int) -> int:
        """Return the amount of work before the next check of the deadline; without one, `whole`."""
        return whole if self.deadline is None else min(size, whole)

    @property
    def bodies(self) -> Bodies:
        """The scene's bodies."""
        return self.scene.bodies

    @cached_property
    def _opening(self) -> motion.Opening:
        return motion.opening(self.scene)

    @property
    def start_clearance(self) -> float:
        """Clearance of the limb at t = 0 [forearm lengths]."""
        return self._opening.clearance

    @property
    def rules(self) -> motion.Rules:
        """Limits less a margin, with which movements are surely verified."""
        return self._opening.rules

    @property
    def elapsed_ms(self) -> float:
        """Wall time since the problem was taken up [ms]."""
        return 1e3 * (clock.perf_counter() - self.started)

    def answer(
        self, why: motion.Failure | motion.Reason, cognitive_map: CognitiveMap | None = None
    ) -> Plan:
        """A plan without a catch."""
        reason = why if isinstance(why, motion.Reason) else motion.Reason(why)
        blocked = reason.failure is motion.Failure.START_BLOCKED
        if self.budget[0] < 0:
            reason = motion.Reason(motion.Failure.OUT_OF_WORK)
        return Plan(
            name=self.situation.name,
            planner=self.planner,
            status="start_blocked" if blocked else "unreachable",
            message=str(reason),
            planning_ms=self.elapsed_ms,
            failure=reason.failure,
            map=cognitive_map,
            nodes=self.nodes,
            format=self.situation.format,
        )

    def early_answer(self) -> Plan | None:
        """Return the answer that needs no planning: blocked at the start, or hopeless."""
        if self.start_clearance <= 0.0:
            return self.answer(motion.why_blocked(self.situation, self.scene))
        count = len(self.situation.targets)
        if self.situation.catch == "all" and count > 1:
            return self.answer(motion.Failure.SEVERAL_UNTAKEN.with_numbers(count=count))
        if not self._opening.hopeful:
            return self.answer(motion.Failure.OUT_OF_REACH)
        return None

    def caught(
        self, attempt: Attempt, clearance: float, cognitive_map: CognitiveMap | None = None
    ) -> Plan:
        """A plan with a verified catch."""
        target = self.situation.bodies[attempt.body]
        body, time = target.name, attempt.time
        time = attempt.trajectory.duration if time is None else time
        return Plan(
            name=self.situation.name,
            planner=self.planner,
            status="caught",
            message=f"caught {body!r} at {time:.3f} s",
            planning_ms=self.elapsed_ms,
            catch_time=time,
            held_until=None if target.hold is None else attempt.until,
            catch_body=body,
            clearance=clearance,
            trajectory=attempt.trajectory,
            map=cognitive_map,
            nodes=self.nodes,
            format=self.situation.format,
        )


@dataclass(frozen=True)
class Attempt:
    """Unverified trajectory to a target; by default the catch is at the trajectory's end."""

    trajectory: motion.Movement
    body: int
    time: float | None = None
    """Time of the catch [s]; the trajectory's end by default."""
    until: float | None = None
    """End of the hold [s]."""


class Problem(Task):
    """Planning problem for a planar arm."""

    situation: Situation

    def __init__(
        self,
        situation: AnySituation,
        planner: str,
        scene: Scene | None = None,
        deadline: Deadline | None = None,
    ) -> None:
        if not in_plane(kind_of(situation)):
            raise refused(planner, situation)
        super().__init__(situation, planner, scene, deadline)


class JointProblem(Task):
    """Planning problem for an arm that moves in its joints."""

    situation: Situation[Any]

    @cached_property
    def study(self) -> Study:
        """The scene, the rules and buffers for planning moves, within the limit of work."""
        made = study_of(self.scene, self.rules)
        return made._replace(desk=made.desk._replace(budget=self.budget))

    @property
    def accelerates(self) -> bool:
        """Return whether the joints' accelerations are limited."""
        return self.situation.arm.max_joint_acceleration is not None

    def early_answer(
        self, keeps_acceleration: bool = False, keeps_ends: bool = False
    ) -> Plan | None:
        """Return the answer that needs no planning.

        Parameters
        ----------
        keeps_acceleration : bool
            Planners that do not keep limits of acceleration have no plan under them.
        keeps_ends : bool
            Others have no plan where a touch will not do.
        """
        early = super().early_answer()
        if early is None and not keeps_ends and not ends_by_touch(self.situation):
            early = self.answer(motion.Failure.END_UNTAKEN)
        if early is None and self.accelerates and not keeps_acceleration:
            early = self.answer(motion.Failure.ACCELERATION_UNTAKEN)
        return early


def ends_by_touch(situation: AnySituation) -> bool:
    """Return whether a movement that ends with a touch answers a situation."""
    held = any(target.hold is not None for target in situation.targets)
    jerk = getattr(situation.arm, "max_joint_jerk", None)
    return not held and situation.end == "free" and jerk is None


def until(situation: Situation, bound: float | None) -> Situation:
    """Return the situation in which only catches until a bound count [s]."""
    end = end_of(situation, bound)
    return situation if end == situation.horizon else replace(situation, horizon=end)


def straight_catch(
    problem: Problem, start: np.ndarray, since: float, *, after: float = 0.0, wait: bool = False
) -> tuple[np.ndarray, np.ndarray, int] | None:
    """Go straight from `start`, left at time `since`, to the earliest interception.

    Parameters
    ----------
    problem : Problem
    start : (2,) ndarray
    since : float
        [s]
    after : float
        Interceptions before this time do not count [s].
    wait : bool
        Spend what time is left over at the start; else it is spread evenly over the path.

    Returns
    -------
    time : (m,) ndarray
    hand : (m, 2) ndarray
        Both include the start.
    body : int
        Index of the target; None instead of all if there is no interception.
    """
    arm, instant = problem.situation.arm, problem.rules.instant
    search = max(since, after)
    for _ in range(1 if arm.max_joint_speed is None else _MORE_TRIES):
        t, body, px, py = motion.first_interception(
            problem.scene, problem.rules, *start, since, search, problem.situation.horizon
        )
        if body < 0:
            return None
        hand = motion.straight_path(start, np.array([px, py]))
        _, hand = motion.refine(arm, np.zeros(len(hand)), hand)
        sooner = np.concatenate([[0.0], np.cumsum(motion.segment_times(arm, hand))])
        if t <= since or sooner[-1] <= (t - since) * (1.0 + 1e-12):
            if wait and sooner[-1] < t - since:
                time = np.concatenate([[since], t - sooner[-1] + sooner[:-1], [t]])
                return time, np.vstack([hand[:1], hand]), body
            share = (t - since) / sooner[-1] if sooner[-1] > 0.0 else 0.0
            time = since + sooner * share if share > 0.0 else np.linspace(since, t, len(hand))
            time[-1] = t
            return time, hand, body
        search = max(since + sooner[-1], t + instant)
    return None


def path_through(
    arm: Arm, places: np.ndarray, arrival: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Way from the hand straight from place to place, with waits.

    Parameters
    ----------
    places, arrival : (k, 2), (k,) ndarray
        Where the hand turns or waits, and when it comes there [s].

    Returns
    -------
    hand : (m, 2) ndarray
        Straight pieces, sampled.
    wanted : (m,) ndarray
        When the hand should be there [s]; it waits at the end of each piece.
    """
    hand, wanted = [np.array([arm.hand])], [np.zeros(1)]
    for place, come in zip(places, arrival, strict=True):
        piece = motion.straight_path(hand[-1][-1], place)
        under_way = np.concatenate([[0.0], np.cumsum(motion.segment_times(arm, piece))])
        leave = max(come - under_way[-1], wanted[-1][-1])
        share = under_way / max(under_way[-1], 1e-300)
        times = leave + share * (come - leave)
        hand += [piece[:1], piece[1:]]
        wanted += [np.array([leave]), times[1:]]
    return np.vstack(hand), np.concatenate(wanted)


def finish(problem: Problem, hand: np.ndarray, arrival: np.ndarray) -> Attempt | None:
    """Time a path through hand-space by the front's arrival and end the path on a target.

    The movement ends where the hand first comes within grasp of a target.  Without a
    catch along the path, it goes on straight from the path's end to the earliest interception.

    Parameters
    ----------
    hand : (n, 2) ndarray
    arrival : (n,) ndarray
        When the front was there [s].
    """
    time, hand = timed(problem.situation.arm, arrival, hand)
    t, body = first_catch_on(problem, time, hand)
    if body < 0:
        return go_on(problem, time, hand, straight_catch(problem, hand[-1], float(time[-1])))
    k = int(np.searchsorted(time, t, side="left"))
    end = [np.interp(t, time, hand[:, a]) for a in (0, 1)]
    return attempt_of(problem, np.append(time[:k], t), np.vstack([hand[:k], [end]]), body)


def first_catch_on(problem: Problem, time: np.ndarray, hand: np.ndarray) -> tuple[float, int]:
    """First catch along a timed path (n,), (n, 2): when [s] (-1 if never), and which body."""
    rules = problem.rules
    t, body = motion.first_catch(
        problem.bodies, time, hand, rules.catch, CATCH_STEP * rules.instant
    )
    return t, body


def timed(arm: Arm, arrival: np.ndarray, hand: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Times (m,) and hands (m, 2) of a path that keeps the arm's limits; see `finish`."""
    arrival, hand = motion.refine(arm, arrival, out_of_hole(arm, hand))
    return motion.keep_limits(arm, hand, arrival), hand


def go_on(
    problem: Problem,
    time: np.ndarray,
    hand: np.ndarray,
    ending: tuple[np.ndarray, np.ndarray, int] | None,
) -> Attempt | None:
    """Extend a timed path by the straight ending of `straight_catch`; None without an ending."""
    if ending is None:
        return None
    time = np.concatenate([time, ending[0][1:]])
    return attempt_of(problem, time, np.vstack([hand, ending[1][1:]]), ending[2])


def hole_of(arm: Arm) -> float:
    """Distance that moves keep from the shoulder: of the hole's rim, or of the singular point.

    A hand that starts nearer may go on from there.
    """
    nearest = math.hypot(*arm.hand)
    if arm.inner_reach > 0.0:
        return min(arm.inner_reach + motion.HOLE_MARGIN, nearest * (1.0 - 1e-8))
    return min(motion.HOLE_MARGIN, 0.5 * nearest)


def out_of_hole(arm: Arm, hand: np.ndarray) -> np.ndarray:
    """Push samples out of the hole in the ring, which a smooth path may cut by part of a cell."""
    radius = np.sqrt((hand[1:] ** 2).sum(axis=1))
    least = arm.inner_reach + motion.HOLE_MARGIN
    if arm.inner_reach == 0.0 or radius.min() >= least:
        return hand
    scale = np.maximum(least / np.maximum(radius, 1e-9), 1.0)
    return np.vstack([hand[:1], hand[1:] * scale[:, None]])


def attempt_of(problem: Problem, time: np.ndarray, hand: np.ndarray, body: int) -> Attempt:
    """Make an attempt of a timed hand path."""
    arm = problem.situation.arm
    return Attempt(motion.Movement.of_hand(arm, time, hand), body)


def judged(
    problem: Task, attempt: Attempt, cognitive_map: CognitiveMap | None = None
) -> tuple[Plan | None, motion.Verdict]:
    """Verify an attempt; return the plan (None if verification fails) and the verdict."""
    ask = None
    if attempt.time is not None:
        catch = attempt.body, attempt.time, attempt.until or attempt.time
        ask = motion.Ask.of(problem.situation, [catch])
    verdict = motion.verify(problem.scene, problem.rules, attempt.trajectory, attempt.body, ask)
    if not verdict.good:
        return None, verdict
    return problem.caught(attempt, verdict.clearance, cognitive_map), verdict


def checked(problem: Task, attempt: Attempt) -> tuple[Plan | None, motion.Reason | None]:
    """Verify an attempt; return the plan, or None and the reason of the failure."""
    plan, verdict = judged(problem, attempt)
    return plan, verdict.reason


def straight_plan(problem: Problem) -> Plan:
    """Plan a straight way to the earliest interception; if it fails, the plan has the reason."""
    path = straight_catch(problem, np.array(problem.situation.arm.hand), 0.0)
    if path is None:
        return problem.answer(motion.Failure.NO_STRAIGHT_LINE)
    time, hand, body = path
    if time[-1] <= 0.0:
        time, hand = time[:1], hand[:1]
    plan, reason = checked(problem, attempt_of(problem, time, hand, body))
    return problem.answer(reason or motion.Failure.NO_STRAIGHT_LINE) if plan is None else plan
