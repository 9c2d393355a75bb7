"""A film of two arms in one cell, the second planned among the links of the first."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from gcm_learn.arms import Base, Chain
from gcm_learn.motion import as_obstacles, with_stop
from gcm_learn.planners import Plan, solve
from gcm_learn.plots.figures.film import animate
from gcm_learn.situation import Body, Situation, SolidQuadratic, Sphere, shipped_arm

HOME = (0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785)
APART = 1.0  # of the two bases [m]
HORIZON = 1.5  # [s]
NOTHING = (0.0, 0.0, 0.0)


def two_arms() -> tuple[Situation[Chain], Plan]:
    """Return the second arm's situation, with the first arm's links as obstacles, and its plan.

    Two Pandas stand face to face, and their ways to the balls cross.  The plan of the second alone
    would run into the first after 0.2 s.  All numbers are chosen.
    """
    model = shipped_arm("panda")
    first = Chain(model, joints=HOME, grasp=0.05)
    turned = Base((APART, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0))
    second = Chain(model, joints=HOME, grasp=0.05, base=turned)
    one: Any = Situation("first", HORIZON, first, (_ball((0.64, -0.44, 0.63), (0.0, 0.15, 0.0)),))
    moves = solve(one).trajectory
    if moves is None:
        raise RuntimeError("no catch to show")
    links = as_obstacles(with_stop(one, moves), "first")
    other = _ball((0.29, -0.35, 0.69), (0.0, 0.15, 0.0))
    cell: Any = Situation("second", HORIZON, second, (other, *links))
    return cell, solve(cell)


def write_cell_film(path: Path, frames: int) -> None:
    """Write the film of `two_arms` as a GIF."""
    cell, plan = two_arms()
    animate(cell, plan, path, frames=frames)


def _ball(position: tuple[float, float, float], velocity: tuple[float, float, float]) -> Body:
    return Body("target", "ball", Sphere(0.04), SolidQuadratic(position, velocity, NOTHING))
