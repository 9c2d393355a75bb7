"""Parts of experiments that decide their results."""

from __future__ import annotations

from dataclasses import replace
from time import process_time
from types import SimpleNamespace

import pytest

from experiments.common import judging
from experiments.common.masses import OFF, followed, heavier
from experiments.common.memories import random_by_family
from gcm_learn import families, solve
from gcm_learn.execution import body_for, execute, with_motor_limits
from gcm_learn.families import paper_scene
from gcm_learn.recall import Memory, RawIndex, waypoints_of
from gcm_learn.referee import Complaint

FAMILIES = ("gate", "crossing-swarm")


@pytest.fixture(scope="module")
def caught():
    """Return situations of two families with their catches."""
    drawn = [(family, families.draw(family, 21, k)) for k in range(12) for family in FAMILIES]
    plans = [(family, situation, solve(situation, "layered")) for family, situation in drawn]
    return [one for one in plans if one[2].caught]


@pytest.mark.parametrize("words", [[], ["clearance: is off"]])
def test_a_catch_is_broken_if_the_referee_complains_and_is_judged_once(caught, monkeypatch, words):
    asked = []

    def judge(situation, solution):
        asked.append(solution["name"])
        return [Complaint(*word.split(": ")) for word in words]

    monkeypatch.setattr(judging, "judge", judge)
    found, (_, situation, plan) = judging.Referee(), caught[0]
    for _ in range(2):
        assert found.broken(situation, plan) is bool(words)
    assert judging.complaints(situation, plan) == words and len(asked) == 2


def burn(seconds):
    """Keep the processor busy."""
    until = process_time() + seconds
    while process_time() < until:
        pass


@pytest.mark.parametrize("catches", [True, False])
def test_an_answer_takes_its_planner_s_time_and_not_the_referee_s(monkeypatch, catches):
    situation = paper_scene("fig8-space")
    given = solve(situation, "layered")
    if not catches:
        given = replace(given, status="unreachable", trajectory=None, catch_time=None)

    def plan(asked):
        assert asked is situation
        burn(0.05)
        return given

    def judge(*_):
        burn(0.3)
        return [Complaint("trajectory", "they touch")]

    monkeypatch.setattr(judging, "judge", judge)
    row = judging.first_answer(SimpleNamespace(plan=plan), situation)
    assert 50.0 <= row["ms"] < 300.0
    assert row["catch"] == given.catch_time
    assert row.get("complaints") == (["trajectory: they touch"] if catches else None)


def test_random_memories_of_a_family_are_of_that_family(caught):
    names, situations, plans = zip(*caught, strict=True)
    memory = Memory(RawIndex.fit(list(situations)))
    traces = [waypoints_of(s, plan) for s, plan in zip(situations, plans, strict=True)]
    memory.add(list(situations), traces, list(names))
    kept, parts = memory.situations(), random_by_family(memory)
    assert set(parts) == {"", *FAMILIES}
    assert parts[""].situations() == kept
    for family in FAMILIES:
        mine = [s for name, s in zip(names, kept, strict=True) if name == family]
        assert parts[family].situations() == mine
    assert all(part.index.name == "random" for part in parts.values())


def test_the_controller_of_a_heavy_arm_does_not_know_how_heavy_it_is():
    """It ends farther from its plan than one that does; an arm of known masses ends near it."""
    scene = paper_scene("fig8-space")
    body = body_for(scene.arm)
    situation = with_motor_limits(scene, body)
    plan = solve(situation, "layered")
    heavy, known = followed(plan, situation, "heavy"), followed(plan, situation, "known")
    told = execute(plan, situation, heavier(body, OFF))
    at_the_end = 2
    assert heavy.error[at_the_end] > 5.0 * told.error[at_the_end]
    assert known.error == execute(plan, situation).error
