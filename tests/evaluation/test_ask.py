"""Asking: outcomes, conditions, and what is kept."""

from __future__ import annotations

import json

import numpy as np
import pytest

from gcm_learn import Movement, Plan, families, solve
from gcm_learn.errors import ArmKindError, SuiteError, UnknownNameError
from gcm_learn.evaluation import Condition, Entrant, ask, cases, judged_again, shares
from gcm_learn.evaluation.asking import JOURNAL
from gcm_learn.processes import crew_of
from gcm_learn.situation import situation_to_json
from tests.evaluation.worlds import boasting, failing, moving, scene, slow_straight


def outcomes(sheet, name, **words):
    return sheet.where(entrant=name, **words)["outcome"].tolist()


def test_catches_promises_errors_and_refusals_are_told_apart(suite):
    sheet = ask([slow_straight, boasting, failing, "straight"], str(suite))
    assert outcomes(sheet, "straight") == ["caught", "caught", "declined"]
    assert outcomes(sheet, "slow_straight") == ["caught", "caught", "declined"]
    assert outcomes(sheet, "boasting") == ["broken"] * 3
    assert outcomes(sheet, "failing") == ["error"] * 3
    slow = sheet.where(entrant="slow_straight")
    assert slow["ms"].min() >= 30.0 and slow["suite"].tolist() == ["three.jsonl"] * 3
    assert slow["catch_time"][:2].tolist() == [1.0, 2.0] and slow["targets"].tolist() == [1, 1, 0]
    assert slow["path"][0] == pytest.approx(np.hypot(0.3, 0.6))
    assert "no idea" in sheet.where(entrant="failing")["reason"][0]


def test_rows_are_plans_of_any_situation_that_a_user_has(tmp_path):
    drawn = [families.draw(name, 12, k) for name in ("crossing-swarm", "gate") for k in range(2)]
    path = tmp_path / "mine.jsonl"
    path.write_text("".join(json.dumps(situation_to_json(one)) + "\n" for one in drawn), "utf-8")
    one = tmp_path / "one.json"
    one.write_text(json.dumps(situation_to_json(drawn[0]), indent=1), "utf-8")
    sheet = ask(["search"], drawn)
    assert [o == "caught" for o in sheet["outcome"]] == [solve(s).caught for s in drawn]
    same = ask(["search"], str(path))
    assert same["key"].tolist() == sheet["key"].tolist()
    assert same["catch_time"].tolist() == pytest.approx(sheet["catch_time"].tolist(), nan_ok=True)
    assert ask(["search"], one)["key"].tolist() == sheet["key"].tolist()[:1]


def test_the_referee_judges_again_what_a_sheet_holds(suite):
    sheet = ask(["straight"], str(suite), [Condition(), Condition(0.02)])
    assert judged_again(sheet)["outcome"].tolist() == sheet["outcome"].tolist()
    for forge in ("hand", "situation", "none"):
        texts = sheet["solution"].copy()
        for k in np.flatnonzero(sheet.caught):
            solution = json.loads(texts[k])
            if forge == "hand":
                solution["trajectory"]["hand"][-1][0] += 0.3
            texts[k] = "" if forge == "none" else json.dumps(solution | {"name": f"{forge} other"})
        forged = type(sheet)({**sheet.columns, "solution": texts})
        assert not judged_again(forged).caught.any()


def test_each_situation_is_asked_once_after_warming_up(suite):
    asked = []

    def counting(situation):
        asked.append(situation.name)
        return Plan(situation.name, "counting", "unreachable", "", 0.0)

    ask([counting], str(suite))
    assert asked == ["before", "near", "later", "near", "later", "far"]


def test_another_entrant_begins_each_time(suite):
    asked = []

    def planner(name):
        def plan(situation):
            asked.append(name)
            return Plan(situation.name, name, "unreachable", "", 0.0)

        return Entrant(name, plan)

    ask([planner("a"), planner("b")], str(suite))
    assert asked == [*"aaaabbbb"[:4], *"bbbb"[:4], *"ba", *"ab"][:12]


class Stopping:
    """Declines; stops the run at one of its questions."""

    name = "stopping"

    def __init__(self):
        self.asked, self.stop = [], "far"

    def plan(self, situation):
        """Answer."""
        if situation.name == self.stop:
            raise KeyboardInterrupt
        self.asked.append(situation.name)
        return Plan(situation.name, self.name, "unreachable", "", 0.0)


@pytest.mark.parametrize("damage", ["", '{"half of a li', "5\n", '{"passes": ["a"]}\n'])
def test_a_run_goes_on_where_it_stopped(suite, tmp_path, damage):
    entrant, keep = Stopping(), tmp_path / "keep"
    with pytest.raises(KeyboardInterrupt):
        ask([entrant], str(suite), keep=keep)
    with (keep / JOURNAL).open("a", encoding="utf-8") as stream:
        stream.write(damage)
    entrant.asked, entrant.stop = [], ""
    sheet = ask([entrant], str(suite), keep=keep)
    assert sheet["name"].tolist() == ["near", "later", "far"]
    assert [name for name in entrant.asked if name not in ("before",)][-1] == "far"
    assert entrant.asked.count("near") <= 1, "asked again only to warm up"
    entrant.asked = []
    again = ask([entrant], str(suite), keep=keep)
    assert not entrant.asked and again["ms"].tolist() == sheet["ms"].tolist()
    more = ask([entrant], str(suite), [Condition(), Condition(0.02)], keep=keep)
    assert len(more) == 6 and entrant.asked.count("far") == 1


