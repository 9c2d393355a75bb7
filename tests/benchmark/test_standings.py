"""Measures of standings, by hand: answers as if the referee had judged them."""

from __future__ import annotations

import json
import math
import sys

import numpy as np
import pytest

from gcm_learn import benchmark
from gcm_learn.benchmark.judging import Judged
from gcm_learn.evaluation import mcnemar, wilson
from tests.benchmark.test_benchmark import NEAR

STRATA = "L", "L", "W", "U"


@pytest.fixture
def suite(tmp_path):
    """Return a suite of four situations, the last one out of reach as it says."""
    lines = [
        {"suite": "four", "family": "", "stratum": stratum, "situation": NEAR | {"name": f"{k}"}}
        for k, stratum in enumerate(("warm-up", *STRATA))
    ]
    path = tmp_path / "four.jsonl"
    path.write_text("".join(json.dumps(line) + "\n" for line in lines), "utf-8")
    return benchmark.load_suite(str(path))


def caught(ms, time):
    return Judged("caught", ms, 10, time, targets=1)


def missed(ms, outcome="unreachable", nodes=30):
    return Judged(outcome, ms, nodes, None)


def stood(suite, monkeypatch, methods):
    """Return the standings of methods by name; each has a factor and four answers."""
    runs = [
        (
            {"method": name, "calibration": {"factor": factor}},
            {
                "sha256": suite.sha256,
                "answers": [
                    {"name": c.name, "is": a} for c, a in zip(suite.cases, answers, strict=True)
                ],
            },
        )
        for name, (factor, answers) in methods.items()
    ]
    module = sys.modules["gcm_learn.benchmark.standings"]
    monkeypatch.setattr(module, "judged", lambda case, answer: answer["is"])
    return {one.method: one for one in benchmark.standings(suite, runs)}


QUICK = [caught(0.4, 0.5), caught(6.0, 1.0), missed(900.0), missed(2.0, nodes=70)]
SLOW = [caught(50.0, 0.75), missed(1.0, "broken"), caught(50.0, 2.0), missed(70.0, "error")]


def test_a_slow_machine_makes_times_shorter_and_a_quick_one_longer(suite, monkeypatch):
    """A factor of 2 is that of a machine on which the reference's work takes half as long."""
    found = stood(
        suite, monkeypatch, {"one": (1.0, QUICK), "two": (2.0, QUICK), "half": (0.5, QUICK)}
    )
    for name, factor in (("one", 1.0), ("two", 2.0), ("half", 0.5)):
        assert found[name].times_ms == pytest.approx((0.4 * factor, 6.0 * factor))
        assert found[name].median_ms == pytest.approx(4.0 * factor)
    within = {name: found[name].within for name in found}
    assert within["one"] == pytest.approx((1 / 3, 2 / 3, 2 / 3, 2 / 3, 2 / 3))
    assert within["two"][1] == pytest.approx(1 / 3) and within["half"][1] == pytest.approx(2 / 3)


def test_shares_count_what_can_be_caught_and_the_rest_by_stratum(suite, monkeypatch):
    found = stood(suite, monkeypatch, {"quick": (1.0, QUICK), "slow": (1.0, SLOW)})
    quick, slow = found["quick"], found["slow"]
    assert quick.caught == slow.caught == wilson(2, 3)
    assert quick.strata == {"L": (2, 2), "W": (0, 1), "U": (1, 1)}
    assert slow.strata == {"L": (1, 2), "W": (1, 1), "U": (0, 1)}
    assert (slow.broken, slow.errors, quick.broken, quick.errors) == (1, 1, 0, 0)
    assert quick.targets == slow.targets == pytest.approx(2 / 3)
    assert (quick.nodes, quick.answers) == (30.0, 4)
    assert slow.ratio == pytest.approx((1.5 + 1.0) / 2) and quick.ratio == 1.0


def test_a_time_of_just_the_budget_is_within_it(suite, monkeypatch):
    answers = [caught(1.0, 1.0), caught(10.0, 1.0), caught(20.0, 1.0), missed(1.0)]
    found = stood(suite, monkeypatch, {"one": (1.0, answers)})["one"]
    assert found.within == pytest.approx((1 / 3, 2 / 3, 1.0, 1.0, 1.0))


def test_the_first_is_compared_with_all_others(suite, monkeypatch):
    """In the order of catches, then of names; chances are corrected for their number."""
    best = [caught(1.0, 1.0)] * 3 + [missed(1.0)]
    none = [missed(1.0)] * 4
    found = stood(suite, monkeypatch, {"b": (1.0, none), "z": (1.0, best), "a": (1.0, none)})
    assert list(found) == ["z", "a", "b"]
    assert math.isnan(found["z"].p)
    alone = mcnemar(*(_hits(row) for row in (best, none)))[2]
    assert found["a"].p == found["b"].p == pytest.approx(2 * alone)


def _hits(row):
    return np.array([one.outcome == "caught" for one in row[:3]])


def test_beside_a_catch_at_once_no_ratio_counts(suite, monkeypatch):
    once = [caught(1.0, 0.0), caught(1.0, 3.0), missed(1.0), missed(1.0)]
    late = [caught(1.0, 0.5), caught(1.0, 1.0), missed(1.0), missed(1.0)]
    found = stood(suite, monkeypatch, {"once": (1.0, once), "late": (1.0, late)})
    assert (found["once"].ratio, found["late"].ratio) == (2.0, 1.0)


def test_what_is_out_of_reach_is_not_among_the_catches(suite, monkeypatch):
    """Even if a method catches it, as its stratum says that it cannot."""
    answers = [caught(1.0, 1.0), missed(1.0), missed(1.0), caught(1.0, 1.0)]
    found = stood(suite, monkeypatch, {"one": (1.0, answers)})["one"]
    assert found.caught == wilson(1, 3) and found.targets == pytest.approx(1 / 3)
    assert found.strata["U"] == (0, 1) and len(found.times_ms) == 1
