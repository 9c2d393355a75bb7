"""A situation and a movement of every kind of arm."""

from __future__ import annotations

from typing import Any

from gcm_learn.families import PAPER_SCENES
from gcm_learn.planners import Plan, solve
from gcm_learn.situation import read_situations
from tests.panda import PANDA
from tests.rendering.test_rendering import turning
from tests.spatial import EXAMPLES

Case = tuple[Any, Plan]


def planar() -> Case:
    """A planar scene of the paper and its catch."""
    situation = PAPER_SCENES["fig4"]()
    return situation, solve(situation, "gcm")


def spatial() -> Case:
    """A spatial arm that moves to the middle of its ranges."""
    situation = read_situations(EXAMPLES)[0]
    return situation, plan_of(situation, turning(situation))


def chain() -> Case:
    """A Panda arm that moves to the middle of its ranges."""
    (situation,) = read_situations(PANDA)
    return situation, plan_of(situation, turning(situation))


CASES = {"planar": planar, "spatial": spatial, "chain": chain}
AMONG_SOLIDS = {name: CASES[name] for name in ("spatial", "chain")}


def plan_of(situation: Any, trajectory: Any = None) -> Plan:
    """Return a plan with a movement that is said to catch, or one without a catch."""
    caught = trajectory is not None
    return Plan(
        situation.name, "straight", "caught" if caught else "unreachable", "it has no way", 1.0,
        trajectory.duration if caught else None, situation.targets[0].name if caught else None,
        0.1 if caught else None, trajectory,
    )  # fmt: skip
