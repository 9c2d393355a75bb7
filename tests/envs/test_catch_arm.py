"""The single environment: physics, promises, Gymnasium's rules."""

import pickle
from dataclasses import replace

import numpy as np
import pytest

from gcm_learn import planners
from gcm_learn.motion.failures import Failure
from gcm_learn.motion.movement import Movement
from gcm_learn.motion.rules import rules_of
from gcm_learn.motion.timing import refine
from gcm_learn.motion.verification import clearance, verify
from gcm_learn.planners.completion import Problem
from gcm_learn.scene.packing import pack
from gcm_learn.situation.canonical import canonical
from tests.transforms import mirrored, turned

gymnasium = pytest.importorskip("gymnasium")
from gcm_learn.envs.catch_arm import CatchArm  # noqa: E402
from gcm_learn.execution.arena.kernels.hands.observation import ARM  # noqa: E402
from gcm_learn.execution.arena.kernels.hands.stepping import time_to_go  # noqa: E402


@pytest.fixture(scope="module")
def env(scenes):
    """Return an environment over the shared scenes."""
    return CatchArm(scenes)


def play(env, index, act, **options):
    """Play an episode; the observations, rewards and the last info."""
    observation, info = env.reset(options={"index": index, **options})
    seen, rewards = [observation], []
    for _ in range(1000):
        observation, reward, ended, late, info = env.step(act(observation, info))
        seen.append(observation)
        rewards.append(reward)
        if ended or late:
            return np.array(seen), np.array(rewards), info
    raise AssertionError("the horizon did not end the episode")


def to_target(observation, info):
    """Go straight to where the target can be met."""
    return observation[ARM + 14 : ARM + 16]


def fine(env):
    """Return the hand's way with as many samples as plans have."""
    way, arm = env.trajectory, env.situation.arm
    time, hand = refine(arm, *refine(arm, way.time, way.hand))  # wild actions pass the shoulder
    return Movement.of_hand(arm, time, hand)


@pytest.mark.parametrize("control", ["hand", "joint"])
def test_what_it_reports_is_what_the_verification_says(scenes, rng, control):
    """A catch is a verified plan, a touch touches where it ends and not before, else it is free."""
    env, outcomes = CatchArm(scenes, control=control), []
    for index in range(len(scenes)):
        for act in (to_target, lambda o, i: rng.uniform(-1, 1, 2)):
            _, _, info = play(env, index, act)
            way, situation = fine(env), env.situation
            scene = pack(situation)
            rules = rules_of(scene)
            targets = [i for i, b in enumerate(situation.bodies) if b.role == "target"]
            outcomes.append(info["outcome"])
            if info["outcome"] == "caught":
                assert any(verify(scene, rules, way, b).good for b in targets)
            else:
                free, when = clearance(situation, way)
                touched = free <= 1.01e-4  # what plans keep beyond "does not touch"
                assert touched == (info["outcome"] == "touched")
                if touched:
                    assert way.duration - env.settings.dt - 1e-9 <= when <= way.duration
                else:
                    assert way.duration == situation.horizon
    assert set(outcomes) == {"caught", "touched", "late"}


def test_straight_plans_are_caught_in_the_arena(env, scenes):
    """Following a straight plan catches when and where the plan does."""
    followed = 0
    for index, drawn in enumerate(scenes):
        situation, frame = canonical(drawn)
        plan = planners.solve(situation, "straight")
        if not plan.caught:
            continue
        speed, dt = situation.arm.max_hand_speed, env.settings.dt

        def act(observation, info, plan=plan, frame=frame, speed=speed, dt=dt):
            hand = frame.canonical(info["hand"])
            end = min(info["time"] + dt, plan.catch_time)  # the last step goes on beyond it
            move = (plan.trajectory.hand_at(end) - hand) / (speed * (end - info["time"]))
            c, s = hand / np.hypot(*hand)
            return np.array([c * move[0] + s * move[1], c * move[1] - s * move[0]])

        _, _, info = play(env, index, act)
        assert info["outcome"] == "caught"
        assert info["time"] == pytest.approx(plan.catch_time, abs=2e-3)
        followed += 1
    assert followed >= 5


@pytest.mark.parametrize("control", ["hand", "joint"])
def test_limits_hold_whatever_is_asked_for(scenes, rng, control):
    """Hand, joints and ring, with actions that are far too large."""
    env = CatchArm(scenes, control=control)
    for index in range(len(scenes)):
        play(env, index, lambda o, i: rng.normal(size=2) * 5.0)
        situation, way = env.situation, fine(env)
        free = replace(situation, bodies=situation.targets)
        problem = Problem(free, "limits")
        reason = verify(problem.scene, problem.rules, way, 0).reason
        assert reason is None or reason.failure is Failure.MISSED


