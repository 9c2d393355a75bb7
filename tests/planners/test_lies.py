"""Lies of planners from outside: none comes through as a catch, and none ends a run."""

from __future__ import annotations

import dataclasses
import json
import sys
import time
from types import SimpleNamespace

import numpy as np
import pytest

from gcm_learn import solve
from gcm_learn.cli import main
from gcm_learn.evaluation import Condition, ask
from gcm_learn.families import PAPER_SCENES, draw, thrown_scene
from gcm_learn.motion import Failure, Movement
from gcm_learn.planners import Plan, get_planner, plan_to_json
from gcm_learn.planners.outside import broken_promise
from gcm_learn.situation import situation_from_json, situation_to_json
from tests.chains import drawn

CASES = {
    "planar": lambda: (PAPER_SCENES["fig4"](), "gcm"),
    "spatial": lambda: (thrown_scene(), "search"),
    "chain": lambda: (situation_from_json(drawn("panda", 0)), "search"),
}


@pytest.fixture(scope="module", params=CASES)
def case(request):
    """Return a situation with an arm of each kind, and a plan that holds."""
    situation, planner = CASES[request.param]()
    plan = solve(situation, planner)
    assert plan.caught
    return situation, plan


def forged(movement, **changes):
    """Return a movement whose checks were passed by."""
    made = object.__new__(Movement)
    values = {f.name: getattr(movement, f.name) for f in dataclasses.fields(Movement)}
    for name, value in (values | changes).items():
        object.__setattr__(made, name, value)
    return made


def moved(plan, **changes):
    """Return a plan whose movement has other numbers, and ends at its catch time."""
    movement = forged(plan.trajectory, **changes)
    end = movement.time
    last = float(end[-1]) if isinstance(end, np.ndarray) and end.dtype == float and end.size else 0
    return dataclasses.replace(plan, trajectory=movement, catch_time=last)


def every(plan, change):
    """Change the joints, and the hands of a planar arm."""
    movement = plan.trajectory
    path = None if movement.path is None else change(movement.path)
    return moved(plan, joints=change(movement.joints), path=path, rates=None)


def with_times(plan, change):
    times = plan.trajectory.time.copy()
    return moved(plan, time=change(times))


def spoiled(values, place, number):
    out = values.copy()
    out[place] = number
    return out


def less(plan, samples):
    """Return a plan with some of the samples."""
    movement = plan.trajectory
    columns = ("time", "joints", "path", "rates")
    parts = {n: getattr(movement, n) for n in columns}
    return moved(plan, **{n: None if v is None else v[samples] for n, v in parts.items()})


def finer(plan):
    """Return a plan with a sample between the first two, so that there are at least three."""
    movement, half = plan.trajectory, 0.5
    between = half * movement.time[:1] + half * movement.time[1:2]
    cut = lambda v: None if v is None else np.concatenate([v[:1], half * (v[:1] + v[1:2]), v[1:]])  # noqa: E731
    time_ = np.concatenate([movement.time[:1], between, movement.time[1:]])
    return moved(plan, time=time_, joints=cut(movement.joints), path=cut(movement.path))


class Liar(Plan):
    """A plan that says something else each time."""

    @property
    def caught(self):
        return True

    @property
    def trajectory(self):
        return FAST[0]

    @trajectory.setter
    def trajectory(self, value):
        pass


FAST = []


def lies_by_property(situation, plan):
    FAST[:] = [forged(plan.trajectory, time=plan.trajectory.time / 1000.0)]
    made = object.__new__(Liar)
    for field in dataclasses.fields(Plan):
        if field.name != "trajectory":
            object.__setattr__(made, field.name, getattr(plan, field.name))
    object.__setattr__(made, "catch_time", plan.catch_time / 1000.0)
    return made


class Caught(str):
    """A word that is equal to everything."""

    __hash__ = str.__hash__

    def __eq__(self, other):
        return True

    def __str__(self):
        return "caught"


