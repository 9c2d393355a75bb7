"""Policies for arms in space: plans of training, learners, actors."""

from __future__ import annotations

import pickle
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from gcm_learn import execution, families, solve
from gcm_learn.arms import SPATIAL
from gcm_learn.errors import ArmKindError, FileFormatError, PolicyError
from gcm_learn.policies import Actor, ActorPlanner, plan_of, read_plan, shipped_actor
from gcm_learn.policies.actor import file_of
from gcm_learn.policies.directions import STEER, choices_in, choices_of, chosen, moved, said
from gcm_learn.scene import later
from tests.execution.loop.test_closed_loop import Watched
from tests.policies.conftest import leaning_in_space, straight_in_space
from tests.refusals import refusal

pytestmark = pytest.mark.slow
CONFIGS = Path(__file__).parents[2] / "experiments" / "04_policies"
FAMILY = "crossing-swarm-space"


STEPS = {"n_timesteps": 256, "n_envs": 8, "batch_size": 64, "evaluate_every": 128}
LEARNED = {
    "ppo": STEPS | {"n_steps": 16, "log_std_init": -1.0},
    "sac": STEPS | {"learning_starts": 50, "buffer_size": 1000},
    "clone": {"epochs": 60, "batch": 64},
}


def entry(algo="ppo", **more):
    """Return the entry of a small run."""
    shares = {"situations": {"count": 6}, "validation": {"count": 4, "seed": 1}}
    sources = {name: [{"source": FAMILY, **share}] for name, share in shares.items()}
    return {"algo": algo, "net_arch": "16"} | sources | LEARNED[algo] | more


def fanned(count=6):
    """Return what some arms in space are told at their start, with the fan, and the settings."""
    settings = execution.SpatialSettings(fan=True)
    plant = execution.plant_of(
        execution.pool_of(FAMILY, count, 0, execution.SpatialSettings()), count, settings
    )
    plant.put(np.arange(count), np.arange(count))
    return settings, plant.observations.copy()


def test_shipped_configurations_are_plans():
    found = [*CONFIGS.glob("*-space.yml"), *CONFIGS.glob("*-physics.yml")]
    assert len(found) > 1
    for path in found:
        plan = read_plan(path)
        assert plan.kind is SPATIAL and (plan.actions == "velocity" or choices_in(plan.settings))


def test_the_first_choice_goes_straight():
    """So whoever always chooses it does what the straight command does."""
    settings, told = fanned()
    first = chosen(settings, told, np.zeros(len(told), np.int64))
    np.testing.assert_array_equal(first, told[:, execution.AIM : execution.AIM + 4])
    pool = execution.pool_of(FAMILY, 20, 0, execution.SpatialSettings())
    actors = straight_in_space(), leaning_in_space()
    straight, choosing = (actor.play(pool, np.arange(20)) for actor in actors)
    np.testing.assert_array_equal(straight.outcomes, choosing.outcomes)
    np.testing.assert_allclose(straight.posture, choosing.posture)


def test_choices_in_space_are_found_again(rng):
    settings, told = fanned()
    for ray in range(execution.COMMANDS):
        choices = np.full(len(told), ray)
        actions = chosen(settings, told, choices)
        near = actions + rng.normal(size=actions.shape) * 1e-3
        np.testing.assert_array_equal(choices_of(settings, told, near), choices)


def test_with_a_fan_differences_are_in_its_frame(rng):
    settings, told = fanned()
    straight = told[:, execution.AIM : execution.AIM + 4]
    np.testing.assert_allclose(moved(settings, told, np.zeros((len(told), 4))), straight)
    back = np.tile([-0.2, 0.0, 0.0, 0.0], (len(told), 1))
    sizes = np.linalg.norm(straight, axis=1)[:, None]
    slower = moved(settings, told, back)
    np.testing.assert_allclose(slower, straight * (1.0 - 0.2 * STEER / sizes), atol=1e-5)
    commands = np.clip(straight + rng.uniform(-0.9, 0.9, straight.shape), -1.0, 1.0)
    again = moved(settings, told, said(settings, told, commands))
    np.testing.assert_allclose(again, commands, atol=1e-5)


