"""Answers that are kept as they come."""

from __future__ import annotations

from experiments.common.asking import ask_in_turns, rows_of


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