def test_turned_and_mirrored_situations_look_the_same(scenes, rng):
    actions = rng.uniform(-1, 1, (200, 2))
    for scene in scenes[:8]:
        seen = []
        for situation in (scene, turned(scene, 1.1), mirrored(scene)):
            env, step = CatchArm(situation), iter(actions)
            observations, rewards, info = play(env, 0, lambda o, i, s=step: next(s))
            seen.append((observations, rewards, info["outcome"]))
        for other in seen[1:]:
            assert other[2] == seen[0][2]
            np.testing.assert_allclose(other[0], seen[0][0], atol=2e-4)
            np.testing.assert_allclose(other[1], seen[0][1], atol=1e-6)


def test_the_guide_adds_up_to_the_time_to_go(scenes, rng):
    env = CatchArm(scenes[:6], settings={"weights": {"guide": 2.0}, "discount": 0.97})
    for index in range(6):
        env.reset(options={"index": index})
        world, start = env.pool.world, env.situation.arm.hand[0]
        assert 0.0 <= world.fields[index].min() < 0.1 or np.all(world.fields[index] == 1.0)
        total, factor, over = 0.0, 1.0, False
        while not over:
            _, _, ended, late, info = env.step(rng.uniform(-1, 1, 2))
            total += factor * info["reward_terms"]["guide"]
            factor, over = 0.97 * factor, ended or late
        assert total == pytest.approx(2.0 * time_to_go(world, index, start, 0.0), abs=1e-9)


def test_time_to_go_leads_to_the_target_in_an_empty_world():
    """Without obstacles it is the way to the contact at the hand's speed."""
    from gcm_learn.execution.arena.guidance import field_of
    from gcm_learn.families import paper_scene

    scene = paper_scene("fig4")
    bare, _ = canonical(replace(scene, bodies=scene.targets))
    field = field_of(bare) * bare.horizon * bare.arm.max_hand_speed
    n = len(field)
    pitch = 2.0 * bare.arm.reach / n
    iy, ix = np.unravel_index(np.argmin(field), field.shape)
    cells = np.arange(n)
    away = pitch * np.hypot(*np.meshgrid(cells - ix, cells - iy))
    known = (field < 0.9 * bare.horizon * bare.arm.max_hand_speed) & (away > 3 * pitch)
    radius = pitch * np.hypot(*np.meshgrid(cells - n / 2 + 0.5, cells - n / 2 + 0.5))
    known &= radius < bare.arm.reach - 2 * pitch
    assert known.sum() > 200
    assert np.median(np.abs(field[known] / away[known] - 1.0)) < 0.1


@pytest.mark.parametrize(
    "imports", ["gcm_learn, gymnasium", "gymnasium, gcm_learn", "gcm_learn, importlib.util"]
)
def test_it_is_registered_whoever_comes_first(imports):
    """Also if somebody has asked where Gymnasium is."""
    import subprocess
    import sys

    code = f"import {imports}"
    code += "; importlib.util.find_spec('gymnasium')" if "importlib" in imports else ""
    code += "\nimport gymnasium as g; print(g.spec('CatchArm-v0').entry_point)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "gcm_learn.envs.catch_arm:CatchArm"


from gcm_learn.envs.vector import CatchArms  # noqa: E402


def test_ended_episodes_begin_anew(scenes, rng):
    arms = CatchArms(8, scenes)
    arms.reset(seed=0)
    ends = 0
    for _ in range(200):
        observations, _, ended, late, info = arms.step(rng.uniform(-1, 1, (8, 2)))
        over = ended | late
        assert ("final_obs" in info) == over.any()
        for e in np.flatnonzero(over):
            place = arms.plant.state.place[e]
            fresh, _ = CatchArm(arms.pool).reset(options={"index": int(place)})
            np.testing.assert_array_equal(observations[e], fresh)
            ends += 1
        if ends > 12:
            break
    assert ends > 12


def test_gymnasium_s_processes_hold_it(scenes):
    makers = [lambda: CatchArm(scenes[:3]) for _ in range(2)]
    several = gymnasium.vector.AsyncVectorEnv(makers, context="spawn")
    try:
        first, _ = several.reset(seed=[4, 5])
        own = [CatchArm(scenes[:3]).reset(seed=s)[0] for s in (4, 5)]
        np.testing.assert_array_equal(first, np.array(own))
        several.step(np.zeros((2, 2), np.float32))
    finally:
        several.close()


def test_threads_change_nothing(scenes, rng):
    """Whoever moves an arm, it moves the same; nor does it matter if the batch was pickled."""
    batches = [CatchArms(7, scenes, threads=n) for n in (1, 3)]
    batches.append(pickle.loads(pickle.dumps(batches[1])))
    for arms in batches:
        arms.reset(seed=3)
    for _ in range(60):
        action = rng.uniform(-1, 1, (7, 2))
        first, *others = [arms.step(action) for arms in batches]
        for other in others:
            for k in range(4):
                np.testing.assert_array_equal(first[k], other[k])