def test_a_changed_file_is_asked_anew(suite, tmp_path):
    mine, keep = tmp_path / "mine.py", tmp_path / "keep"
    code = (
        "from gcm_learn import Plan\ndef plan(situation):\n"
        "    return Plan(situation.name, 'mine', 'STATUS', 'why', 0.0)\n"
    )
    for status, outcome in (("unreachable", "declined"), ("nonsense", "error")):
        mine.write_text(code.replace("STATUS", status), "utf-8")
        sheet = ask([f"{mine}:plan"], str(suite), keep=keep)
        assert set(sheet["outcome"]) == {outcome}


def test_a_crew_gives_the_same_rows_but_for_the_time_that_it_took(suite, scheduler):
    conditions = [Condition(), Condition(0.05), Condition(noise=0.02)]
    here = ask(["straight", "search"], str(suite), conditions)
    with crew_of(cluster=scheduler) as crew:
        there = ask(["straight", "search"], str(suite), conditions, crew=crew)
        with pytest.raises(SuiteError, match="cannot be sent to worker processes"):
            ask([lambda situation: None], str(suite), crew=crew)
    for name, column in here.columns.items():
        if name not in ("ms", "factor"):
            texts = [str(c) for c in (column.tolist(), there[name].tolist())]
            if name == "solution":
                texts = [t.replace("planning_ms", "") for t in texts]
                continue
            assert texts[0] == texts[1], name


def test_seeds_of_one_name_are_rows_of_their_own(suite):
    entrants = [Entrant("mine", slow_straight, 1), Entrant("mine", failing, 2)]
    sheet = ask(entrants, str(suite))
    assert sheet.each("seed") == [1, 2] and sheet.each("entrant") == ["mine"]
    assert shares(sheet)["caught [%]"][0].value == 0.5


class Nobody:
    def act(self, observations):
        return np.zeros((len(observations), 2))


def test_targets_are_counted_where_several_are_wanted():
    case = [families.draw("sequence-chain", 10, k) for k in range(2)]
    sheet = ask([first_leg, "search"], case)
    legs, whole = (sheet.where(entrant=name) for name in ("first_leg", "search"))
    assert not (sheet["outcome"] == "broken").any() and set(legs["targets"]) == {1}
    solutions = [json.loads(text) for text in whole["solution"]]
    assert whole["targets"].tolist() == [len(s["catches"]) for s in solutions]
    assert whole["wanted"].tolist() == [len(s.targets) for s in case]


def first_leg(situation):
    """Catch as `search` does, and stop after the first of several."""
    plan = solve(situation, "search")
    name, end = list(plan.catches[0].values())
    moves, until = plan.trajectory, plan.trajectory.time <= end
    rates = None if moves.rates is None else moves.rates[until]
    moves = Movement(situation.arm, moves.time[until], moves.joints[until], rates)
    return Plan(situation.name, "first", "caught", "", 0.0, end, name, trajectory=moves)


first_leg.takes = lambda kind: True


def drawn():
    return families.draw("falling-space", 1, 0)


def gate():
    return cases("gate", count=1)


REFUSED = [
    (["nobody"], "gate", [], UnknownNameError, "'nobody' is not one of"),
    (["search"], "moon", [], UnknownNameError, "'moon' is not one of"),
    (["search"], "si-rrt", [], SuiteError, "gcm-learn convert si-rrt"),
    (["search"], [], [], SuiteError, "nothing is asked"),
    ([failing], drawn, [], ArmKindError, "failing"),
    (["clone"], drawn, [], ArmKindError, "policy 'clone'"),
    (["clone"], gate, [Condition(noise=0.1)], SuiteError, "'clone' is no planner"),
    (["search"], gate, [Condition(-1.0)], SuiteError, "thinking: must be from 0 s on"),
    (["search"], gate, [Condition(noise=2.0)], SuiteError, "noise: must be from 0 to 1"),
]


@pytest.mark.parametrize(("entrants", "on", "conditions", "error", "line"), REFUSED)
def test_what_cannot_be_asked_is_refused_in_one_line(entrants, on, conditions, error, line):
    with pytest.raises(error, match=line) as caught:
        ask(entrants, on() if callable(on) else on, conditions or [Condition()])
    assert "\n" not in str(caught.value)


def test_memories_and_actors_are_entrants():
    near = scene(moving("target", (1.2, 0.6), (0.0, 0.0)))
    memory = "recall@models/recall"
    sheet = ask(["recall", memory, "clone", "models/clone", "clone@3"], near)
    by_name = dict(zip(sheet["entrant"], sheet["outcome"], strict=True))
    assert by_name["recall"] == by_name[memory] == by_name["clone@3"] == "caught"
    assert by_name["clone"] == by_name["models/clone"] == "caught", "judged by the referee"
    assert "with the memory in" in sheet.entrants[memory]
    assert "3 times" in sheet.entrants["clone@3"] and sheet.entrants["recall"]