def changed_situation(situation, plan):
    object.__setattr__(situation, "horizon", 100.0)
    return plan


def raises(situation, plan):
    raise RuntimeError("no\nidea")


def ends(situation, plan):
    sys.exit(3)


def shifted(situation, plan):
    """Return a plan for an arm that starts elsewhere."""
    return every(plan, lambda v: v + 1e-3)


replace = dataclasses.replace
LIES = {
    "too fast": lambda s, p: with_times(p, lambda t: t / 1000.0),
    "a little too fast": lambda s, p: with_times(p, lambda t: 0.05 * t),
    "too late": lambda s, p: with_times(p, lambda t: t + np.r_[np.zeros(len(t) - 1), 100.0]),
    "past the horizon": lambda s, p: with_times(p, lambda t: t * (1.01 * s.horizon / t[-1])),
    "catch time earlier than the end": lambda s, p: replace(p, catch_time=0.5 * p.catch_time),
    "catch time later than the end": lambda s, p: replace(p, catch_time=p.catch_time + 0.1),
    "catch time negative": lambda s, p: replace(p, catch_time=-1.0),
    "catch time not a number": lambda s, p: replace(p, catch_time=float("nan")),
    "catch time infinite": lambda s, p: replace(p, catch_time=float("inf")),
    "catch time None": lambda s, p: replace(p, catch_time=None),
    "catch time text": lambda s, p: replace(p, catch_time="soon"),
    "catch time complex": lambda s, p: replace(p, catch_time=p.catch_time + 0j),
    "no target of this name": lambda s, p: replace(p, catch_body="nobody"),
    "no body": lambda s, p: replace(p, catch_body=None),
    "an index for a body": lambda s, p: replace(p, catch_body=0),
    "an obstacle for a body": lambda s, p: replace(
        p, catch_body=next((b.name for b in s.obstacles), "nobody")
    ),
    "no trajectory": lambda s, p: replace(p, trajectory=None),
    "a dict for a trajectory": lambda s, p: replace(p, trajectory={"time": [0.0]}),
    "a look-alike of a trajectory": lambda s, p: replace(
        p, trajectory=SimpleNamespace(**vars(p.trajectory))
    ),
    "ends before the catch": lambda s, p: less(finer(p), slice(0, 2)),
    "starts late": lambda s, p: with_times(finer(p), lambda t: t + 1e-3),
    "starts before t = 0": lambda s, p: with_times(finer(p), lambda t: t - 1e-3),
    "starts at its second sample": lambda s, p: less(finer(p), slice(1, None)),
    "starts elsewhere": shifted,
    "times go back": lambda s, p: with_times(finer(p), lambda t: t[::-1].copy()),
    "times not sorted": lambda s, p: with_times(finer(p), lambda t: spoiled(t, 1, 2.0 * t[-1])),
    "all times the same": lambda s, p: with_times(p, lambda t: 0.0 * t),
    "a jump at one time": lambda s, p: with_times(finer(p), lambda t: spoiled(0.0 * t, -1, t[-1])),
    "a knot that jumps": lambda s, p: every(finer(p), lambda v: spoiled(v, 1, v[1] + 0.4)),
    "not a number on the way": lambda s, p: every(finer(p), lambda v: spoiled(v, 1, np.nan)),
    "infinite on the way": lambda s, p: every(finer(p), lambda v: spoiled(v, 1, np.inf)),
    "huge on the way": lambda s, p: every(finer(p), lambda v: spoiled(v, 1, 1e200)),
    "a time that is not a number": lambda s, p: with_times(p, lambda t: spoiled(t, -1, np.nan)),
    "wrong shape": lambda s, p: every(p, lambda v: v.T),
    "one column too few": lambda s, p: every(p, lambda v: v[:, :-1]),
    "one row too few": lambda s, p: every(finer(p), lambda v: v[:-1]),
    "one dimension too many": lambda s, p: every(p, lambda v: v[None]),
    "empty": lambda s, p: less(p, slice(0, 0)),
    "a time for an array": lambda s, p: moved(p, time=np.float64(0.0)),
    "lists": lambda s, p: moved(p, time=["a"] * len(p.trajectory.time)),
    "objects": lambda s, p: every(p, lambda v: np.full(v.shape, None, object)),
    "complex": lambda s, p: every(p, lambda v: v + 1e-3j),
    "truths": lambda s, p: every(p, lambda v: v > 0.0),
    "dates": lambda s, p: every(p, lambda v: np.zeros(v.shape, "datetime64[s]")),
    "a million samples": lambda s, p: moved(p, time=np.arange(1e6)),
    "mirrored": lambda s, p: every(p, lambda v: -v),
    "stays where it is": lambda s, p: every(p, lambda v: np.repeat(v[:1], len(v), axis=0)),
    "beyond the ranges": lambda s, p: every(finer(p), lambda v: spoiled(v, 1, v[1] + 50.0)),
    "hand off its joints": lambda s, p: moved(p, joints=p.trajectory.joints + 0.3),
    "rates where none belong": lambda s, p: moved(p, rates=9.0 + 0.0 * p.trajectory.joints),
    "another arm": lambda s, p: moved(p, arm=replace(s.arm, grasp=2.0 * s.arm.grasp)),
    "no arm": lambda s, p: moved(p, arm=None),
    "another situation's name": lambda s, p: replace(p, name="another"),
    "caught, but not": lambda s, p: replace(p, status="caught", trajectory=None),
    "an unknown status": lambda s, p: replace(p, status="won"),
    "a word that equals all": lambda s, p: replace(p, status=Caught("won"), trajectory=None),
    "blocked at the start": lambda s, p: replace(p, status="start_blocked"),
    "a property that lies": lies_by_property,
    "None": lambda s, p: None,
    "the movement alone": lambda s, p: p.trajectory,
    "the exchange format": lambda s, p: plan_to_json(p, s),
    "the class of plans": lambda s, p: Plan,
    "True": lambda s, p: True,
    "changes the situation": changed_situation,
    "raises": raises,
    "leaves": ends,
}