FAN, PHYSICS = "choices in space need a fan", "CatchArmPhysics-v0"
BAD = [
    ({"actions": "choice"}, "CatchArm3D-v0", FAN),
    ({"actions": "choice", "settings": {"control": "torque", "fan": True}}, PHYSICS, FAN),
    ({"algo": "clone"}, PHYSICS, "there are no demonstrations of arms with mass"),
]
FILES = [
    ("Pendulum-v1: {}\n", "'Pendulum-v1' is not one of CatchArm-v0, CatchArm3D-v0"),
    (
        "CatchArm3D-v0: {algo: ppo, settings: {embedding: true}}\n",
        "CatchArm3D-v0.settings: 'embedding' is not a known",
    ),
]


def test_bad_plans_are_refused_in_one_line(tmp_path):
    for change, environment, words in BAD:
        assert words in refusal(PolicyError, plan_of, entry(**change), environment)
    for text, words in FILES:
        (tmp_path / "other.yml").write_text(text)
        assert words in refusal(FileFormatError, read_plan, tmp_path / "other.yml")
    pytest.importorskip("stable_baselines3")
    from gcm_learn.policies import train

    plan = plan_of(entry(situations=[{"source": "random-planar", "count": 2}]), "CatchArm3D-v0")
    said = refusal(ArmKindError, train, plan, tmp_path, lambda text: None)
    assert "does not take planar arms" in said


def test_actions_are_differences_from_the_straight_way():
    told = np.zeros((2, 145), np.float32)
    told[:, execution.AIM : execution.AIM + 4] = [1.0, -0.5, 0.25, 0.0]
    settings = execution.SpatialSettings()
    still = moved(settings, told, np.zeros((2, 4)))
    np.testing.assert_allclose(still, told[:, execution.AIM : execution.AIM + 4])
    other = moved(settings, told, np.array([[-0.5, 0.0, 0.0, 1.0]] * 2))
    np.testing.assert_allclose(other[0], [1.0 - 0.5 * STEER, -0.5, 0.25, 1.0])
    commands = np.array([[0.5, 0.5, -0.5, 0.9]] * 2)
    again = moved(settings, told, said(settings, told, commands))
    np.testing.assert_allclose(again, commands, atol=1e-6)


def test_an_actor_is_kept_and_acts(tmp_path):
    pool = execution.pool_of(FAMILY, 30, 0, execution.SpatialSettings())
    actor = straight_in_space()
    actor.save(tmp_path)
    assert (tmp_path / file_of(actor.settings)).exists()
    back = Actor.load(tmp_path)
    assert back.kind is SPATIAL and back.settings == actor.settings
    first, second = (a.play(pool, np.arange(len(pool))) for a in (actor, back))
    np.testing.assert_array_equal(first.posture, second.posture)
    assert (first.outcomes == execution.CAUGHT).any()
    drawn = [back.play(pool, np.arange(4), np.random.default_rng(k)).times for k in (1, 1, 2)]
    np.testing.assert_array_equal(drawn[0], drawn[1])
    assert (drawn[0] != drawn[2]).any()


CHAINS = "throw-chain"
LEARNERS = [
    ("ppo", "CatchArm3D-v0", {}),
    ("ppo", "CatchArm3D-v0", {"fan": True}),
    ("sac", "CatchArm3D-v0", {"fan": True}),
    ("ppo", "CatchArmPhysics-v0", {"fan": True}),
    ("ppo", "CatchChain-v0", {"arm": "planar-2"}),
    ("sac", "CatchArmPhysics-v0", {"control": "torque"}),
]


@pytest.mark.parametrize(("algo", "environment", "settings"), LEARNERS)
def test_learners_run_and_go_on(tmp_path, monkeypatch, algo, environment, settings):
    pytest.importorskip("stable_baselines3")
    cloudpickle = pytest.importorskip("cloudpickle")
    from gcm_learn.policies import train

    given = entry(algo, settings={"weights": {"guide": 1.0}, **settings})
    if "fan" in settings and algo == "ppo":
        given |= {"actions": "choice"}
        given.pop("log_std_init")
    if "arm" in settings:
        given |= {key: [{"source": CHAINS, "count": 4}] for key in ("situations", "validation")}
    plan = plan_of(given, environment)
    scores = train(plan, tmp_path / "made", lambda text: None)
    assert 0.0 <= scores["caught"] <= 1.0
    actor = Actor.load(tmp_path / "made")
    assert actor.kind is plan.kind and actor.settings.weights.guide == 0.0
    assert type(actor.settings) is type(plan.settings)
    assert file_of(actor.settings) in (tmp_path / "made" / "card.md").read_text("utf-8")
    more = plan_of(given | {"n_timesteps": 384}, environment)
    monkeypatch.setattr(pickle, "load", None)  # nothing is unpickled
    monkeypatch.setattr(cloudpickle, "loads", None)
    train(more, tmp_path / "made", lambda text: None)
    log = (tmp_path / "made" / "log.jsonl").read_text("utf-8").splitlines()
    assert len(log) >= 4


