"""The closed loop: thinking takes time, plans begin where the arm will be, noise is survived."""

from dataclasses import replace
from itertools import cycle
from types import SimpleNamespace

import numpy as np
import pytest

from gcm_learn import families
from gcm_learn.arms import PLANAR, Arm, SpatialArm, kind_of
from gcm_learn.execution import (
    CAUGHT,
    COLLIDED,
    LATE,
    RUNNING,
    Commanding,
    ExactPlant,
    Loop,
    Perception,
    PhysicalPlant,
    Planning,
    body_for,
    execute_seen,
    run_closed_loop,
)
from gcm_learn.motion import Movement
from gcm_learn.planners import get_planner
from gcm_learn.situation import (
    Body,
    Hold,
    Place,
    Sphere,
)
from tests.worlds import among, disc, flight, panda, solid_ball

EXACT = Perception()
ARM = SpatialArm(
    upper_arm=(1.0, 0.0, 0.0), forearm=(1.0, 0.0, 0.0), joints=(0.0, 0.0, 0.0, -0.5),
    joint_range=((-2.0, 2.0),) * 4, max_joint_speed=(6.0,) * 4, grasp=0.05, thickness=0.05,
    max_joint_acceleration=(40.0,) * 4,
)  # fmt: skip


PLANAR_ARM = Arm(hand=(1.6, 0.2), max_hand_speed=3.0, thickness=0.05)


def falling(arm=ARM, shift=0.0):
    """Return a ball that falls past a spatial arm's reach."""
    motion = flight((1.2, 1.5 + shift, 1.2), (0.0, -1.2, 0.0), (0.0, 0.0, -2.0))
    return among(arm, Body("target", "ball", Sphere(0.1), motion), horizon=1.2)


def flying(shift=0.0):
    """Return a disc that flies past a planar arm's reach."""
    target = disc("disc", (-1.4, 1.3 + shift), (2.2, -0.4), "target", 0.1, (0.0, -2.0))
    return among(PLANAR_ARM, target, horizon=1.2)


def thrown(shift=0.0):
    """Return a ball that flies past a Panda's reach."""
    motion = flight((0.5, 1.0 + shift, 0.6), (0.0, -0.9, 1.5), (0.0, 0.0, -3.0))
    arm = panda(0.05, max_joint_acceleration=(15.0,) * 7)
    return among(arm, Body("target", "ball", Sphere(0.05), motion), horizon=1.2)


MADE = {"planar": flying, "spatial": falling, "chain": thrown}
EACH = pytest.mark.parametrize("make", MADE.values(), ids=MADE)
"""Situations with every kind of arm in the closed loop."""


def state_of(arm):
    """Return the posture of an arm, and its rates if it has limits of acceleration."""
    return arm.hand if kind_of(arm) is PLANAR else (*arm.joints, *(arm.joint_rates or ()))


class Noted:
    """A planner that notes its questions."""

    def __init__(self, planner=None):
        self.asked, self.answers = [], []
        self.planner = planner or get_planner("search")

    def plan(self, situation):
        self.asked.append(situation)
        self.answers.append(self.planner.plan(situation))
        return self.answers[-1]


class Kept:
    """An agent whose movements are kept."""

    def __init__(self, mind):
        self.mind, self.found = mind, []

    def wants(self, occasion):
        return self.mind.wants(occasion)

    def plan(self, believed):
        self.found.append(self.mind.plan(believed))
        return self.found[-1]


class Silent:
    """A planner that finds nothing."""

    def plan(self, situation):
        return SimpleNamespace(trajectory=None)


class Watched(ExactPlant):
    """A plant that notes the trajectories that it follows."""

    def __init__(self, situation):
        super().__init__(situation)
        self.led, self.rows = [], []

    def follow(self, trajectory, until):
        self.led.append(trajectory)
        super().follow(trajectory, until)
        self.rows.append((self.time, *state_of(self.arm)))


