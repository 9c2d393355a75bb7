"""ST-RRT* through OMPL: what it is asked, what it answers, and what is said without OMPL."""

from __future__ import annotations

import math
import os
import signal
import subprocess
import sys

import numpy as np
import pytest

from gcm_learn import seeding
from gcm_learn.arms import Arm
from gcm_learn.errors import ArmKindError
from gcm_learn.families.random_planar import random_planar
from gcm_learn.motion.joint_interception import met_at
from gcm_learn.planners import plan_to_json
from gcm_learn.planners.baselines import st_rrt_star
from gcm_learn.planners.baselines.st_rrt_star import STRRTStarPlanner, task_of
from gcm_learn.planners.baselines.st_rrt_star_joints import near, task_in_space
from gcm_learn.planners.baselines.st_rrt_star_moves import draw_goal, leg_holds
from gcm_learn.planners.baselines.straight import StraightPlanner
from gcm_learn.planners.completion import JointProblem, Problem
from gcm_learn.planners.oracle.bounds import bounds
from gcm_learn.referee import judge as referee_judge
from gcm_learn.situation import Body, Disc, Situation, read_situations, situation_from_json
from tests import chains
from tests.extras import needed
from tests.judging import judge
from tests.planners.test_baselines import FREE, GATE, OPENS, TRAP, body, goal, scene
from tests.spatial import EXAMPLES

needs_ompl = needed("st-rrt-star")
SECOND = Body("target", "second", Disc(0.05), FREE.bodies[0].motion)


# --- legs and goals, which need no OMPL ------------------------------------------------------

BULLET = body("obstacle", Disc(0.05), (1.2, -5.0), (0.0, 10.0))  # crosses y = 0 at t = 0.5


def ask(situation, *leg):
    return leg_holds(*asked(situation), *leg)


def asked(situation):
    """Scene, rules and hole, as of a search."""
    task = task_of(Problem(situation, "test"), seed=0, budget_ms=0.0, iterations=0)
    return task.scene, task.rules, task.hole


@pytest.mark.slow
def test_a_leg_keeps_the_speed_limit_and_goes_forward_in_time():
    empty = scene(goal(1.5, 0.9))
    assert ask(empty, 1.0, 0.0, 0.2, 1.33, 0.0, 0.3001)
    assert not ask(empty, 1.0, 0.0, 0.2, 1.33, 0.0, 0.2999)
    assert not ask(empty, 1.0, 0.0, 0.3, 1.1, 0.0, 0.2)
    assert not ask(empty, 1.0, 0.0, 0.3, 1.0, 0.0, 0.3)


@pytest.mark.slow
def test_a_leg_stays_in_the_ring():
    arm = Arm((1.0, 0.0), 3.0, upper_arm=1.5)
    ring = Situation("ring", 9.0, arm, (goal(1.5, 0.9),))
    assert ask(ring, 1.0, 0.0, 0.0, 2.49, 0.0, 1.0)
    assert not ask(ring, 1.0, 0.0, 0.0, 2.51, 0.0, 1.0)
    assert ask(ring, 0.6, -0.6, 0.0, 0.6, 0.6, 1.0)
    assert not ask(ring, 0.4, -0.6, 0.0, 0.4, 0.6, 1.0)  # through the hole of radius 0.5


@pytest.mark.slow
def test_a_leg_between_whose_ends_an_obstacle_passes_does_not_hold():
    """The limb lies along y = 0 from (1.2, 0) on when the bullet is there, for a moment."""
    crossed = scene(goal(1.5, 0.9), BULLET, hand=(1.99, 0.0))
    assert ask(crossed, 1.99, 0.0, 0.0, 1.99, 0.05, 0.45)
    assert not ask(crossed, 1.99, 0.0, 0.0, 1.99, 0.05, 1.0)
    assert ask(crossed, 1.99, 0.0, 0.55, 1.99, 0.05, 1.0)


@pytest.mark.slow
def test_a_leg_keeps_jointtask_of():
    """Half way out along a short arc the shoulder turns by the angle, so the limit is its rate."""
    angle = 0.02
    ends = (1.2, 0.0), (1.2 * math.cos(angle), 1.2 * math.sin(angle))
    for rate, holds in ((0.95, False), (1.1, True)):
        arm = Arm((1.2, 0.0), 30.0, max_joint_speed=(rate, 30.0))
        turning = Situation("turn", 9.0, arm, (goal(1.5, 0.9),))
        assert ask(turning, *ends[0], 0.0, *ends[1], angle) == holds


