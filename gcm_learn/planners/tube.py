"""Plans with clearance for an arm that follows them inexactly: a tube about the limb's way."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

from gcm_learn.arms import CHAIN, ByKind
from gcm_learn.motion import Failure, fastest_hand, start_clearance
from gcm_learn.planners.completion import JointProblem
from gcm_learn.planners.outside import judged_anew
from gcm_learn.planners.plan import Plan
from gcm_learn.scene import pack
from gcm_learn.situation import AnySituation, Situation

HURRIES = (1.0, 0.7, 0.5, 0.35)
"""Shares of the hand's fastest speed that are tried in turn: the slower, the narrower the tube."""
GRASP = 0.2
"""Share of the grasp that is left at least, however wide the tube is."""
START = 0.9
"""Share of the clearance at the start that a tube takes at most, since nothing changes that."""


@dataclass(frozen=True)
class Tube:
    """Largest distance of a limb's points from where the plan has them, in the arm's unit.

    Parameters
    ----------
    still : float
        When the hand is slow; not negative.
    per_speed : float
        Addition for each unit of the hand's speed; not negative [s].
    """

    still: float = 0.0
    per_speed: float = 0.0

    def __post_init__(self) -> None:
        for name in ("still", "per_speed"):
            value = getattr(self, name)
            if not 0.0 <= value < 1e6:
                raise ValueError(f"{name}: must be from 0 on (got {value!r})")

    def at(self, speed: float) -> float:
        """Clearance to keep at a speed of the hand."""
        return self.still + self.per_speed * speed

    def scaled(self, unit: float) -> Tube:
        """Return the tube in a unit in which a length of 1 is `unit`."""
        return Tube(self.still * unit, self.per_speed * unit)


_TAKEN = ByKind({CHAIN: True}, who="a tube")


@dataclass(frozen=True)
class InTube:
    """Planner for the real arm by a plan for a thicker, slower arm with a smaller grasp.

    The limb then keeps the tube's width to all obstacles, and the hand meets the target that much
    deeper within its grasp.

    Parameters
    ----------
    planner : Planner
        One that takes such arms.
    tube : Tube
    """

    planner: Any
    tube: Tube

    takes = staticmethod(_TAKEN.takes)

    @property
    def name(self) -> str:
        """Name of the planner."""
        return str(self.planner.name)

    def plan(self, situation: AnySituation) -> Plan:
        """Answer a situation."""
        _TAKEN.of(situation)
        problem = JointProblem(situation, self.name)
        early = problem.early_answer(keeps_acceleration=True, keeps_ends=True)
        if early is not None:
            return early
        top = fastest_hand(problem.scene)
        for hurry in HURRIES:
            plan = self.planner.plan(self._eased(problem, hurry * top))
            if plan.trajectory is None:
                continue
            moves = replace(plan.trajectory, arm=situation.arm)
            found = replace(plan, trajectory=moves, planning_ms=problem.elapsed_ms)
            fault, clearance = judged_anew(situation, found)
            if fault is None:
                return replace(found, clearance=clearance)
        return problem.answer(Failure.NO_INTERCEPTION)

    def _eased(self, problem: Any, speed: float) -> Situation[Any]:
        """The situation with an arm that needs the tube's clearance.

        Its links may overlap each other if they did at the start: the plan is verified anyway.
        """
        situation, width = problem.situation, self.tube.at(speed)
        arm = situation.arm
        clear = start_clearance(pack(replace(situation, arm=arm.without_pairs())))
        eased = replace(
            arm.thicker(min(width, START * clear)),
            grasp=max(arm.grasp - width, GRASP * arm.grasp),
            max_hand_speed=speed,
        )
        made = replace(situation, arm=eased)
        if start_clearance(pack(made)) > 0.0:
            return made
        return replace(made, arm=eased.without_pairs())