@EACH
@pytest.mark.parametrize("thinking", [0.0, 0.01, 0.02, 0.05, 0.1])
def test_a_plan_is_followed_when_it_is_thought_out(make, thinking):
    """It is for the world as it is then, from where the arm is then."""
    situation, planner = make(), Noted()
    plant = Watched(situation)
    course = run_closed_loop(
        Planning(planner, "once"), plant, situation, Loop(EXACT, 2, thinking=thinking), 0
    )
    assert course.outcome == CAUGHT and len(planner.asked) == 1
    periods = int(np.ceil(thinking / 0.02 - 1e-9))
    start = (2 + periods) * 0.02  # two looks, each told one period late
    assert planner.asked[0].horizon == pytest.approx(1.2 - start)
    rest = np.array(state_of(situation.arm))
    assert state_of(planner.asked[0].arm)[: rest.size] == pytest.approx(rest)
    assert course.time <= start + planner.answers[0].catch_time + 1e-6
    moves = [t for t, *state in plant.rows if np.abs(state[: rest.size] - rest).max() > 1e-9]
    assert moves[0] == pytest.approx(start + 0.02)
    (thought,) = course.thoughts
    assert thought.begun == pytest.approx(0.04)
    assert (thought.took, thought.found) == (thinking, True)


def test_who_thinks_long_goes_on_meanwhile():
    """The second thought begins where the first plan will have led; nothing ever jumps."""
    situation, planner = falling(), Noted()
    plant = Watched(situation)
    loop = Loop(replace(EXACT, place=0.02), 2, thinking=0.1)
    course = run_closed_loop(Planning(planner, "always"), plant, situation, loop, 3)
    assert len(planner.asked) > 2
    for k, asked in enumerate(planner.asked):
        start = 0.04 + 0.1 * (k + 1)
        assert asked.horizon == pytest.approx(1.2 - start)
        there = [row for row in plant.rows if abs(row[0] - start) < 1e-9]
        if there:
            assert asked.arm.joints == pytest.approx(there[0][1:5], abs=1e-9)
            assert asked.arm.joint_rates == pytest.approx(there[0][5:], abs=1e-6)
    assert any(any(asked.arm.joint_rates) for asked in planner.asked[1:])
    assert_within_limits(np.array(plant.rows))
    assert course.thoughts[0].begun == pytest.approx(0.04)


def test_thinking_is_charged_as_long_as_it_takes():
    """By processor time: a planner that dawdles is late, and its plan is for when it is ready."""

    class Slow(Noted):
        def plan(self, situation):
            import time

            since = time.process_time()
            while time.process_time() - since < 0.07:
                pass
            return super().plan(situation)

    situation, planner = falling(), Slow()
    planner.planner.plan(situation)  # compiled now
    course = run_closed_loop(
        Planning(planner, "once"), ExactPlant(situation), situation, Loop(EXACT, 2), 0
    )
    (thought,) = course.thoughts
    assert thought.took >= 0.07
    if thought.found:
        ready = 1.2 - planner.asked[-1].horizon
        assert ready >= thought.begun + thought.took - 1e-9
        assert len(planner.asked) > 1  # it had to allow for more than a period


@EACH
def test_a_plan_that_holds_is_kept(make):
    """Without noise one thought suffices for every habit that keeps good plans."""
    courses = [course_of(habit, make(), Loop(EXACT, 2, thinking=0.02), 0) for habit in HABITS]
    assert [course.outcome for course in courses] == [CAUGHT] * 3
    assert [len(course.thoughts) for course in courses[:2]] == [1, 1]
    assert len(courses[2].thoughts) > 5
    assert courses[0].time == courses[1].time


HABITS = ("once", "broken", "always")


def course_of(habit, situation, loop, *seed):
    mind = Planning(get_planner("search"), habit)
    return run_closed_loop(mind, ExactPlant(situation), situation, loop, *seed)


@pytest.mark.parametrize("make", [flying, falling, pytest.param(thrown, marks=pytest.mark.slow)])
def test_a_plan_that_breaks_is_replaced(make):
    """With noise the first plan misses, one that is made anew does not."""
    loop, found = Loop(Perception(place=0.04), 2, thinking=0.02), {"once": 0, "broken": 0}
    for habit in found:
        for k in range(12):
            course = course_of(habit, make(shift=0.02 * k), loop, 5, k)
            found[habit] += course.outcome == CAUGHT
    assert found["once"] <= 8 and found["broken"] >= found["once"] + 3


