"""What the page of a comparison says first."""

from __future__ import annotations

import numpy as np

from gcm_learn.evaluation.table import Results
from gcm_learn.evaluation.verdict import verdict, who
from gcm_learn.planners import planner_names


def results(outcomes):
    """Rows of methods by name: outcomes and latency."""
    rows = []
    for name, (each, latency) in outcomes.items():
        for k, outcome in enumerate(each):
            rows.append(
                {
                    "suite": "made", "index": k, "family": "gate", "stratum": "W", "earliest": 0.5,
                    "entrant": name, "outcome": outcome, "latency_ms": latency, "end": 0.6,
                    "length": 1.0, "clearance": 0.1, "peak_hand": 1.0, "peak_shoulder": 1.0,
                    "peak_elbow": 1.0, "part": None, "charged_own": None,
                }
            )  # fmt: skip
    return Results.of(rows)


def test_the_best_and_the_quickest_of_the_good_are_named():
    c, d, t = "caught", "declined", "touched"
    text = verdict(results({"slow": ([c, c, c, d], 90.0), "quick": ([c, c, t, d], 3.0)}))
    assert "slow catches most: 75 %" in text and "quick does: 50 % after 3.0 ms" in text
    assert "quick touches an obstacle most often, in 25 %" in text
    text = verdict(results({"quick": ([c, d], 3.0), "slow": ([d, d], 90.0)}))
    assert "quick catches most: 50 %" in text and "at most" not in text and "touches" not in text
    nothing = results({"a": ([d], 1.0)})
    hopeless = Results({**nothing.columns, "stratum": np.array(["U"], object)})
    assert verdict(hopeless) == "None of these situations can be caught."


def test_who_catches_as_much_is_named_too():
    c, d = "caught", "declined"
    text = verdict(results({"a": ([c, d], 3.0), "b": ([d, d], 3.0), "c": ([d, c], 9.0)}))
    assert "a catches most: 50 %" in text and "As much catch c." in text


def test_all_planners_are_introduced():
    there = {name for name, _ in who([*planner_names(), "recall", "hybrid", "clone", "clone@20"])}
    assert {"gcm", "layered", "recall", "hybrid", "clone", "clone@20"} <= there
    assert set(planner_names()) - there <= {"splines-random"}
    words = dict(who(["clone@20"]))
    assert "tried out 20 times" in words["clone@20"]
