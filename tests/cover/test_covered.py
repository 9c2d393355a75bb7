"""Planner `covered`: answers from proven cells, and says what is not covered."""

from __future__ import annotations

import json
import pickle
from dataclasses import replace

import numpy as np
import pytest

from gcm_learn import artifacts, families
from gcm_learn.arms import CHAIN, PLANAR, SPATIAL, kind_of
from gcm_learn.cover import Cover, CoveredPlanner, broken_of, covered, parametric_family
from gcm_learn.errors import CoverError
from gcm_learn.motion import Failure, rules_of, verify
from gcm_learn.planners import get_planner, plan_to_json, solve, takes
from gcm_learn.referee import judge
from gcm_learn.scene import pack
from gcm_learn.situation import Margin, situation_to_json


def drawn(cover, seed=0):
    """Return parameters and a situation of a cover's family."""
    theta = np.random.default_rng(seed).uniform(cover.family.low, cover.family.high)
    return theta, cover.family.situation(theta, "drawn")


def test_situations_of_the_family_are_recognised(cover):
    for seed in range(20):
        theta, situation = drawn(cover, seed)
        assert np.allclose(cover.family.parameters_of(situation), theta, atol=1e-12)


def test_answers_are_verified_catches(cover):
    planner = CoveredPlanner((cover,))
    for seed in range(40):
        _, situation = drawn(cover, seed)
        plan = planner.plan(situation)
        if not plan.caught:
            assert plan.message.startswith("not covered: ")
            continue
        scene = pack(situation)
        body = [body.name for body in situation.bodies].index(plan.catch_body)
        verdict = verify(scene, rules_of(scene), plan.trajectory, body)
        assert verdict.good and plan.clearance == pytest.approx(verdict.clearance)
        assert plan_to_json(plan, situation)["clearance"] == plan.clearance
        assert (plan.name, plan.planner) == ("drawn", "covered")


def test_a_later_horizon_loses_no_catch(plane):
    _, situation = drawn(plane)
    for times in (10.0, 1000.0):
        plan = CoveredPlanner((plane,)).plan(replace(situation, horizon=times * situation.horizon))
        assert plan.caught


def test_plans_are_records_like_others(plane):
    _, situation = drawn(plane)
    plan = CoveredPlanner((plane,)).plan(situation)
    clearance = plan.clearance
    assert replace(plan, planner="other").clearance == clearance
    assert pickle.loads(pickle.dumps(plan)).clearance == clearance


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        (lambda s: replace(s, horizon=0.5 * s.horizon), "no family has this situation"),
        (lambda s: replace(s, bodies=s.bodies[:-1]), "no family has this situation"),
        (lambda s: replace(s, bodies=s.bodies[::-1]), "no family has this situation"),
        (
            lambda s: replace(s, arm=replace(s.arm, grasp=0.5 * s.arm.grasp)),
            "no family has this situation",
        ),
    ],
)
def test_other_situations_are_not_covered(cover, change, reason):
    plan = CoveredPlanner((cover,)).plan(change(cover.family.middle))
    assert plan.status == "unreachable" and plan.failure is Failure.NO_MEMORY
    assert plan.message == f"not covered: {reason}"


def test_clouds_meshes_and_margins_are_proven(measured):
    """The referee finds no fault; other margins and an earlier end are other situations."""
    planner, caught = CoveredPlanner((measured,)), 0
    for seed in range(20):
        _, situation = drawn(measured, seed)
        answer = json.loads(json.dumps(plan_to_json(planner.plan(situation))))
        assert judge(situation_to_json(situation), answer) == []
        caught += answer["status"] == "caught"
        wider = [replace(b, margin=b.margin and Margin(0.2, 0.0)) for b in situation.bodies]
        assert not planner.plan(replace(situation, bodies=tuple(wider))).caught
        assert not planner.plan(replace(situation, end_by=0.1)).caught
    assert caught >= 10
    assert measured.share > 0.5 and broken_of(measured, 100, 0) == (0, 100)


def test_a_body_off_its_law_is_not_covered(cover):
    """A millionth off what parameters can change is another situation."""
    _, situation = drawn(cover)
    last = situation.bodies[-1]
    place = last.motion.position
    aside = replace(last, motion=replace(last.motion, position=(place[0] + 1e-6, *place[1:])))
    other = replace(situation, bodies=(*situation.bodies[:-1], aside))
    assert cover.family.parameters_of(other) is None


def test_parameters_outside_of_the_box_are_named(cover):
    theta = cover.family.centre + np.array([0.0, 5.0])
    message = CoveredPlanner((cover,)).plan(cover.family.situation(theta)).message
    second = cover.family.parameters[1].name
    assert message.startswith(f"not covered: {second} = 5 is outside of -0.")


def test_a_parameter_that_the_cover_holds_fixed_is_named(cover):
    whole = parametric_family(cover.family.name)
    theta = whole.centre + 0.5 * (whole.high - whole.centre) * (0, 0, 0, 1, 0)
    message = CoveredPlanner((cover,)).plan(whole.situation(theta)).message
    assert message.startswith(f"not covered: {whole.parameters[3].name} = ")
    assert "and the cover holds for 0 " in message and message.endswith(" only")


def test_cells_that_were_not_examined_are_said(plane):
    empty = CoveredPlanner((Cover(plane.family),))
    plan = empty.plan(plane.family.middle)
    assert plan.message == "not covered: the cell was not examined"


def test_the_planner_takes_the_kinds_of_its_covers(plane, chain):
    both = CoveredPlanner((plane, chain))
    assert takes(both, PLANAR) and takes(both, CHAIN) and not takes(both, SPATIAL)
    assert not takes(CoveredPlanner((plane,)), CHAIN)
    for cover in (plane, chain):
        assert takes(both, kind_of(cover.family.middle))
        assert both.plan(cover.family.situation(cover.family.centre)).caught


def test_covers_are_found_among_the_models(plane, tmp_path, monkeypatch):
    monkeypatch.setenv(artifacts.VARIABLES["models"], str(tmp_path))
    covered.cache_clear()
    plane.save(tmp_path / "mine")
    assert solve(plane.family.middle, "covered").caught
    covered.cache_clear()
    monkeypatch.setenv(artifacts.VARIABLES["models"], str(tmp_path / "none"))
    monkeypatch.setattr(artifacts, "models", lambda file: {})
    with pytest.raises(CoverError, match="gcm-learn cover belt --out"):
        get_planner("covered")


def test_random_situations_are_not_covered(plane):
    planner = CoveredPlanner((plane,))
    for k in range(10):
        assert not planner.plan(families.draw("gate", 0, k)).caught


def test_fixed_parameters_are_in_the_middle():
    family = parametric_family("belt")
    few = family.free(2)
    assert family.parameters_of(few.situation(few.high))[2:] == pytest.approx(family.centre[2:])
    assert few.parameters_of(family.situation(family.high)) is None