def planner_of(lie, plan):
    """Return a planner that tells a lie in every situation."""

    class Lying:
        name = "lying"

        def takes(self, kind):
            return True

        def plan(self, situation):
            return lie(situation, plan)

    return Lying()


SAID = {
    "catch time earlier than the end": "end at the catch",
    "catch time later than the end": "end at the catch",
    "no target of this name": "'nobody', which is no target",
    "starts elsewhere": Failure.WRONG_START.value,
    "ends before the catch": "misses the target",
    "another arm": "another arm",
}


@pytest.mark.parametrize("lie", LIES)
def test_no_lie_comes_through(case, lie):
    situation, plan = case
    before = situation_to_json(situation)
    answer = solve(situation, planner_of(LIES[lie], plan))
    assert answer.status in ("broken", "error"), answer.message
    assert answer.message.startswith("the planner") and "\n" not in answer.message
    assert SAID.get(lie, "") in answer.message
    assert answer.trajectory is answer.catch_time is answer.catch_body is None
    record = json.loads(json.dumps(plan_to_json(answer, situation), allow_nan=False))
    assert record["status"] == "unreachable" and "trajectory" not in record
    assert situation_to_json(situation) == before


def test_the_truth_comes_through(case):
    """A plan that holds is taken as it is; whole numbers and float32 are numbers, too."""
    situation, plan = case
    answer = solve(situation, planner_of(lambda s, p: p, plan))
    assert answer.status == "caught" and answer.catch_time == plan.catch_time
    assert answer.planner == "lying" and answer.clearance == plan.clearance
    for name in ("time", "joints", "hand"):
        given, kept = getattr(plan.trajectory, name), getattr(answer.trajectory, name)
        assert np.array_equal(given, kept) and given is not kept


