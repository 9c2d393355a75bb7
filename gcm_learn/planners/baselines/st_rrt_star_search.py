"""ST-RRT* of OMPL over places and time; only its planner imports this module, which needs ompl.

OMPL's planner knows goals that stand still: it asks for a goal's place and draws its time itself.
Ours exist for an instant only, so places and times are drawn together.  The time that OMPL had
drawn is replaced when it next asks whether that state is valid.  Everything else is as OMPL has
it: both trees, conditional sampling, rewiring, pruning.
"""

from __future__ import annotations

import math
import time as clock
from collections.abc import Callable
from typing import Any

import ompl

from gcm_learn import seeding
from gcm_learn.arms import Arm
from gcm_learn.motion import Rules
from gcm_learn.planners.baselines.st_rrt_star_joints import JointTask
from gcm_learn.planners.baselines.st_rrt_star_moves import HandTask, leg_holds
from gcm_learn.scene import pack
from gcm_learn.situation import Body, Disc, PlanarQuadratic, Situation

# The wheel of 1.7.0 holds its library twice: the modules find the one they are linked with, and
# `dll_loader` loads the other on top, after which the process crashes when it ends.
ompl.dll_loader = lambda *_: None

from ompl import base, geometric, util  # noqa: E402

if not hasattr(geometric, "STRRTstar"):
    raise ImportError("this version of ompl has no STRRTstar", name="ompl")

TRIES = 16  # drawings of a goal at a time
EARLY = 1e-3  # catches within this share of the unhindered interception are early enough

Path = list[tuple[float, ...]]  # place and time of the states


SpaceTime = HandTask | JointTask
"""Search space: places, goals, legs, and how long to search."""


class Search:
    """One run of the planner, from an empty tree.

    Parameters
    ----------
    task : SpaceTime
    report : callable
        Gets the time used [ms] and the path whenever a better one is found.
    """

    def __init__(self, task: SpaceTime, report: Callable[[float, Path], None]) -> None:
        self.started = clock.thread_time()
        self.task, self.report = task, report
        self.best, self.looks = task.scene.limits.horizon, 0
        util.setLogLevel(util.LogLevel.LOG_NONE)
        util.RNG.setSeed(task.seed + 1)  # every generator made from now on follows from it
        self.space = _space(task)
        self.information = base.SpaceInformation(self.space)
        self.goals = _Goals(self.information, self)
        self.validity = _Validity(self.information, self)
        self.motions = _Motions(self.information, self)
        self.information.setStateValidityChecker(self.validity)
        self.information.setMotionValidator(self.motions)
        self.information.setup()
        start = base.State(self.space)
        for k, value in enumerate((*task.start, 0.0)):
            start[k] = value
        problem = base.ProblemDefinition(self.information)
        problem.addStartState(start)
        problem.setGoal(self.goals)
        # OMPL does not keep Python's functions and objects alive: we do.
        self.told = base.ReportIntermediateSolutionFn(self._improved)
        self.over = base.PlannerTerminationConditionFn(self._is_over)
        problem.setIntermediateSolutionCallback(self.told)
        self.planner = geometric.STRRTstar(self.information)
        self.planner.setProblemDefinition(problem)
        self.planner.setup()
        self.kept = (start, problem)

    @property
    def used_ms(self) -> float:
        """Processor time since the beginning [ms]."""
        return 1e3 * (clock.thread_time() - self.started)

    def run(self) -> None:
        """Search until the time is over or nothing better is to be expected."""
        self.planner.solve(base.PlannerTerminationCondition(self.over))

    def _is_over(self) -> bool:
        self.looks += 1
        return (
            self.looks > self.task.iterations
            or self.best <= self.task.unhindered * (1.0 + EARLY)
            or self.used_ms >= self.task.budget_ms
        )

    def _improved(self, _planner: Any, states: Any, _cost: Any) -> None:
        axes = range(len(self.task.start))
        path = [(*(s[0][k] for k in axes), self.space.getStateTime(s)) for s in states]
        self.best = path[-1][-1]
        self.report(self.used_ms, path)


class _Goals(base.GoalSampleableRegion):  # type: ignore[misc]
    """Goal region of interceptions: drawn places, each with its own instant."""

    def __init__(self, information: Any, search: Search) -> None:
        super().__init__(information)
        self.search, self.task = search, search.task
        self.rng = seeding.rng(search.task.seed)
        self.drawn: tuple[float, ...] | None = None

    def sampleGoal(self, state: Any) -> None:
        chances = self.rng.random((TRIES, self.task.draws))
        t, *place = self.task.draw(self.search.best, chances)
        for k, value in enumerate(place):
            state[0][k] = value
        self.drawn = (*place, t)

    def maxSampleCount(self) -> int:
        return 1_000_000_000

    def couldSample(self) -> bool:
        return True

    def distanceGoal(self, _state: Any) -> float:
        return 1.0  # asked only of states that no goal was reached from


class _Validity(base.StateValidityChecker):  # type: ignore[misc]
    """Gives goals their instant; all else is left to the check of legs, which has their ends."""

    def __init__(self, information: Any, search: Search) -> None:
        super().__init__(information)
        self.space, self.goals = search.space, search.goals
        self.numbers = util.vectorDouble()
        self.numbers.extend([0.0] * (len(search.task.start) + 1))

    def isValid(self, state: Any) -> bool:
        drawn = self.goals.drawn
        if drawn is None:
            return True
        place = state[0]
        if any(place[k] != value for k, value in enumerate(drawn[:-1])):
            return True
        self.goals.drawn = None
        if drawn[-1] < 0.0:
            return False
        for k, value in enumerate(drawn):
            self.numbers[k] = value
        self.space.copyFromReals(state, self.numbers)
        return True


class _Motions(base.MotionValidator):  # type: ignore[misc]
    """Legs by the same continuous clearance that verifies plans."""

    def __init__(self, information: Any, search: Search) -> None:
        super().__init__(information)
        self.task = search.task
        self.time_of = search.space.getStateTime

    def checkMotion(self, a: Any, b: Any) -> bool:
        return self.task.holds(a[0], self.time_of(a), b[0], self.time_of(b))


def _space(task: SpaceTime) -> Any:
    """Places and time, with the speed that OMPL reckons with."""
    ends = task.bounds
    bounds = base.RealVectorBounds(len(ends))
    for axis, (low, high) in enumerate(ends):
        bounds.setLow(axis, low)
        bounds.setHigh(axis, high)
    places = base.RealVectorStateSpace(len(ends))
    places.setBounds(bounds)
    space = base.SpaceTimeStateSpace(places, task.speed)
    space.setTimeBounds(0.0, task.scene.limits.horizon)
    space.setup()
    return space


def warm_up() -> None:
    """Load all code that a search needs, by a search that finds no goal."""
    still = PlanarQuadratic((9.0, 0.0), (0.0, 0.0), (0.0, 0.0))
    away, post = (Body(role, role, Disc(0.1), still) for role in ("target", "obstacle"))
    scene = pack(Situation("warm", 1.0, Arm((1.0, 0.0), 3.0), (away, post)))
    rules = Rules(touch=0.0, catch=0.05, speed=3.0, instant=1e-3)
    for joints in (9.0, math.inf):
        scene = scene._replace(limits=scene.limits._replace(shoulder=joints, elbow=joints))
        leg_holds(scene, rules, 0.1, 1.0, 0.0, 0.0, 1.1, 0.0, 0.5)
    Search(HandTask(scene, rules, 0.1, 0.5, 0, 1e3, 3), lambda *_: None).run()
