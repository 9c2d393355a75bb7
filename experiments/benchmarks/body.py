"""Measure the arm in MuJoCo on one core: bare steps, and whole executed catches in their times.

    python -m experiments benchmarks/body

Times are processor times. Ratios are medians of paired runs in this one process.
"""

from __future__ import annotations

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("NUMBA_NUM_THREADS", "1")

import argparse
import statistics
import time
from collections.abc import Callable
from dataclasses import replace
from typing import Any

from gcm_learn.arms import SpatialArm
from gcm_learn.execution import body_for, execute, with_motor_limits
from gcm_learn.execution.body.model import compiled, model_xml, mujoco
from gcm_learn.families import paper_scene
from gcm_learn.planners import get_planner
from gcm_learn.situation import Body, Situation, SolidQuadratic, Sphere

STEPS, REPEATS = 2000, 15
STILL = (0.0, 0.0, 0.0)


def scene(bodies: int) -> Situation[SpatialArm]:
    """The paper's pendulum under the motors' limits; more bodies are balls beside the arm."""
    situation: Any = with_motor_limits(paper_scene("fig8-space"), body_for(ARM))
    places = [(0.1, 0.3, 0.2 * k) for k in range(bodies - len(situation.bodies))]
    balls = [
        Body("obstacle", f"ball at {at}", Sphere(0.05), SolidQuadratic(at, STILL, STILL))
        for at in places
    ]
    return replace(situation, bodies=(*situation.bodies, *balls))


def stepping(situation: Situation[SpatialArm], steps: int) -> Callable[[], None]:
    """Bare steps of the physics, from the start, without anything that follows a plan."""
    library, arm = mujoco(), situation.arm
    model = compiled(model_xml(arm, body_for(arm), situation.bodies))
    data = library.MjData(model)

    def go() -> None:
        library.mj_resetData(model, data)
        data.qpos[:4] = arm.joints
        for _ in range(steps):
            library.mj_step(model, data)

    return go


def spent(work: Callable[[], object]) -> float:
    """Processor time of some work [s]."""
    since = time.process_time()
    work()
    return time.process_time() - since


def bare_speed() -> str:
    """Steps per second of one arm with five bodies."""
    go = stepping(scene(5), STEPS)
    rate = STEPS / statistics.median(spent(go) for _ in range(REPEATS))
    return f"{rate:,.0f}"


def executed_against_bare() -> str:
    """A whole executed catch (model, following, braking, report) in the time of its steps alone."""
    situation, body = scene(3), body_for(ARM)
    plan: Any = get_planner("search").plan(situation)
    done = execute(plan, situation, body)
    if done.plant is None or not done.caught:
        raise RuntimeError(f"the paper's ball is not caught: {done.status} {done.message}")
    go = stepping(situation, done.plant.steps)
    pairs = [(spent(lambda: execute(plan, situation, body)), spent(go)) for _ in range(REPEATS)]
    whole, bare = (1e3 * statistics.median(column) for column in zip(*pairs, strict=True))
    ratio = statistics.median(a / b for a, b in pairs)
    return (
        f"{ratio:.2f} x  ({whole:.1f} ms against {bare:.1f} ms; {done.plant.steps} steps, caught "
        f"at {done.catch_time:.3f} s)"
    )


ARM: SpatialArm = paper_scene("fig8-space").arm  # type: ignore[assignment]


def main() -> None:
    """Print one line for each measurement, with its target."""
    argparse.ArgumentParser(description=__doc__.splitlines()[0]).parse_args()
    for what, target, measure in (
        ("steps per second, one arm and five bodies", "100,000", bare_speed),
        ("executed catch / its bare steps", "at most 3 x", executed_against_bare),
    ):
        print(f"{what}   [{target}]\n    {measure()}", flush=True)


if __name__ == "__main__":
    main()