def test_nothing_is_done_without_a_plan():
    """An arm that moves brakes; the episode goes on to its end, whatever comes."""
    arm, loop = replace(ARM, joint_rates=(1.0, 0.0, -2.0, 0.5)), Loop(EXACT, 2, thinking=0.02)
    plant, silent = ExactPlant(falling(arm)), Planning(Silent(), "always")
    course = run_closed_loop(silent, plant, falling(arm), loop, 0)
    assert course.outcome == LATE and course.time == pytest.approx(1.2)
    assert not any(plant.arm.joint_rates) and not any(thought.found for thought in course.thoughts)
    stone = solid_ball("stone", (1.0, 0.0, -0.5), (0.0, 0.0, 1.0), radius=0.1)
    stone = replace(falling(), bodies=(*falling().bodies, stone))
    course = run_closed_loop(silent, ExactPlant(stone), stone, loop, 0)
    assert course.outcome == COLLIDED and course.time == pytest.approx(0.35, abs=1e-3)


@EACH
def test_the_same_seed_goes_the_same_way(make):
    loop = Loop(Perception(place=0.03, dropouts=1.0), 2, thinking=0.03)
    courses = [course_of("broken", make(), loop, 9, k) for k in (1, 1, 2)]
    assert courses[0] == courses[1] != courses[2]


def test_nothing_is_thought_while_the_hand_is_too_fast():
    """An arm that brakes may move its hand faster than any situation allows at t = 0."""
    begins, fast = 0.2, 0.1
    arm = replace(ARM, max_hand_speed=3.0)
    occasions = []

    class Hasty:
        def wants(self, occasion):
            occasions.append(situation.horizon - occasion.believed.horizon)
            return occasion.thoughts == 0

        def plan(self, believed):
            rate = np.array([0.0, 5.0, 0.0, 0.0])
            joints = np.array(arm.joints) + np.outer([0.0, fast], rate)
            return Movement(arm, np.array([0.0, fast]), joints, np.stack([rate, rate]))

    situation = replace(falling(arm, shift=5.0), format="gcm-learn/situation@3")
    loop = Loop(EXACT, looks=round(begins / EXACT.period), thinking=0.0)
    course = run_closed_loop(Hasty(), ExactPlant(situation), situation, loop, 0)
    assert course.outcome == LATE and len(course.thoughts) == 1
    first = occasions[0]
    assert not [t for t in occasions if first + 1e-6 < t < first + fast]
    assert max(occasions) > first + fast


@pytest.mark.parametrize("limited", [True, False])
def test_joints_can_be_commanded(limited):
    """As a learned policy would: straight at the target's posture, within all limits."""
    arm = ARM if limited else replace(ARM, max_joint_acceleration=None, joint_rates=None)
    goal = np.array([-0.6, 1.9, 1.0, 0.3])

    def policy(told):
        return 8.0 / 6.0 * (goal - told[:, :4])

    hand = Movement(arm, np.zeros(1), goal[None]).hand[0]
    ball = solid_ball("ball", hand.tolist(), role="target", radius=0.1)
    situation = among(arm, ball, horizon=2.0)
    plant = Watched(situation)
    course = run_closed_loop(Commanding(policy), plant, situation, Loop(EXACT, 2, thinking=0.0), 0)
    assert course.outcome == CAUGHT
    rows = np.array(plant.rows)
    assert_within_limits(rows)
    assert (np.abs(rows[:, 1:5]) <= 2.0 + 1e-9).all()


def assert_within_limits(rows):
    """Joints, and rates where there are some, change no faster than the arm's limits allow."""
    for columns, most in ((slice(1, 5), 6.0), (slice(5, 9), 40.0)):
        assert (np.abs(np.diff(rows[:-1, columns], axis=0)) <= most * 0.02 + 1e-6).all()


def test_commands_end_before_the_range_does():
    situation = falling()
    plant = Watched(situation)
    ahead = Commanding(lambda told: np.array([[0.0, 9.0, -9.0, 9.0]]))
    run_closed_loop(ahead, plant, situation, Loop(EXACT, 2, thinking=0.02), 0)
    rows = np.array(plant.rows)
    assert (np.abs(rows[:, 1:5]) <= 2.0 + 1e-6).all()
    assert rows[-1, 2] > 1.9


RAMPED = {
    name: replace(family, arm=replace(family.arm, ramp=(0.1, 0.1)))
    for name, family in ((n, families.get_family(n)) for n in families.family_names("spatial"))
}
"""Families of spatial arms, with limits of acceleration."""


