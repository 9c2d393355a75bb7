"""Problems of others: what is drawn of them, and how a frozen world is planned in."""

from __future__ import annotations

import importlib
import json
import sys
import tarfile
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from gcm_learn.arms import Chain, hands_along
from gcm_learn.evaluation import complaints
from gcm_learn.situation import (
    Body,
    Box,
    Situation,
    SolidQuadratic,
    Sphere,
    shipped_arm,
)

ROOT = Path(__file__).parents[2]
FOLDER = ROOT / "experiments" / "18_outside"
DATA = ROOT / "tests" / "outside" / "data"
NAMES = ("suites", "frozen")
READY = (0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785)
NONE = (0.0, 0.0, 0.0)


@pytest.fixture
def modules(monkeypatch):
    """Return the experiment's modules as its command imports them."""
    monkeypatch.syspath_prepend(FOLDER)
    before = {name: sys.modules.pop(name, None) for name in NAMES}
    yield SimpleNamespace(**{name: importlib.import_module(name) for name in NAMES})
    for name in NAMES:
        del sys.modules[name]
        if before[name] is not None:
            sys.modules[name] = before[name]


# --- suites ----------------------------------------------------------------------------------


@pytest.fixture
def archive(tmp_path):
    """Return an archive with problems 1 to 24 of two sets, all alike."""
    path = tmp_path / "problems.tar.bz2"
    with tarfile.open(path, "w:bz2") as packed:
        for folder in ("tall_panda", "thin_panda"):
            for number in range(1, 25):
                for kind in ("scene", "request"):
                    source = DATA / "shelf" / f"{kind}0001.yaml"
                    packed.add(source, f"all/{folder}/{kind}{number:04d}.yaml")
    return path


def test_problems_are_drawn_from_the_seed_and_not_from_the_part_for_development(modules, archive):
    first, again, other = (
        [q.name for q in modules.suites.problems(archive, seed, 2)] for seed in (1, 1, 2)
    )
    assert first == again != other and len(first) == 8 and len(set(first)) == 4
    assert {int(name[-4:]) for name in [*first, *other]} <= {21, 22, 23, 24}
    old = [q.name for q in modules.suites.problems(archive, 1, 2, development=True)]
    assert {int(name[-4:]) for name in old} <= set(range(1, 21))


def test_problems_know_their_own_goal(modules, archive):
    found = list(modules.suites.problems(archive, 3, 1))
    still = next(q for q in found if q.suite == modules.suites.RESTING)
    moving = next(q for q in found if q.suite == modules.suites.IN_MOTION and q.name == still.name)
    assert still.goal == moving.goal
    hands, _ = hands_along(still.situation.arm, [still.goal])
    (target,) = still.situation.targets
    assert np.allclose(hands[0], target.motion.position, atol=1e-9)


def test_scenes_begin_at_several_frames(modules):
    found = list(modules.suites.scenes([DATA / "flying.json"], starts=2))
    whole, half = (q.situation for q in found)
    assert half.horizon == pytest.approx(0.5 * whole.horizon)
    content = json.loads((DATA / "flying.json").read_text())
    named = dict(zip(content["robot_joints_order"], content["end_configuration"], strict=True))
    assert found[0].goal == tuple(named[joint.name] for joint in whole.arm.model.joints)


# --- the frozen world ------------------------------------------------------------------------


class Straight:
    """VAMP's interface to a planner that goes straight to the first goal, wherever it leads."""

    def __init__(self) -> None:
        self.worlds, self.plans = [], 0
        self.robots, self.panda = ["panda"], self
        self.halton = lambda: None
        self.Environment = lambda: SimpleNamespace(boxes=[], add_cuboid=lambda b: None)
        self.Cuboid = lambda place, turn, half: self.worlds.append(place)

    def configure_robot_and_planner_with_kwargs(self, *names):
        return None, None, SimpleNamespace(), None

    def validate(self, q, world):
        return True

    def validate_motion(self, p, q, world):
        return True

    def rrtc(self, start, goals, world, settings, draws):
        self.plans += 1
        path = SimpleNamespace(numpy=lambda: np.array([start, goals[0]]))
        return SimpleNamespace(solved=True, path=path)

    def simplify(self, path, world, settings, draws):
        return SimpleNamespace(path=path)


@pytest.fixture
def straight(modules, monkeypatch):
    made = Straight()
    monkeypatch.setattr(modules.frozen, "vamp", made)
    return made


def scene(velocity, *obstacles):
    """Return a ball that drifts in front of a Panda."""
    ball = Body("target", "ball", Sphere(0.02), SolidQuadratic((0.5, 0.1, 0.5), velocity, NONE))
    arm = Chain(shipped_arm("panda"), READY, 0.02)
    return Situation("drift", 3.0, arm, (ball, *obstacles))


@pytest.mark.parametrize("velocity", [NONE, (0.0, 0.1, 0.0)])
def test_planning_anew_meets_the_target_within_the_joints_limits(modules, straight, velocity):
    situation = scene(velocity)
    done = modules.frozen.Frozen(situation, None).run()
    assert done.plan.caught and done.good
    found = complaints(situation, done.plan)
    assert [text for text in found if not text.startswith("clearance")] == []
    periods = done.plan.catch_time / modules.frozen.PERIOD
    assert straight.plans >= periods - 1


def test_the_world_is_frozen_where_bodies_are_in_each_period(modules, straight):
    wall = SolidQuadratic((-0.6, 0.0, 0.5), (0.0, 0.0, 0.1), NONE)
    situation = scene(NONE, Body("obstacle", "wall", Box((0.05, 0.05, 0.05)), wall))
    modules.frozen.Frozen(situation, None).run()
    heights = np.array(straight.worlds)[:, 2]
    assert heights == pytest.approx(0.5 + 0.1 * modules.frozen.PERIOD * np.arange(len(heights)))


def test_what_the_frozen_world_does_not_show_is_touched(modules, straight):
    """The stand-in goes straight through a wall; verification and referee see it."""
    wall = Body(
        "obstacle", "wall", Box((0.02, 0.3, 0.3)), SolidQuadratic((0.45, 0.1, 0.6), NONE, NONE)
    )
    situation = scene(NONE, wall)
    done = modules.frozen.Frozen(situation, None).run()
    assert done.plan.caught and not done.good
    assert any(" touch, " in text for text in complaints(situation, done.plan))


def test_plans_that_come_too_late_are_not_followed(modules, straight):
    done = modules.frozen.Frozen(scene(NONE), None, limit_ms=0.0).run()
    assert not done.plan.caught and straight.plans > 100 and done.plans == 0


def test_without_vamp_it_takes_nothing(modules, monkeypatch):
    monkeypatch.setattr(modules.frozen, "vamp", None)
    assert not modules.frozen.takes(scene(NONE))
