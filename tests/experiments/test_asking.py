"""Answers that are kept as they come."""

from __future__ import annotations

import json

from experiments.common import outcomes
from experiments.common.asking import ask_in_turns, publish, rows_of
from experiments.common.freezing import frozen_seed


def test_cases_are_asked_once_and_another_method_begins_each_time(tmp_path):
    file, asked = tmp_path / "out" / "answers.jsonl", []

    def answers(number, case, methods):
        asked.append((number, case, "".join(methods)))
        return [{"situation": number, "method": name} for name in methods]

    cases = [(7, "x"), (3, "y"), (5, "z"), (9, "w")]
    ask_in_turns(file, cases[:2], "abc", answers)
    ask_in_turns(file, cases, "abc", answers)
    assert asked == [(7, "x", "abc"), (3, "y", "bca"), (5, "z", "cab"), (9, "w", "abc")]
    rows = rows_of([file])
    assert [row["situation"] for row in rows[::3]] == [7, 3, 5, 9] and len(rows) == 12
    assert rows[3] == {"situation": 3, "method": "b"}


def test_a_world_that_is_asked_anew_replaces_its_outcomes_alone(tmp_path, monkeypatch):
    monkeypatch.setattr("experiments.recompute.update", lambda folder: None)
    file, drawn = tmp_path / "answers.jsonl", []

    def asked(*rows):
        file.write_text(json.dumps([{"situation": 1, "seed": None, **row} for row in rows]) + "\n")
        publish(tmp_path, [file], lambda *given: drawn.append(given), ("world", "method"))
        found = outcomes.read(tmp_path / "outcomes.csv.gz")
        return list(zip(found["world"], found["method"], found["ms"], found["caught"], strict=True))

    space = {"world": "space", "method": "a", "ms": 1.25, "caught": True}
    panda = {"world": "panda", "method": "a", "ms": None, "caught": False}
    assert len(asked(space, space | {"method": "b"}, panda)) == 3
    again = asked(space | {"ms": 2.0})
    assert sorted(again, key=str)[1:] == [("space", "a", 2.0, True), ("space", "b", 1.25, True)]
    assert again[0][:2] == ("panda", "a") and not again[0][3] and len(drawn) == 2


def test_worlds_that_came_later_have_seeds_of_their_own(tmp_path):
    file = tmp_path / "frozen.json"
    file.write_text(json.dumps({"seed": 5, "later": {"panda": {"seed": 6}}}))
    assert frozen_seed(file, "space") == 5 and frozen_seed(file, "panda") == 6