@pytest.mark.parametrize("name", families.family_names())
def test_exact_perception_catches_what_is_planned(name):
    """In every family: with exact percepts and no thinking time, a plan is a catch."""
    for k in range(2):
        situation = families.draw(RAMPED.get(name, name), 1401, k)
        mind = Kept(Planning(get_planner("search"), "once"))
        plant, loop = ExactPlant(situation), Loop(EXACT, 2, thinking=0.0)
        course = run_closed_loop(mind, plant, situation, loop, 0)
        if not mind.found or mind.found[0] is None:
            continue
        if situation.catch == "most" and course.outcome != CAUGHT:  # the world goes on after it
            end = course.thoughts[0].begun + mind.found[0].duration
            caught = course.catches[-1].time  # the hand may come within the grasp a little earlier
            assert end - 1e-3 < caught < end + 1e-6 and course.time > end
        else:
            assert course.outcome == CAUGHT


def test_an_arm_with_mass_is_led_too():
    """It lags a little behind what it is led along, and catches when the kinematic one does."""
    pytest.importorskip("mujoco")
    situation, loop = falling(), Loop(Perception(place=0.01), 4, thinking=0.02)
    plants = ExactPlant(situation), PhysicalPlant(situation, body_for(ARM))
    mind = Planning(get_planner("search"))
    courses = [run_closed_loop(mind, plant, situation, loop, 3) for plant in plants]
    assert [course.outcome for course in courses] == [CAUGHT, CAUGHT]
    assert courses[1].time == pytest.approx(courses[0].time, abs=0.05)
    assert plants[1].catch_time == courses[1].time
    off = np.abs(plants[1].joints_log[plants[1].steps] - plants[0].arm.joints).max()
    assert 1e-6 < off < 0.3


class Recorder(ExactPlant):
    """A plant that notes where commands want the arm to be, every 2 ms."""

    def __init__(self, situation):
        super().__init__(situation)
        self.wanted = []

    def follow(self, trajectory, until):
        """Note the commands, and let the time go on."""
        steps = np.arange(round(self.time / 0.002), round(min(until, 1.0) / 0.002))
        self.wanted += list(trajectory.joints_at(0.002 * steps)) if len(steps) else []
        self.time = max(until, self.time)
        self.outcome = RUNNING if until < 1.0 - 1e-9 else LATE


@pytest.mark.parametrize("latency", [0.02, 0.05, 0.006])
def test_commands_come_late_by_the_latency(latency):
    """Whatever is commanded, the arm is told it so much later, and rests before."""
    situation = replace(falling(), horizon=2.0)
    swing = np.array([[0.0, 0.0, 0.0, -0.5], [0.6, 0.3, 0.0, -0.2], [0.0, 0.6, 0.4, -0.9]])

    def waving():
        """Begin another movement in every fifth period."""
        turn = cycle(swing)

        def plan(believed):
            joints = np.stack([np.array(believed.arm.joints), next(turn)])
            return Movement(believed.arm, np.array([0.0, 0.3]), joints, np.zeros((2, 4)))

        return SimpleNamespace(wants=lambda occasion: True, plan=plan)

    def wanted(late):
        plant = Recorder(situation)
        loop = Loop(EXACT, looks=2, thinking=0.1, latency=late)
        run_closed_loop(waving(), plant, situation, loop, 0)
        return np.array(plant.wanted)

    prompt, late, shift = wanted(0.0), wanted(latency), round(latency / 0.002)
    assert np.ptp(prompt, axis=0).max() > 0.2
    assert late[shift:] == pytest.approx(prompt[: len(prompt) - shift])
    assert late[:shift] == pytest.approx(np.tile(ARM.joints, (shift, 1)))


@pytest.mark.parametrize("place", [None, Place((0.3, 0.4, 0.4), 0.05)])
def test_an_arm_that_plans_while_it_moves_grips_and_places(place):
    """The hand closes after the hold of the plan that is followed, a latency later."""
    arm = panda(max_joint_acceleration=(15, 7.5, 10, 12.5, 15, 20, 20))
    belt = flight((0.5, -0.5, 0.2), (0.0, 0.3, 0.0))
    ball = Body("target", "ball", Sphere(0.02), belt, hold=Hold(0.2, 0.05), place=place)
    situation = among(arm, ball, horizon=2.0, end="rest")
    for late in (0.0, 0.02):
        loop = Loop(Perception(latency=late), looks=2, thinking=0.02, latency=late)
        noted = Noted()
        done = execute_seen(Planning(noted), situation, loop, 0, body=body_for(arm))
        assert done.caught and done.grip.closed >= 0.2 + done.catch_time
        assert min(asked.horizon for asked in noted.asked) >= 2.0 - done.grip.closed
        assert (done.grip.opened is None) == (place is None)
        assert place is None or done.grip.off_place <= place.within