def test_a_movement_through_an_obstacle_is_broken():
    situation = PAPER_SCENES["fig4"]()
    plan = solve(situation, "gcm")
    share = np.linspace(0.0, 1.0, 60)[:, None]
    hand = (1.0 - share) * plan.trajectory.hand[0] + share * plan.trajectory.hand[-1]
    through = Movement.of_hand(situation.arm, np.linspace(0.0, plan.catch_time, 60), hand)
    answer = solve(situation, lambda s: replace(plan, trajectory=through))
    assert answer.status == "broken" and "touched" in answer.message


def test_a_touch_in_space_is_seen():
    situation, plan = thrown_scene(), solve(thrown_scene(), "search")
    midst = tuple(plan.trajectory.hand_at(0.5 * plan.catch_time))
    post = situation.obstacles[0]
    there = replace(post, motion=replace(post.motion, position=midst, velocity=(0.0, 0.0, 0.0)))
    bodies = tuple(there if body is post else body for body in situation.bodies)
    assert "touched" in broken_promise(replace(situation, bodies=bodies), plan)


def test_limits_of_joints_and_kinds_of_arms_are_looked_at():
    (flat, planner), (deep, other) = CASES["planar"](), CASES["spatial"]()
    hand, joints = solve(flat, planner), solve(deep, other)
    slow = replace(flat.arm, max_joint_speed=(0.01, 0.01))
    assert "joint" in broken_promise(replace(flat, arm=slow), moved(hand, arm=slow))
    assert "max_hand_speed" in broken_promise(flat, with_times(hand, lambda t: 0.5 * t))
    hurried = with_times(joints, lambda t: np.r_[t[0], 0.02 * t[1:-1], t[-1]])
    assert "max_joint_speed" in broken_promise(deep, hurried)
    assert "other kind" in broken_promise(flat, joints)
    assert "other kind" in broken_promise(deep, hand)
    assert broken_promise(flat, replace(hand, status="unreachable", trajectory=None)) is None


def test_one_catch_of_two_that_are_wanted_is_broken():
    given = drawn("slide", 0)
    other = given["bodies"][0] | {"name": "other", "shape": {"kind": "sphere", "radius": 0.01}}
    given["bodies"].append(other)
    situation = situation_from_json(given | {"catch": "all"})
    plan = solve(situation_from_json(given | {"catch": "most"}), "search")
    assert plan.caught
    plan = dataclasses.replace(plan, on_the_way=())
    answer = solve(situation, planner_of(lambda s, p: p, plan))
    assert answer.status == "broken" and "catches 1 of 2 targets" in answer.message


@pytest.fixture(scope="module")
def sequence():
    """Return a situation that asks for several targets, and a plan that catches some."""
    situation = draw("sequence-chain", 10, 0)
    plan = solve(situation, "search")
    assert len(plan.on_the_way) > 1
    return situation, plan


def test_several_catches_from_outside_come_through(sequence):
    situation, plan = sequence
    answer = solve(situation, planner_of(lambda s, p: p, plan))
    assert answer.catches == plan.catches and answer.status == "caught"


def on_the_way(change):
    return lambda s, plan: dataclasses.replace(plan, on_the_way=tuple(change(plan.on_the_way)))


@pytest.mark.parametrize(
    ("change", "word"),
    [
        (lambda way: [way[0], *way], "a target twice"),
        (lambda way: way[::-1], "another order"),
        (lambda way: [(way[0][0], way[0][1] + 1e-4), *way[1:]], "no sample"),
        (lambda way: [(way[0][0], 0.0), *way[1:]], "target"),
        (lambda way: [("obstacle 1", way[0][1]), *way[1:]], "no target"),
        (lambda way: [(way[0][0], "soon")], "on_the_way is a str"),
        (lambda way: [way[0][:1]], "not enough values"),
    ],
)
def test_a_lie_about_catches_on_the_way_is_found(sequence, change, word):
    situation, plan = sequence
    answer = solve(situation, planner_of(on_the_way(change), plan))
    assert answer.status == "broken" and word in answer.message, answer.message