@pytest.mark.slow
def test_goals_are_interceptions_in_time():
    mover = body("target", Disc(0.05), (1.5, -0.9), (-0.5, 1.5))
    situation = scene(mover, body("obstacle", Disc(0.3), (1.7, 0.0)), hand=(0.9, 0.3))
    asking, rng = asked(situation), seeding.rng(7)
    drawn = np.array([draw_goal(*asking, 0.1, 1.1, rng.random((16, 4))) for _ in range(400)])
    time, hand = drawn[drawn[:, 0] >= 0.0, 0], drawn[drawn[:, 0] >= 0.0, 1:]
    assert len(time) > 300 and 0.1 <= time.min() and time.max() <= 1.1
    target = np.array([1.5, -0.9]) + time[:, None] * (-0.5, 1.5)
    off = np.hypot(*(hand - target).T)
    assert off.max() <= 0.1 and off.max() > 0.09 and off.min() < 0.02  # all over the grasp
    assert (np.hypot(*(hand - (0.9, 0.3)).T) <= 3.3 * time).all()
    assert (np.hypot(*(hand - (1.7, 0.0)).T) > 0.3).all()  # the hand at least is clear of it


@pytest.mark.slow
def test_no_goal_is_drawn_where_there_is_none():
    chances = seeding.rng(8).random((64, 4))
    too_early = draw_goal(*asked(scene(goal(0.7, 1.2))), 0.0, 0.1, chances)
    assert too_early[0] == -1.0


# --- answers ---------------------------------------------------------------------------------


@pytest.mark.slow
@needs_ompl
def test_it_waits_for_a_gate():
    plan = STRRTStarPlanner().plan(GATE)
    assert plan.caught and judge(GATE, plan) == []
    assert OPENS <= plan.catch_time <= 1.1 * OPENS


@pytest.mark.slow
@needs_ompl
def test_it_goes_round_a_bar_that_holds_a_field_up():
    plan = STRRTStarPlanner().plan(TRAP)
    assert plan.caught and judge(TRAP, plan) == []
    assert plan.trajectory.length > 2.8  # the straight way is 2.4 less radius and grasp


@pytest.mark.slow
@needs_ompl
@pytest.mark.parametrize(
    "situation",
    [
        FREE,
        scene(body("target", Disc(0.05), (1.5, -0.9), (0.0, 1.5)), hand=(0.9, 0.3)),
        scene(goal(-1.2, 0.3), SECOND),
    ],
)
def test_in_free_space_it_is_nearly_as_fast_as_a_straight_line(situation):
    plan, straight = STRRTStarPlanner().plan(situation), StraightPlanner().plan(situation)
    assert straight.catch_time <= plan.catch_time <= 1.02 * straight.catch_time
    assert plan.catch_body == straight.catch_body


@pytest.mark.slow
@needs_ompl
def test_no_catch_comes_before_the_oracles_lower_bound():
    caught = 0
    for k in range(30):
        situation = random_planar(seeding.rng(92, k))
        plan = STRRTStarPlanner(iterations=300).plan(situation)
        if plan.caught:
            caught += 1
            assert plan.catch_time >= bounds(situation, sizes=(60,)).lower
    assert caught > 10


@pytest.mark.slow
@needs_ompl
def test_the_same_seed_gives_the_same_answer_and_another_another():
    first, again, other = (STRRTStarPlanner(seed=seed).plan(GATE) for seed in (3, 3, 4))
    assert first.trajectory.hand.tolist() == again.trajectory.hand.tolist()
    assert first.catch_time == again.catch_time != other.catch_time


@pytest.mark.slow
@needs_ompl
def test_more_time_is_never_worse():
    caught = 0
    for situation in (GATE, TRAP, FREE):
        plans = STRRTStarPlanner().plan_anytime(situation, (5.0, 20.0, 80.0))
        times = [math.inf if plan.catch_time is None else plan.catch_time for plan in plans]
        assert times == sorted(times, reverse=True)
        assert [p.planning_ms for p in plans] == sorted(p.planning_ms for p in plans)
        caught += plans[-1].caught
        assert all(judge(situation, plan) == [] for plan in plans if plan.caught)
    assert caught


@pytest.mark.slow
@needs_ompl
def test_one_budget_is_a_run_of_its_own():
    plan = STRRTStarPlanner(budget_ms=200.0).plan(FREE)
    assert plan.caught and plan.planner == "st-rrt-star"


@pytest.mark.slow
@needs_ompl
def test_it_ends_when_nothing_better_is_to_be_expected():
    from gcm_learn.planners.baselines import st_rrt_star_search as library

    searches = []
    for situation in (FREE, GATE):
        task = task_of(Problem(situation, "test"), seed=0, budget_ms=1e4, iterations=4000)
        searches.append(library.Search(task, lambda *_: None))
        searches[-1].run()
    free, gate = searches
    assert free.looks < 4000 < gate.looks
    assert free.best <= 1.001 * StraightPlanner().plan(FREE).catch_time


@pytest.mark.slow
@needs_ompl
def test_what_was_found_before_a_crash_counts(monkeypatch):
    from gcm_learn.planners.baselines import st_rrt_star_search as library

    improved = library.Search._improved

    def crash_at_second(self, *arguments):
        if self.best < self.task.scene.limits.horizon:
            os.kill(os.getpid(), signal.SIGSEGV)
        improved(self, *arguments)

    monkeypatch.setattr(library.Search, "_improved", crash_at_second)
    plan = STRRTStarPlanner().plan(GATE)
    assert plan.caught and judge(GATE, plan) == []


