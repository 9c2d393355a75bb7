"""Controls differ from recall in the one thing that they are to tell apart."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pytest

from gcm_learn import families, get_planner, solve
from gcm_learn.planners import Plan
from gcm_learn.recall import HybridPlanner, Memory, RandomIndex, RecallPlanner
from gcm_learn.recall.planners import Recollection, shipped_memory

CHECKS = 20  # of recall, and of all that it is compared with but `recall-1`


@pytest.fixture(scope="module")
def drawn():
    """Return situations of two families."""
    return [families.draw(("gate", "crossing-swarm")[k % 2], 21, k) for k in range(36)]


def test_the_first_choice_stands_alone(drawn):
    planner, caught = get_planner("recall-1"), []
    memory = planner.memory
    for situation in drawn:
        found = planner.recollect(situation)
        best = memory.recall(memory.index.embed_query(situation), 1)
        assert found.checked <= 1
        assert found.memory == (best[0] if found.plan.caught else None)
        caught.append(found.plan.caught)
    assert 6 < sum(caught) < 36


def test_recall_and_its_controls_may_check_equally_many(drawn):
    for name in ("recall", "recall-raw", "recall-random"):
        planner = get_planner(name)
        found = [planner.recollect(situation) for situation in drawn[:18]]
        checked = np.array([f.checked for f in found])
        assert checked.max() == CHECKS
        assert any(f.plan.caught and f.checked > 1 for f in found)
    assert get_planner("splines-random").candidates == CHECKS


@pytest.mark.parametrize(
    ("name", "learns"), [("recall", True), ("recall-raw", False), ("recall-random", False)]
)
def test_only_the_learned_index_learns_from_failures(drawn, name, learns):
    """Scores of controls are no odds, so a control keeps the order of its index."""
    planner = get_planner(name).planner  # without its stages
    in_order = replace(planner, penalty=0.0)
    found = [
        [(one.memory, one.checked) for one in map(who.recollect, drawn)]
        for who in (planner, in_order)
    ]
    assert (found[0] != found[1]) == learns


@pytest.mark.parametrize("name", ["recall-raw", "recall-random", "recall-pca"])
def test_controls_file_the_same_memories_by_their_own_index(
    memory, catches, name, tmp_path, monkeypatch
):
    memory.forget(np.arange(30, len(memory)))
    memory.save(tmp_path / "recall")
    monkeypatch.setenv("GCM_LEARN_MODELS", str(tmp_path))
    control = shipped_memory(name)
    assert f"recall-{control.index.name}" == name
    np.testing.assert_array_equal(control.knots, memory.knots)
    np.testing.assert_array_equal(control.goals, memory.goals)
    assert control.situations() == memory.situations()


def test_memories_at_random_have_nothing_to_do_with_the_situation():
    """What was remembered from a situation comes anywhere among what is recalled for it."""
    memory = get_planner("recall-random").memory
    rows = range(0, len(memory), len(memory) // 80)
    lists = [
        memory.recall(memory.index.embed_query(memory.situation(k)), len(memory)) for k in rows
    ]
    places = [np.flatnonzero(found == k)[0] for k, found in zip(rows, lists, strict=True)]
    assert 0.35 < np.mean(places) / len(memory) < 0.65
    assert len({found[0] for found in lists}) > len(rows) / 2


@dataclass
class Always:
    """A planner that has one answer and counts how often it is asked."""

    status: str
    planning_ms: float
    name: str = "always"
    asked: int = 0

    def plan(self, situation):
        """Answer."""
        self.asked += 1
        catch_time = 0.5 if self.status == "caught" else None
        return Plan(situation.name, self.name, self.status, "", self.planning_ms, catch_time)

    def recollect(self, situation, deadline=None):
        """Answer as from a memory."""
        return Recollection(self.plan(situation), None, 0)


@pytest.mark.parametrize(
    ("first", "asked"), [("caught", 0), ("start_blocked", 0), ("unreachable", 1)]
)
def test_the_hybrid_plans_when_recall_fails_and_both_take_their_time(drawn, first, asked):
    recall, fallback = Always(first, 300.0), Always("caught", 20.0)
    plan = HybridPlanner(recall, fallback).plan(drawn[0])
    assert (recall.asked, fallback.asked) == (1, asked)
    assert plan.status == ("caught" if asked else first) and plan.planner == "hybrid"
    assert plan.planning_ms == 300.0 + 20.0 * asked


def test_a_hybrid_that_knows_nothing_is_layered():
    nothing, waits = RecallPlanner(Memory(RandomIndex())), 0
    hybrids = HybridPlanner(nothing), replace(get_planner("hybrid").planner, recall=nothing)
    for k in range(8):
        situation = families.draw(("gate", "late-target")[k % 2], 21, k)
        wanted = solve(situation, "layered")
        for hybrid in hybrids:
            plan = hybrid.plan(situation)
            assert (plan.status, plan.catch_time) == (wanted.status, wanted.catch_time)
            if plan.caught:
                np.testing.assert_array_equal(plan.trajectory.hand, wanted.trajectory.hand)
        waits += wanted.caught and not solve(situation, "marching").caught
    assert waits > 2