def test_one_is_caught_where_one_is_wanted(case):
    situation, plan = case
    before = dataclasses.replace(plan, on_the_way=((situation.targets[0].name, 0.0),))
    answer = solve(situation, planner_of(lambda s, p: p, before))
    assert answer.status == "broken" and "and one is wanted" in answer.message


def test_what_a_planner_prints_is_no_answer_and_its_errors_have_a_place(capsys):
    def talks(situation):
        print("thinking")
        raise ValueError("no idea")

    answer = solve(PAPER_SCENES["fig4"](), talks)
    told = capsys.readouterr()
    assert told.out == "" and told.err == "thinking\n"
    assert answer.message.startswith("the planner fails: ValueError: no idea (test_lies.py:")


def test_planners_by_name_are_not_verified_again(monkeypatch):
    """Trust goes by identity: a namesake from outside is verified, whatever it calls itself."""
    from gcm_learn.planners import outside

    calls = []
    real = outside.judged_anew
    monkeypatch.setattr(outside, "judged_anew", lambda *given: calls.append(1) or real(*given))
    situation = PAPER_SCENES["fig4"]()
    gcm = get_planner("gcm")
    assert solve(situation, "gcm").caught and solve(situation, gcm).caught and not calls
    namesake = SimpleNamespace(name="gcm", plan=gcm.plan, trusted=True)
    assert solve(situation, namesake).caught and len(calls) == 1


class Stubborn:
    """Never ends, and catches every `Exception`."""

    def plan(self, situation):
        while True:
            try:
                time.sleep(0.01)
            except Exception:
                continue


def test_liars_cost_their_own_rows():
    """In a comparison a planner that fails, lies or hangs leaves the others alone."""
    situations = [draw("crossing-swarm", 12, k) for k in range(2)]

    def too_fast(situation):
        plan = get_planner("gcm").plan(situation)
        if not plan.caught:
            return plan
        slow = plan.trajectory
        way = Movement.of_hand(slow.arm, slow.time / 1000.0, slow.hand)
        return replace(plan, trajectory=way, catch_time=plan.catch_time / 1000.0)

    methods = ["gcm", too_fast, lambda situation: None, Stubborn()]
    sheet = ask(methods, situations, [Condition(limit=0.2)])
    names = sheet.each("entrant")
    outcomes = {name: sheet.where(entrant=name)["outcome"].tolist() for name in names}
    assert list(outcomes) == ["gcm", "too_fast", "<lambda>", "Stubborn"]
    for own, other in zip(outcomes["gcm"], outcomes["too_fast"], strict=True):
        assert other == ("broken" if own == "caught" else own)
    assert "broken" in outcomes["too_fast"]
    assert set(outcomes["<lambda>"]) == set(outcomes["Stubborn"]) == {"error"}
    assert "no answer within 0.2 s" in sheet.where(entrant="Stubborn")["reason"][0]


def test_ctrl_c_ends_a_run():
    def interrupted(situation):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        solve(PAPER_SCENES["fig4"](), interrupted)


def test_the_command_says_that_a_promise_was_broken(tmp_path, capsys):
    (tmp_path / "mine.py").write_text(
        "import dataclasses\n"
        "from gcm_learn import get_planner\n"
        "class Ghost:\n"
        "    def plan(self, situation):\n"
        "        plan = get_planner('gcm').plan(situation)\n"
        "        return dataclasses.replace(plan, catch_time=0.001)\n"
    )
    scene = tmp_path / "scene.json"
    scene.write_text(json.dumps(situation_to_json(PAPER_SCENES["fig4"]())))
    assert main(["solve", str(scene), "--planner", f"{tmp_path / 'mine.py'}:Ghost"]) == 0
    answer = json.loads(capsys.readouterr().out)
    assert answer["status"] == "unreachable" and answer["message"].startswith("the planner breaks")