# --- without OMPL ----------------------------------------------------------------------------


def without_ompl(code):
    """Run code in a process that cannot import ompl."""
    hidden = f"import sys; sys.modules['ompl'] = None\n{code}"
    return subprocess.run(
        [sys.executable, "-c", hidden], capture_output=True, text=True, check=False
    )


@pytest.mark.parametrize("spatial", [False, True])
def test_paths_on_which_time_goes_back_do_not_count(spatial, monkeypatch):
    """OMPL offers one now and then; seen in space, with 12 s for one of the late targets."""
    situation = read_situations(EXAMPLES)[0] if spatial else FREE
    width = 4 if spatial else 2
    back = np.zeros((3, width + 1))
    back[:, -1] = (0.0, 0.3, 0.2)
    monkeypatch.setattr(st_rrt_star, "_warmed", lambda: None)
    monkeypatch.setattr(st_rrt_star, "told", lambda work, longest: ([(1.0, back), (2.0, None)], 0))
    monkeypatch.setattr(st_rrt_star, "_library", lambda: None)
    assert not STRRTStarPlanner().plan_anytime(situation, (100.0,))[0].caught


def test_without_ompl_the_planner_is_listed_and_names_the_extra():
    done = without_ompl(
        "import gcm_learn\n"
        "assert 'st-rrt-star' in gcm_learn.planner_names()\n"
        "try:\n    gcm_learn.get_planner('st-rrt-star')\n"
        "except gcm_learn.errors.MissingExtraError as error:\n    print(error)\n"
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout == "st-rrt-star needs ompl 1.7: pip install 'gcm_learn[peers]'\n"


def test_without_ompl_the_command_line_says_so_in_one_line(tmp_path):
    command = f"main(['solve', {str(tmp_path / 'any.json')!r}, '--planner', 'st-rrt-star'])"
    done = without_ompl(f"from gcm_learn.cli import main\nsys.exit({command})")
    assert done.returncode == 2 and done.stdout == ""
    assert done.stderr.count("\n") == 1 and "pip install 'gcm_learn[peers]'" in done.stderr


# --- chains ----------------------------------------------------------------------------------


@pytest.mark.slow
@needs_ompl
def test_its_catches_of_chains_pass_the_referee_and_repeat():
    caught = 0
    for name, k in (("panda", 0), ("panda", 1), ("slide", 2), ("planar-2", 3)):
        given = chains.drawn(name, k)
        situation = situation_from_json(given)
        plans = [STRRTStarPlanner(iterations=3000).plan(situation) for _ in range(2)]
        answers = [plan_to_json(plan, situation) | {"planning_ms": 0.0} for plan in plans]
        assert answers[0] == answers[1]
        assert referee_judge(given, answers[0]) == [], given["name"]
        caught += plans[0].caught
    assert caught >= 3


def chain_task(k, postures=()):
    situation = situation_from_json(chains.drawn("panda", k))
    problem = JointProblem(situation, "test")
    task = task_in_space(problem, seed=0, budget_ms=0.0, iterations=0)
    return problem, near(task, postures) if postures else task


@pytest.mark.slow
@pytest.mark.parametrize("k", [0, 1, 3])
def test_goals_of_chains_catch_in_time(k):
    problem, task = chain_task(k)
    rate, drawn = problem.scene.limits.joint_speed, []
    for chances in seeding.rng(3).random((100, 16, task.draws)):
        t, *places = task.draw(problem.situation.horizon, chances)
        if t < 0.0:
            continue
        q = np.array(places) * rate
        met = met_at(problem.scene, q, t, problem.rules.catch + 1e-9, np.zeros((99, 12)))
        assert problem.situation.bodies[met].role == "target"
        assert (np.abs(q - problem.scene.limb.start) <= rate * t * (1.0 + 1e-9)).all()
        drawn.append(t)
    assert len(drawn) > 50 and np.ptp(drawn) > 0.3 * problem.situation.horizon


@pytest.mark.slow
def test_a_quarter_of_goals_of_chains_come_from_given_postures():
    problem, free = chain_task(0)
    chances = seeding.rng(4).random((400, 16, free.draws))
    end = problem.situation.horizon
    found = next(row for row in (free.draw(end, c) for c in chances) if row[0] > 0.0)
    posture = tuple(np.array(found[1:]) * problem.scene.limits.joint_speed)
    near_it = [0, 0]
    for way, task in enumerate((free, chain_task(0, (posture,))[1])):
        for c in chances:
            t, *places = task.draw(end, c)
            near_it[way] += t > 0.0 and np.abs(np.array(places) - found[1:]).max() < 0.1
    assert near_it[1] > 5 * max(near_it[0], 1)


@pytest.mark.slow
@needs_ompl
@pytest.mark.parametrize("situation", [FREE, read_situations(EXAMPLES)[0]])
def test_other_arms_refuse_given_postures(situation):
    with pytest.raises(ArmKindError, match=r"^postures: are of chains"):
        STRRTStarPlanner(postures=((0.0,) * 7,)).plan(situation)
