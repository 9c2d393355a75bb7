"""Orders in which several targets are caught, leg after leg.

An order yields ever better courses: more catches, or as many that end earlier.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from gcm_learn.arms import hands_along
from gcm_learn.planners.joints.meetings import soonest
from gcm_learn.planners.plan import Plan
from gcm_learn.scene import later

SHORT, GROWTH, LONG = 0.002, 3.0, 1.0
"""Time of a leg at first [s], by how much it grows, and from when on it is enough [s]."""
Leg = Callable[..., Plan]
"""Plans one catch, of the targets that its situation has.  `growing` gives a `deadline`."""
Halt = Callable[[], bool]
"""Tells whether time is up."""


class LegCourse(NamedTuple):
    """Legs of a movement, and the situation that they leave."""

    now: Any
    """At the end of the last leg, with the targets that are left."""
    legs: tuple[Plan, ...] = ()
    until: float = 0.0
    """End of the last leg [s]."""

    @property
    def worth(self) -> tuple[int, float]:
        """Number of catches, then the negative end of the last leg [s]; larger is better."""
        return len(self.legs), -self.until

    @property
    def left(self) -> list[str]:
        """Names of the targets that are left; none at the horizon."""
        return [target.name for target in self.now.targets] if self.now is not None else []

    def with_leg(self, plan: Plan) -> LegCourse:
        """Return the course extended by a leg that catches."""
        moves = plan.trajectory
        end = 0.0 if moves is None else moves.duration
        legs, until = (*self.legs, plan), self.until + end
        names = set(self.left) - {plan.catch_body}
        if moves is None or not names or end >= self.now.horizon:
            return LegCourse(None, legs, until)
        arm = self.now.arm
        joints = np.clip(moves.joints[-1], *np.array(arm.joint_range).T)  # rounding leaves the ends
        rates = None
        if moves.rates is not None:
            most = np.array(arm.max_joint_speed)
            rates = tuple(np.clip(moves.rates[-1], -most, most).tolist())
        now = later(with_targets(self.now, names), end, joints=tuple(joints.tolist()), rates=rates)
        return LegCourse(now, legs, until)


def with_targets(situation: Any, names: set[Any]) -> Any:
    """Return the situation with only the targets in `names`; `catch` is "any" for a single one."""
    bodies = tuple(b for b in situation.bodies if b.role != "target" or b.name in names)
    return replace(situation, bodies=bodies, catch="any" if len(names) == 1 else situation.catch)


def as_found(leg: Leg, course: LegCourse, halt: Halt) -> Iterator[LegCourse]:
    """Catch whichever target a leg catches first, then the next."""
    while course.left and not halt():
        plan = leg(course.now)
        if not plan.caught:
            return
        course = course.with_leg(plan)
        yield course


def by_distance(leg: Leg, course: LegCourse, halt: Halt) -> Iterator[LegCourse]:
    """Catch the target nearest to the hand, then the next; pass over those that no leg catches."""
    return _greedy(leg, course, halt, distances)


def by_time(leg: Leg, course: LegCourse, halt: Halt) -> Iterator[LegCourse]:
    """Catch the target that can be met soonest, then the next; pass over as by distance."""
    return _greedy(leg, course, halt, soonest)


def _greedy(
    leg: Leg, course: LegCourse, halt: Halt, costs_of: Callable[[Any], dict[str, float]]
) -> Iterator[LegCourse]:
    costs = costs_of(course.now)
    while costs and not halt():
        name = min(costs, key=lambda name: costs[name])
        plan = leg(with_targets(course.now, {name}))
        if plan.caught:
            course = course.with_leg(plan)
            yield course
        if not course.left:
            return
        costs = costs_of(course.now) if plan.caught else {**costs, name: np.inf}
        if min(costs.values(), default=np.inf) == np.inf:
            return


def distances(situation: Any) -> dict[str, float]:
    """Return the distance of each target's centre from the hand."""
    hand = hands_along(situation.arm, [situation.arm.joints])[0][0]
    return {
        body.name: float(np.linalg.norm(np.array(body.motion.position) - hand))
        for body in situation.targets
    }


def bounded(
    leg: Leg, course: LegCourse, halt: Halt, known: LegCourse | None = None
) -> Iterator[LegCourse]:
    """Try orders by branch and bound, depth first, the target that can be met soonest first.

    The bound counts the targets that could be met in time if nothing were in the way.  Those for
    which no time is known come last.  Only courses better than a known one are yielded.
    """
    best = [known or course]

    def visit(course: LegCourse) -> Iterator[LegCourse]:
        if course.worth > best[0].worth:
            best[0] = course
            yield course
        if not course.left or halt():
            return
        times = soonest(course.now)
        most, last = len(course.legs) + len(times), max(times.values(), default=np.inf)
        for name in sorted(course.left, key=lambda name: times.get(name, np.inf)):
            if halt() or (most, -course.until - last) <= best[0].worth:
                return
            plan = leg(with_targets(course.now, {name}))
            if plan.caught:
                yield from visit(course.with_leg(plan))
            elif name in times:
                most -= 1

    return visit(course)


def growing(leg: Leg, course: LegCourse, halt: Halt) -> Iterator[LegCourse]:
    """Try orders as `bounded` does, again and again, each time with more time for a leg."""
    best, seconds = course, SHORT
    while seconds < LONG and not halt():
        for better in bounded(partial(leg, deadline=seconds), course, halt, best):
            best = better
            yield better
        seconds *= GROWTH


ORDERS: dict[str, Callable[[Leg, LegCourse, Halt], Iterator[LegCourse]]] = {
    "found": as_found,
    "distance": by_distance,
    "time": by_time,
    "bound": bounded,
    "grow": growing,
}
"""Orders by name."""
