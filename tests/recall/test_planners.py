"""Planners that recall keep the promise of "caught", and say what they lack."""

import pytest

from gcm_learn import get_planner, recall as recalling, seeding, solve
from gcm_learn.errors import RecallError
from gcm_learn.families.random_planar import random_planar
from gcm_learn.families.random_solid import random_solid
from gcm_learn.planners import GAIN
from gcm_learn.planners.goal_directed import layered
from tests.judging import judge
from tests.recall.conftest import limited
from tests.transforms import turned

PLANNERS = {
    "recall": lambda memory: recalling.RecallPlanner(memory),
    "recall-1": lambda memory: recalling.RecallPlanner(memory, 1, "recall-1", novelty=0.0),
    "hybrid": lambda memory: recalling.HybridPlanner(recalling.RecallPlanner(memory)),
    "recall-random": lambda memory: recalling.RecallPlanner(
        memory.refiled(recalling.RandomIndex())
    ),
    "both": lambda memory: recalling.RecallPlanner(
        memory, how=recalling.Adaptation("cartesian", "both")
    ),
    "splines-random": lambda memory: recalling.SplinesPlanner(),
}


@pytest.mark.parametrize("name", PLANNERS)
@pytest.mark.parametrize(
    ("family", "count"), [(random_planar, 100), (random_solid, 25), (limited, 25)]
)
def test_every_catch_keeps_the_promise(memory, name, family, count):
    planner, caught = PLANNERS[name](memory), 0
    for k in range(count):
        situation = family(seeding.rng(73, k))
        plan = planner.plan(situation)
        assert plan.status in ("caught", "unreachable", "start_blocked")
        if plan.caught:
            caught += 1
            assert judge(situation, plan) == []
    assert caught > count / 5


def test_more_candidates_catch_no_less(memory):
    counts = []
    for candidates in (1, 3, 10):
        planner = recalling.RecallPlanner(memory, candidates, novelty=0.0)
        situations = [random_planar(seeding.rng(74, k)) for k in range(60)]
        counts.append({k for k, s in enumerate(situations) if planner.plan(s).caught})
    assert counts[0] <= counts[1] <= counts[2] and len(counts[0]) < len(counts[2])


def test_the_hybrid_catches_what_either_catches(memory):
    recall, plan = recalling.RecallPlanner(memory, 2), layered()
    hybrid = recalling.HybridPlanner(recall, plan)
    for k in range(40):
        situation = random_planar(seeding.rng(75, k))
        either = recall.plan(situation).caught or plan.plan(situation).caught
        assert hybrid.plan(situation).caught == either
    assert hybrid.plan(situation).planner == "hybrid"


class Asked:
    """A planner that notes what it was given."""

    name, anytime = "asked", True

    def __init__(self):
        self.given, self.planner = [], layered()

    def plan(self, situation, **given):
        self.given.append(given)
        return self.planner.plan(situation, **given)


def test_with_a_deadline_the_hybrid_is_never_worse_than_what_it_recalls(memory):
    """At once the recalled catch; with time left an earlier one, which that one bounds."""
    recall, asked, sooner = recalling.RecallPlanner(memory, 5), Asked(), 0
    hybrid = recalling.HybridPlanner(recall, asked)
    for k in range(60):
        situation = random_planar(seeding.rng(76, k))
        first = recall.plan(situation)
        if not first.caught:
            continue
        asked.given.clear()
        at_once = hybrid.plan(situation, deadline=0.0)
        assert at_once.catch_time == first.catch_time and not asked.given
        better = hybrid.plan(situation, deadline=1e9)
        assert better.caught and better.catch_time <= first.catch_time
        assert better.planner == "hybrid" and judge(situation, better) == []
        if asked.given:
            (given,) = asked.given
            assert given["bound"] == pytest.approx(first.catch_time - GAIN * situation.horizon)
        sooner += better.catch_time < first.catch_time
    assert sooner > 5


def test_the_hybrid_keeps_a_bound_and_asks_who_knows_no_deadline_only_in_need(memory):
    recall, asked, late = recalling.RecallPlanner(memory, 5), Asked(), 0
    hybrid = recalling.HybridPlanner(recall, asked)
    for k in range(60):
        situation = random_planar(seeding.rng(76, k))
        first = recall.plan(situation)
        if not first.caught or first.catch_time == 0.0:
            continue
        bound = 0.8 * first.catch_time
        plan = hybrid.plan(situation, bound=bound)
        assert asked.given[-1] == {"bound": bound}
        assert not plan.caught or plan.catch_time <= bound
        late += plan.caught
        stubborn = recalling.HybridPlanner(recall, get_planner("straight"))
        assert stubborn.plan(situation, deadline=1e9).catch_time == first.catch_time
    assert late > 0


def test_what_was_met_before_is_recalled_from_itself(memory, catches):
    planner, own = recalling.RecallPlanner(memory), 0
    for k, (situation, _) in enumerate(catches[:80]):
        found = planner.recollect(turned(situation, 0.7))
        assert found.plan.caught
        own += found.memory == k and found.checked == 1
    assert own > 70


def test_an_unverified_first_choice_may_fail_and_says_so(memory):
    worked = attempts = 0
    for k in range(60):
        situation = random_planar(seeding.rng(76, k))
        rollout = recalling.unverified(memory, situation)
        verified = recalling.RecallPlanner(memory, 1, novelty=0.0).plan(situation)
        assert rollout.worked == verified.caught
        worked, attempts = worked + rollout.worked, attempts + (rollout.attempt is not None)
    assert 0 < worked < attempts


def test_an_empty_memory_knows_nothing(catches):
    plan = recalling.RecallPlanner(recalling.Memory(recalling.RawIndex.fit([catches[0][0]]))).plan(
        catches[0][0]
    )
    assert plan.status == "unreachable" and plan.message == "nothing is known"


def test_planners_by_name_use_the_memory_of_the_models(memory, catches, tmp_path, monkeypatch):
    from gcm_learn import artifacts
    from gcm_learn.recall import planners

    planners._memory.cache_clear()
    monkeypatch.setattr(artifacts, "folders", lambda kind: [tmp_path])
    with pytest.raises(RecallError, match="gcm-learn memory make DATASET --out"):
        get_planner("recall")
    memory.save(tmp_path / "recall")
    situation = catches[3][0]
    for name in ("recall", "recall-1", "recall-raw", "recall-random", "hybrid", "splines-random"):
        planner = get_planner(name)
        assert planner.name == name and solve(situation, planner).planner == name
        again = solve(situation, get_planner(name))
        assert again.catch_time == solve(situation, name).catch_time
    planners._memory.cache_clear()