@pytest.mark.parametrize("algo", ["ppo", "sac"])
def test_a_learner_goes_on_as_it_was(tmp_path, algo):
    pytest.importorskip("stable_baselines3")
    from gcm_learn.policies import reinforcement

    plan = plan_of(entry(algo), "CatchArm3D-v0")
    pool = execution.pool_of(FAMILY, 6, 0, plan.settings)
    model = reinforcement.make(plan, pool, tmp_path / "tensorboard")
    model.learn(200)
    reinforcement.keep(model, tmp_path)
    again = reinforcement.go_on(plan, pool, tmp_path)
    assert again.num_timesteps == model.num_timesteps and again._n_updates == model._n_updates
    np.testing.assert_array_equal(again.get_env().obs_rms.var, model.get_env().obs_rms.var)
    states = again.get_parameters()
    for part, kept in model.get_parameters().items():
        assert str(states[part]) == str(kept)
    if algo == "sac":
        assert again.log_ent_coef.item() == model.log_ent_coef.item() != 0.0
        mine, kept = again.replay_buffer, model.replay_buffer
        assert (mine.size(), mine.pos) == (kept.size(), kept.pos)
        np.testing.assert_array_equal(mine.next_observations, kept.next_observations)
    actors = [reinforcement.actor_of(made, plan) for made in (model, again)]
    told = np.linspace(-1.0, 1.0, 145)[None]
    np.testing.assert_array_equal(*(actor.act(told) for actor in actors))
    (tmp_path / "normalisation.pkl").write_bytes(b"")
    with pytest.raises(PolicyError, match=r"normalisation.pkl: pickles are not read"):
        reinforcement.go_on(plan, pool, tmp_path)


def test_policies_of_torques_differ_from_the_torques_that_go_straight():
    pytest.importorskip("mujoco")
    from gcm_learn.policies import ArenaVecEnv

    settings = execution.PhysicalSettings(control="torque")
    pool = execution.pool_of("crossing-swarm-space", 3, 0, settings)
    env, arms = (
        ArenaVecEnv(execution.PhysicalArms(pool, 3, settings), actions="velocity"),
        execution.PhysicalArms(pool, 3, settings),
    )
    told = env.reset()
    places = env.plant.state.place.copy()
    arms.put(np.arange(3), places)
    env.step(np.zeros((3, 4), np.float32))
    arms.move(told[:, -4:].astype(float))
    np.testing.assert_array_equal(env.plant.posture, arms.posture)


def test_clones_learn_the_difference_from_the_straight_way(tmp_path):
    """What is shown is done nearly so, told of the same."""
    pytest.importorskip("torch")
    from gcm_learn.policies import train

    said: list[str] = []
    train(plan_of(entry("clone", net_arch="64"), "CatchArm3D-v0"), tmp_path, said.append)
    losses = [float(line.split("loss ")[1].split()[0]) for line in said if "loss" in line]
    assert losses[-1] < 0.5 * losses[0]
    assert any("catches" in line for line in said) and not any("maps" in line for line in said)
    assert Actor.load(tmp_path).kind is SPATIAL


def test_an_actor_plans_where_it_catches(tmp_path):
    """What it would do is tried out and verified; arms in the plane are refused."""
    pool = execution.pool_of(FAMILY, 30, 0, execution.SpatialSettings())
    actor = straight_in_space()
    caught = actor.play(pool, np.arange(len(pool))).outcomes == execution.CAUGHT
    planner = ActorPlanner(actor, "tried", tries=1)
    plans = [planner.plan(situation) for situation in pool.situations[:10]]
    assert [plan.caught for plan in plans] == caught[:10].tolist()
    more = ActorPlanner(replace(actor, spread=np.full(4, -2.0)), "tried", tries=6)
    found = [more.plan(situation).caught for situation in pool.situations[:10]]
    assert all(now or not before for now, before in zip(found, caught[:10], strict=True))
    with pytest.raises(ArmKindError, match="does not take planar arms"):
        planner.plan(families.draw("random-planar", 3, 0))


