"""A new kind of arm is solved, verified, written, drawn and compared without an edit elsewhere."""

from __future__ import annotations

from dataclasses import replace
from importlib import import_module

import numpy as np
import pytest

from gcm_learn import situation as records, solve
from gcm_learn.arms import Base, hands_along, register_kind
from gcm_learn.arms.limbs import register_limb
from gcm_learn.evaluation import ask, complaints
from gcm_learn.motion import rules_of, verify
from gcm_learn.plots import animate, plan_figure
from gcm_learn.scene import pack
from tests.arms.crane import CRANE, Crane, CraneLimb, chain_of

pytestmark = pytest.mark.slow  # compiled anew for the crane, whose code is not kept

ARM = Crane(
    height=0.8,
    joints=(0.3, 0.5, 0.2),
    joint_range=((-3.0, 3.0), (0.2, 1.0), (0.0, 0.6)),
    max_joint_speed=(3.0, 1.5, 1.5),
    grasp=0.03,
    base=Base((0.2, -0.1, 0.5), (0.9238795325112867, 0.0, 0.3826834323650898, 0.0)),
)
PLANNERS = ("search", "straight", "straight-wait")


@pytest.fixture(autouse=True)
def _registered(monkeypatch):
    """Register the kind for a test: others read all kinds that there are."""
    kinds = import_module("gcm_learn.arms.kinds")
    for table in ("_BY_ARM", "_BY_TYPE"):
        monkeypatch.setattr(kinds, table, dict(getattr(kinds, table)))
    register_kind(CRANE)


def flying(role, shape, place, velocity=(0.0, 0.0, 0.0)):
    place = tuple(float(x) for x in place)
    return records.Body(role, role, shape, records.SolidQuadratic(place, velocity, (0.0, 0.0, 0.0)))


def behind_a_post(arm=ARM):
    """A ball that drifts away, and a post between it and the hand."""
    (goal, middle), _ = hands_along(arm, [(1.6, 0.8, 0.4), (1.0, 0.65, 0.3)])
    ball = flying("target", records.Sphere(0.04), goal, (0.1, 0.0, 0.05))
    return records.Situation(
        "crane", 1.6, arm, (ball, flying("obstacle", records.Box((0.08, 0.08, 0.2)), middle))
    )


def test_it_stands_where_the_same_chain_does():
    joints = np.random.default_rng(1).uniform(*np.array(ARM.joint_range).T, (20, 3))
    for mine, theirs in zip(
        hands_along(ARM, joints), hands_along(chain_of(ARM), joints), strict=True
    ):
        assert mine == pytest.approx(theirs)


@pytest.mark.parametrize("planner", PLANNERS)
def test_it_is_planned_for_and_verified(planner):
    situation = behind_a_post()
    free = replace(situation, bodies=situation.bodies[:1])
    for given in (situation, free):
        plan = solve(given, planner)
        assert complaints(given, plan) == []
        assert plan.caught or (given is situation and planner != "search")
        if plan.caught:
            scene = pack(given)
            assert verify(scene, rules_of(scene), plan.trajectory, 0).good
            late = replace(plan.trajectory, time=0.5 * plan.trajectory.time)
            assert not verify(scene, rules_of(scene), late, 0).good


def test_it_is_blocked_where_it_begins_with_an_overlap():
    situation = behind_a_post()
    hand, _ = hands_along(ARM, [ARM.joints])
    blocked = replace(
        situation, bodies=(situation.bodies[0], flying("obstacle", records.Sphere(0.1), hand[0]))
    )
    plan = solve(blocked, "search")
    assert plan.status == "start_blocked" and complaints(blocked, plan) == []


def test_it_is_written_and_read():
    situation = behind_a_post(replace(ARM, max_hand_speed=2.0))
    written = records.situation_to_json(situation)
    assert written["arm"]["kind"] == "crane" and records.situation_from_json(written) == situation


def test_it_is_compared():
    sheet = ask(["search"], behind_a_post())
    assert sheet["outcome"][0] == "caught" and sheet["path"][0] > 0.0


def test_it_is_drawn(tmp_path):
    situation = behind_a_post()
    plan = solve(situation, "search")
    plan_figure(situation, plan).savefig(tmp_path / "plan.png")
    animate(situation, plan, tmp_path / "film.gif", frames=3)
    assert (tmp_path / "film.gif").stat().st_size > 1000


def test_a_limb_has_all_functions():
    with pytest.raises(TypeError, match=r"CraneLimb: missing or unknown .*hand_of, .*wing"):
        register_limb(CraneLimb, dof=None, wing=None)
