"""The comparison: rows, charged thinking, suites, the report."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from gcm_learn import Arm, Body, Disc, PlanarQuadratic, Situation, families
from gcm_learn.cli import main
from gcm_learn.errors import UnknownNameError
from gcm_learn.evaluation import suites
from gcm_learn.evaluation.contest import compare
from gcm_learn.evaluation.kinds import charged, resting
from gcm_learn.evaluation.measures import charged_curve, declines, measured, pairs
from gcm_learn.evaluation.methods import get_method
from gcm_learn.evaluation.movements import collided_part, collision_point
from gcm_learn.evaluation.suites import Entry
from gcm_learn.evaluation.table import Results
from gcm_learn.evaluation.under_noise import compare_under_noise
from gcm_learn.motion import clearance
from gcm_learn.motion.movement import Movement
from gcm_learn.motion.rules import start_clearance
from gcm_learn.planners import solve
from gcm_learn.scene.packing import pack
from gcm_learn.situation.canonical import canonical


def moving(name, role, position, velocity, radius=0.1):
    """A disc on its way."""
    motion = PlanarQuadratic(position, velocity, (0.0, 0.0))
    return Body(role, name, Disc(radius), motion)


def test_parts_of_a_comparison_join(results):
    first = results["entrant"] == results.methods[0]
    whole = Results.joined(results.where(first), results.where(~first))
    assert len(whole) == len(results) and whole.methods == results.methods
    for name, column in whole.columns.items():
        assert column.dtype == results[name].dtype
    assert np.array_equal(whole["outcome"], results["outcome"])


def scene(*bodies):
    """A situation with the hand at (1.5, 0)."""
    return Situation("scene", 1.0, Arm((1.5, 0.0), 3.0), bodies)


def made_entries(count):
    """Entries without an oracle: by the planners straight and layered."""
    entries, k = [], 0
    while len(entries) < count:
        situation, _ = canonical(families.draw("crossing-swarm", 12, k))
        k += 1
        if start_clearance(pack(situation)) <= 0.0:
            continue
        straight, layered = solve(situation, "straight"), solve(situation, "layered")
        stratum = "L" if straight.caught else "W" if layered.caught else "U"
        early = layered.catch_time if layered.caught else float("inf")
        entries.append(Entry("made", len(entries), situation, "crossing-swarm", stratum, early))
    return entries


@pytest.fixture(scope="module")
def entries():
    """Return a few situations."""
    return made_entries(12)


@pytest.fixture(scope="module")
def results(entries):
    """Return what three planners make of them."""
    return compare(["straight", "marching", "layered"], entries, charge=2, workers=1)


def test_rows_say_what_the_planners_say(results, entries):
    assert len(results) == 3 * len(entries)
    for name in ("straight", "layered"):
        mine = results.of_method(name)
        plans = [solve(e.situation, name) for e in entries]
        assert [o == "caught" for o in mine["outcome"]] == [p.caught for p in plans]
        for k, plan in enumerate(plans):
            if plan.caught:
                assert mine["end"][k] == plan.catch_time
                assert mine["length"][k] == pytest.approx(plan.trajectory.length)
                limit = entries[k].situation.arm.max_hand_speed
                assert mine["peak_hand"][k] <= limit * (1 + 1e-6)
    assert np.all(results["latency_ms"] > 0.0)
    assert not np.any(results["outcome"] == "touched")


def test_a_cluster_gives_the_same_rows_but_for_the_time_that_it_took(results, entries, scheduler):
    names = ["straight", "marching", "layered"]
    there = compare(names, entries, charge=2, cluster=scheduler)
    assert list(there.columns) == list(results.columns)
    for name, column in results.columns.items():
        if name not in ("latency_ms", "charged_own"):
            np.testing.assert_array_equal(there[name], column, name)


def test_inexact_perception_is_the_same_on_a_cluster(entries, scheduler):
    here = compare_under_noise(["straight"], entries[:4], [0.05], workers=1)
    there = compare_under_noise(["straight"], entries[:4], [0.05], cluster=scheduler)
    assert {n: c.tolist() for n, c in here.columns.items()} == {
        n: c.tolist() for n, c in there.columns.items()
    }


def test_clearances_are_those_of_the_verification(entries):
    for entry in entries:
        plan = solve(entry.situation, "layered")
        if plan.caught:
            assert clearance(entry.situation, plan.trajectory)[0] == pytest.approx(
                plan.clearance, abs=2e-4
            )


def test_the_collision_point_is_where_the_limb_is_met():
    far = moving("ball", "target", (-1.0, 1.0), (0.0, 0.0))
    way = Movement.of_hand(Arm((1.5, 0.0), 1.0), np.array([0.0, 0.5]), np.full((2, 2), (1.5, 0.0)))
    elbow = np.array([0.75, -np.sqrt(1.0 - 0.75**2)])  # of two equal limbs, right elbow
    for centre, part in ((1.1, "forearm"), (0.4, "upper arm")):
        joint = elbow if part == "forearm" else np.zeros(2)
        along = (np.array([1.5, 0.0]) if part == "forearm" else elbow) - joint
        foot = joint + along * (centre - joint[0]) / along[0]
        off = 0.08 * np.array([-along[1], along[0]])
        rock = moving("rock", "obstacle", tuple(foot + off), (0.0, 0.0), radius=0.05)
        situation = scene(far, rock)
        assert collided_part(situation, way) == part
        np.testing.assert_allclose(collision_point(situation, way), foot, atol=0.006)


def test_measures_follow_from_the_rows(results):
    reachable = results.where(results["stratum"] != "U")
    layered = measured(reachable, "layered")
    assert layered.caught.value == 1.0 and layered.collisions.value == 0.0
    assert layered.ratio == pytest.approx(1.0)
    straight = measured(results.where(results["stratum"] == "W"), "straight")
    assert straight.caught.value == 0.0
    (pair,) = (p for p in pairs(results, "layered") if p.first == "straight")
    lost = int((reachable.of_method("straight")["stratum"] == "W").sum())
    assert (pair.only_first, pair.only_second) == (0, lost) and pair.difference.value < 0.0
    hopeless = Results({**results.columns, "stratum": np.full(len(results), "U", object)})
    assert declines(hopeless, "layered").value == 1.0


def test_charging_nothing_changes_nothing(results):
    mine = results.of_method("layered")
    there = [k for k, c in enumerate(mine["charged_0"]) if c is not None]
    assert 3 < len(there) <= 6
    assert [mine["charged_0"][k] for k in there] == [mine["outcome"][k] for k in there]
    assert all(mine["charged_own"][k] is not None for k in there)
    assert len(charged_curve(results, "layered")) == 5


def test_the_world_runs_while_one_thinks():
    """A ball that passes within reach early on is lost to who thinks for long."""
    passing = scene(moving("ball", "target", (1.0, 0.4), (1.5, 0.0)))
    layered = get_method("layered")
    assert charged(layered, passing, 0.0) == "caught"
    assert charged(layered, passing, 0.85) == "declined"
    assert charged(layered, passing, 1.5) in ("late", "declined")


def test_a_resting_hand_may_be_touched_or_come_upon():
    far = moving("ball", "target", (-1.0, 1.0), (0.0, 0.0))
    rock = moving("rock", "obstacle", (1.5, 1.0), (0.0, -2.0))
    assert resting(scene(far, rock), 0.3) == "" and resting(scene(far, rock), 0.6) == "touched"
    coming = moving("ball", "target", (1.5, 1.0), (0.0, -2.0))
    assert resting(scene(coming), 0.6) == "caught"
    assert resting(scene(coming, replace(rock, name="other")), 0.6) in ("caught", "touched")


def test_tables_are_kept(results, tmp_path):
    pytest.importorskip("pyarrow")
    again = Results.load(results.save(tmp_path / "results.parquet"))
    assert list(again.columns) == list(results.columns)
    for name, column in results.columns.items():
        if column.dtype == object:
            assert again[name].tolist() == column.tolist()
        else:
            np.testing.assert_array_equal(again[name], column)


def test_unknown_methods_are_refused():
    with pytest.raises(UnknownNameError, match="policy: 'nobody' is not one of gcm"):
        get_method("nobody")


def test_one_command_writes_a_page_that_needs_nothing_else(entries, tmp_path, capsys):
    pytest.importorskip("pyarrow")
    lines = "".join(suites._line(replace(e, suite="gate")) + "\n" for e in entries)
    (tmp_path / "gate.jsonl").write_text(lines)
    command = ["evaluate", "--policies", "straight,layered", "--suite", "gate", "--count", "10",
               "--charge", "1", "--workers", "1", "--suites", str(tmp_path),
               "--out", str(tmp_path / "out")]  # fmt: skip
    assert main(command) == 0
    assert "layered" in capsys.readouterr().out
    page = (tmp_path / "out" / "report.html").read_text()
    assert page.count("data:image/png;base64,") >= 3 and 'src="rates' not in page
    assert "straight" in page and "McNemar" in page
    assert main([*command[:2], "nobody", *command[3:]]) == 2


@pytest.mark.parametrize(
    ("option", "value"), [("--policies", "nobody"), ("--suite", "nowhere"), ("--count", "0")]
)
def test_what_cannot_be_compared_leaves_nothing_behind(option, value, tmp_path, capsys):
    given = {"--policies": "straight", "--suite": "gate", "--count": "10"} | {option: value}
    out = tmp_path / "out"
    assert main(["evaluate", *sum(given.items(), ()), "--out", str(out)]) == 2
    assert value in capsys.readouterr().err and not out.exists()


@pytest.mark.slow
def test_what_is_shipped_can_be_compared(tmp_path):
    from gcm_learn.plots import build_comparison, shipped_methods

    assert {"layered", "clone", "clone@20"} <= set(shipped_methods())
    page = build_comparison(tmp_path, 2, lambda step: None, workers=1)
    text = page.read_text()
    assert all(name in text for name in shipped_methods())