@pytest.mark.parametrize("shipped", [False, True])
@pytest.mark.parametrize("family", ["falling-space", "door-space", "pendulum-space"])
def test_in_the_closed_loop_it_acts_as_in_the_arena(family, shipped):
    """With exact looks and no time to think: as in the world that there is after two looks."""
    config = families.get_family(family)
    config = replace(config, arm=replace(config.arm, human=1.0, ramp=(0.1, 0.1)))
    weights = np.random.default_rng(0).standard_normal((4, 145)).astype(np.float32)
    actor = replace(straight_in_space(), layers=((0.01 * weights, np.zeros(4, np.float32)),))
    actor = shipped_actor("ppo-space") if shipped else actor
    compared = 0
    for k in range(8):
        situation = families.draw(config, 11, k)
        plant = Watched(situation)
        loop = execution.Loop(execution.Perception(), 2, thinking=0.0)
        course = execution.run_closed_loop(actor.mind(), plant, situation, loop, 0)
        if course.time < 0.1:
            continue
        arm = situation.arm
        seen = later(situation, 0.04, joints=arm.joints, rates=arm.joint_rates)
        arena = actor.play(execution.pool_for(actor.settings, [seen]), np.zeros(1, int))
        assert arena.outcomes[0] == course.outcome != execution.RUNNING
        time, posture = arena.path(0)
        rows = {round(row[0], 6): row[1:] for row in plant.rows[:-1]}
        for t, there in zip(time[1:-1], posture[1:-1], strict=True):
            np.testing.assert_allclose(rows[round(0.04 + t, 6)], there, atol=1e-5)
        compared += len(time) > 3
    assert compared >= 3


def test_only_actors_that_lead_joints_of_arms_in_space_take_part_in_the_closed_loop():
    actor = straight_in_space()
    torque, planar = execution.PhysicalSettings(control="torque"), execution.Settings()
    for error, settings, words in (
        (PolicyError, torque, "commands torques of motors"),
        (ArmKindError, planar, "the closed loop does not take planar arms"),
    ):
        assert words in refusal(error, replace(actor, settings=settings).mind)
    assert replace(actor, settings=execution.PhysicalSettings()).mind().settings.width == 145


def test_situations_that_another_planner_catches_are_chosen(tmp_path):
    from gcm_learn.policies.plan import Share
    from gcm_learn.policies.situations import gather

    shares = [Share(FAMILY, 12, caught_by=name) for name in ("straight", "")]
    easy, every = (
        gather([share], plans=False, settings=execution.SpatialSettings()) for share in shares
    )
    assert 0 < len(easy.situations) < len(every.situations) == 12
    assert all(solve(situation, "straight").caught for situation in easy.situations)


def test_catches_out_of_memory_are_shown(monkeypatch):
    from gcm_learn.policies import situations
    from gcm_learn.policies.plan import Share

    asked = []

    def spied(name, real=situations.get_planner):
        asked.append(name)
        return real(name)

    monkeypatch.setattr(situations, "get_planner", spied)
    share = Share(FAMILY, 4, reachable=True, shown_by="recall")
    lot = situations.gather([share], plans=True, settings=execution.SpatialSettings())
    assert asked == ["search", "recall"] and any(path is not None for path in lot.paths)
    for situation, path in zip(lot.situations, lot.paths, strict=True):
        recalled = solve(situation, "recall").trajectory
        assert (path is None) == (recalled is None)
        assert path is None or np.array_equal(path.joints, recalled.joints)


def test_the_shipped_actor_catches_where_the_straight_command_does_not():
    """Of situations that it has not seen; it learned from them with the seeds 0 and 1."""
    actor, won, lost = shipped_actor("ppo-space"), 0, 0
    for name in ("behind-post-space", "door-space", "pendulum-space"):
        pool = execution.pool_of(name, 15, 2, execution.SpatialSettings())
        places = np.arange(len(pool))
        mine, straight = (
            a.play(pool, places).outcomes == execution.CAUGHT for a in (actor, leaning_in_space())
        )
        won, lost = won + np.sum(mine & ~straight), lost + np.sum(straight & ~mine)
    assert won > 10 and won > 4 * lost
