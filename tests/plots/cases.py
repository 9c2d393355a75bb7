"""A situation and a movement of every kind of arm."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from gcm_learn.families import PAPER_SCENES, draw
from gcm_learn.planners import Plan, solve
from gcm_learn.situation import SolidQuadratic, read_situations
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


def swung() -> Case:
    """A planar arm among solids, whose target swings into its plane from beyond its reach."""
    situation = PAPER_SCENES["fig8"]()
    return situation, solve(situation, "gcm")


def late() -> Case:
    """A planar arm whose target is beyond its reach at the start."""
    situation = draw("late-target", 1, 2)
    return situation, solve(situation, "layered")


def from_afar(case: Callable[[], Case]) -> Case:
    """Return a case whose target comes from five reaches away and is met at the end."""
    situation, plan = case()
    arm, end = situation.arm, plan.trajectory.duration
    target = situation.targets[0]
    meeting = plan.trajectory.hand_at(end)
    start = np.asarray(arm.base.origin) + arm.reach * np.array([3.0, 3.0, 3.0])
    law = SolidQuadratic(tuple(start), tuple((meeting - start) / end), (0.0, 0.0, 0.0))
    bodies = [replace(b, motion=law) if b is target else b for b in situation.bodies]
    return replace(situation, bodies=tuple(bodies)), plan


CASES = {"planar": planar, "spatial": spatial, "chain": chain}
FAR = {
    "planar": late, "planar among solids": swung,
    "spatial": lambda: from_afar(spatial), "chain": lambda: from_afar(chain),
}  # fmt: skip
AMONG_SOLIDS = {name: CASES[name] for name in ("spatial", "chain")}


def params(cases: dict[str, Callable[[], Case]]) -> list[Any]:
    """Return the names of cases; spatial arms, drawn as chains are, are for the slow tests."""
    slow = pytest.mark.slow
    return [pytest.param(name, marks=slow if name == "spatial" else ()) for name in cases]


def plan_of(situation: Any, trajectory: Any = None) -> Plan:
    """Return a plan with a movement that is said to catch, or one without a catch."""
    caught = trajectory is not None
    return Plan(
        situation.name, "straight", "caught" if caught else "unreachable", "it has no way", 1.0,
        trajectory.duration if caught else None, situation.targets[0].name if caught else None,
        0.1 if caught else None, trajectory,
    )  # fmt: skip
