"""Actors: choices, networks as arrays, demonstrations, trying out."""

from dataclasses import replace

import numpy as np
import pytest

from gcm_learn import families, planners
from gcm_learn.errors import PolicyError, UnknownNameError
from gcm_learn.evaluation import get_method
from gcm_learn.execution import CAUGHT, Pool, Settings
from gcm_learn.execution.arena.kernels.hands.nearness import RAYS
from gcm_learn.motion.verification import verify
from gcm_learn.planners import get_planner
from gcm_learn.planners.completion import Problem
from gcm_learn.policies.actor import Actor, ActorPlanner
from gcm_learn.policies.cloning import act_out
from gcm_learn.policies.directions import MEETING, REST, aimed_of, choices_of, chosen, turned
from gcm_learn.situation.canonical import canonical
from tests.policies.conftest import constant_actor, leaning_in_space

SETTINGS = Settings(fan=True)


def straight_actor(head="choice"):
    """An actor that always goes straight to where the target can be met."""
    scores = 3.0 * np.eye(RAYS)[0] if head == "choice" else (1.0, 0.0)
    return constant_actor(SETTINGS, scores, head)


@pytest.fixture(scope="module")
def drawn():
    """Return situations in their canonical form."""
    return [canonical(families.draw("random-planar", 4, i))[0] for i in range(40)]


def test_choices_are_directions_from_the_meeting(rng):
    observations = rng.normal(size=(200, SETTINGS.width)).astype(np.float32)
    choices = rng.integers(RAYS, size=200)
    actions = chosen(SETTINGS, observations, choices)
    lengths = np.hypot(*actions.T)
    np.testing.assert_allclose(lengths, np.where(choices == REST, 0.0, 1.0))
    np.testing.assert_array_equal(choices_of(SETTINGS, observations, actions), choices)
    first = chosen(SETTINGS, observations, np.zeros(200, int))
    meeting = observations[:, MEETING : MEETING + 2]
    np.testing.assert_allclose(first, meeting / np.hypot(*meeting.T)[:, None], atol=1e-6)
    ahead = np.tile([1.0, 0.0], (200, 1))
    np.testing.assert_allclose(turned(observations, ahead), first, atol=1e-6)
    np.testing.assert_allclose(turned(observations, aimed_of(observations, actions)), actions)


def test_an_actor_that_goes_straight_catches_what_the_straight_line_does(drawn):
    pool = Pool.of(drawn)
    straight = np.array([planners.solve(s, "straight").caught for s in drawn])
    for head in ("choice", "velocity"):
        episodes = straight_actor(head).play(pool, np.arange(len(pool)))
        caught = episodes.outcomes == CAUGHT
        assert straight.sum() > 10
        assert np.mean(caught[straight]) > 0.85  # the meeting is told about, not exactly


def test_episodes_tell_what_the_hand_did(drawn):
    pool = Pool.of(drawn)
    episodes = straight_actor().play(pool, np.arange(len(pool)))
    for e in range(len(pool)):
        time, hand = episodes.path(e)
        assert len(time) == episodes.steps[e] + 1 and time[-1] == episodes.times[e]
        assert np.all(np.diff(time) > 0.0)
        assert tuple(hand[0]) == (drawn[e].arm.hand[0], 0.0)
        steps = np.hypot(*np.diff(hand, axis=0).T)
        assert np.all(steps <= drawn[e].arm.max_hand_speed * np.diff(time) * (1 + 1e-9))


def test_tried_out_ways_are_verified_plans(drawn):
    planner = ActorPlanner(straight_actor(), "tried", tries=4)
    outcomes = []
    for original in [families.draw("random-planar", 4, i) for i in range(25)]:
        plan = planner.plan(original)
        outcomes.append(plan.status)
        if plan.caught:
            problem = Problem(original, "test")
            index = [b.name for b in original.bodies].index(plan.catch_body)
            assert verify(problem.scene, problem.rules, plan.trajectory, index).good
        again = planner.plan(original)
        assert again.status == plan.status and again.catch_time == plan.catch_time
    assert {"caught", "unreachable"} <= set(outcomes)


@pytest.mark.parametrize("made", [straight_actor(), leaning_in_space(7)], ids=["plane", "space"])
def test_files_hold_the_same_actor(made, tmp_path, rng):
    actor = replace(made, mean=rng.normal(size=made.settings.width))
    actor.save(tmp_path)
    again = Actor.load(tmp_path)
    observations = rng.normal(size=(5, made.settings.width)).astype(np.float32)
    np.testing.assert_array_equal(again.scores(observations), actor.scores(observations))
    np.testing.assert_array_equal(again.act(observations), actor.act(observations))
    assert (again.settings, again.head) == (actor.settings, actor.head)
    with pytest.raises(PolicyError, match="there is no trained policy"):
        Actor.load(tmp_path / "nowhere")


def test_what_training_writes_is_taken_by_folder_and_by_the_learner_in_it(tmp_path):
    straight_actor().save(tmp_path)
    for given in (str(tmp_path), str(tmp_path / "model.zip")):
        assert get_method(given).actor.head == "choice"
        assert get_planner(given).planner.tries == 1
        assert get_planner(f"{given}@7").planner.tries == 7
    with pytest.raises(UnknownNameError, match="after @ comes a number of tries"):
        get_planner(f"{tmp_path}@few")


def test_drawn_choices_follow_the_scores(rng):
    actor = straight_actor()
    told = np.zeros((4000, SETTINGS.width), np.float32)
    told[:, MEETING] = 1.0
    drawn = choices_of(SETTINGS, told, actor.act(told, rng))
    share = np.exp(3.0) / (np.exp(3.0) + RAYS - 1)
    assert np.mean(drawn == 0) == pytest.approx(share, abs=0.03)


def test_planned_catches_are_acted_out():
    situations = [canonical(families.draw("crossing-swarm", 6, i))[0] for i in range(12)]
    plans = [planners.solve(s, "layered") for s in situations]
    kept = [(s, p.trajectory) for s, p in zip(situations, plans, strict=True) if p.caught]
    shown = act_out(Pool.of([s for s, _ in kept]), [way for _, way in kept], SETTINGS)
    assert shown.caught.mean() > 0.85
    assert shown.observations.shape == (len(shown.actions), SETTINGS.width)
    assert np.hypot(*shown.actions.T).max() <= 1.0 + 1e-4
