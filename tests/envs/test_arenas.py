"""The promises of all arenas: rewards, Gymnasium's rules, batches equal to single arms."""

import json
import pickle
import re
import sys
import time
from dataclasses import replace

import numpy as np
import pytest

from gcm_learn import families
from gcm_learn.arms import CHAIN, PLANAR, SPATIAL
from gcm_learn.errors import ArenaError, ArmKindError, MissingExtraError, PhysicsError
from gcm_learn.execution import (
    ARENAS,
    ChainPhysicalSettings,
    ChainSettings,
    PhysicalSettings,
    Settings,
    SpatialSettings,
    arenas as table,
    pool_for,
    pool_of,
)
from gcm_learn.situation import arm_to_json, shipped_arm
from tests.refusals import refusal
from tests.worlds import solid_ball

gymnasium = pytest.importorskip("gymnasium")
from gcm_learn import envs  # noqa: E402

NAMES = ("CatchArm", "CatchArm3D", "CatchChain", "CatchArmPhysics", "CatchChainPhysics")
MANY = {
    "CatchArm": "CatchArms", "CatchArm3D": "CatchArms3D", "CatchChain": "CatchChains",
    "CatchArmPhysics": "CatchArmsPhysics", "CatchChainPhysics": "CatchChainsPhysics",
}  # fmt: skip
CLASSES = (Settings, SpatialSettings, ChainSettings, PhysicalSettings, ChainPhysicalSettings)
SETTINGS = dict(zip(NAMES, CLASSES, strict=True))
WIDTH = {
    "CatchArm": 107, "CatchArm3D": 145, "CatchChain": 206, "CatchArmPhysics": 145,
    "CatchChainPhysics": 206,
}  # fmt: skip
ACTION = np.array([0.3, -0.4, 0.2, 0.1, -0.2, 0.3, 0.1])
FAST = np.array([1.0, 0.5, -0.5, 1.0, 0.5, -0.5, 1.0])
TORQUE = {"control": "torque"}
GUIDE = {"weights": {"guide": 2.0}, "discount": 0.97}


@pytest.fixture(scope="module")
def with_bodies():
    """Return situations of arms that have a body."""
    return pool_of("crossing-swarm-space", 8, 0, PhysicalSettings())


@pytest.fixture(scope="module")
def pools(scenes, arms, chains, with_bodies):
    """Return a pool for each arena."""
    return {
        "CatchArm": pool_for(Settings(), scenes),
        "CatchArm3D": pool_for(SpatialSettings(), arms),
        "CatchChain": pool_for(ChainSettings(), chains),
        "CatchArmPhysics": with_bodies,
        "CatchChainPhysics": pool_for(ChainPhysicalSettings(), chains),
    }


@pytest.fixture(params=NAMES)
def name(request):
    """Return the name of an environment."""
    return request.param


@pytest.fixture
def pool(name, pools):
    """Return its pool."""
    return pools[name]


def one(name, situations, **options):
    """Return an environment with one arm."""
    return getattr(envs, name)(situations, **options)


def many(name, count, pool, **options):
    """Return an environment with many arms."""
    return getattr(envs, MANY[name])(count, pool, **options)


def played(env, index, act):
    """Play an episode; the rewards, their terms, and the last info."""
    observation, info = env.reset(options={"index": index})
    rewards, terms = [], []
    for _ in range(1000):
        observation, reward, ended, late, info = env.step(act(observation))
        assert env.observation_space.contains(observation)
        rewards.append(reward)
        terms.append(info["reward_terms"])
        if ended or late:
            return rewards, terms, info
    raise AssertionError("the horizon did not end the episode")


@pytest.mark.parametrize(
    ("name", "settings"), [*((name, {}) for name in NAMES), ("CatchArmPhysics", TORQUE)]
)
def test_an_episode_ends_with_what_it_is_rewarded_for(name, pool, settings):
    env, outcomes = one(name, pool, settings=settings), set()
    at = env.settings.straight
    for index in range(len(pool)):
        rewards, terms, info = played(env, index, lambda o: o[at : at + env.settings.commands])
        way = env.trajectory
        outcomes.add(info["outcome"])
        assert info["is_success"] == (info["outcome"] == "caught")
        assert sum(t["catch"] for t in terms) == float(info["is_success"])
        assert sum(t["touch"] for t in terms) == -float(info["outcome"] == "touched")
        haste = sum(t["haste"] for t in terms)
        assert haste == pytest.approx(-0.1 * info["time"] / env.situation.horizon, abs=1e-9)
        assert sum(rewards) == pytest.approx(sum(sum(t.values()) for t in terms))
        hand = env.frame.original(way.hand_at(way.duration))
        assert info["hand"] == pytest.approx(hand, abs=1e-9)
        if info["outcome"] != "late":
            assert way.duration == pytest.approx(info["time"])
    assert {"caught", "touched"} <= outcomes


def test_the_guide_adds_up_to_the_first_potential(name, pool):
    """Potential-based: whatever the arm does, the discounted sum is the potential of the start."""
    env = one(name, pool.part(range(4)), settings=GUIDE)
    rng, totals = np.random.default_rng(0), []
    for index in [0, 1, 2, 3] * 2:
        env.reset(options={"index": index})
        total, factor, over = 0.0, 1.0, False
        while not over:
            _, _, ended, late, info = env.step(rng.uniform(-1, 1, env.settings.commands))
            total += factor * info["reward_terms"]["guide"]
            factor, over = 0.97 * factor, ended or late
        totals.append(total)
    np.testing.assert_allclose(totals[:4], totals[4:], atol=1e-9)
    assert 0.01 < min(totals) <= max(totals) <= 2.0


CHOICES = [*((name, {}) for name in NAMES), ("CatchArm", {"fan": True}),
           ("CatchArm", {"control": "joint"}), ("CatchArmPhysics", TORQUE),
           ("CatchChainPhysics", TORQUE)]  # fmt: skip


@pytest.mark.parametrize(("name", "settings"), CHOICES)
def test_gymnasium_and_stable_baselines_accept_it(name, pool, settings):
    from gymnasium.utils.env_checker import check_env

    check_env(one(name, pool, render_mode="rgb_array", settings=settings))
    check = pytest.importorskip("stable_baselines3.common.env_checker")
    check.check_env(one(name, pool, settings=settings))


CHAINS = [("ur5", "throw-chain"), ("planar-2", "throw-chain"), ("ur5", "conveyor-chain")]


@pytest.mark.parametrize(("arm", "family"), CHAINS)
def test_families_are_drawn_with_the_arm(arm, family):
    """By name."""
    env = gymnasium.make("gcm_learn:CatchChain-v0", arm=arm, situations=family, pool=6)
    env.reset(seed=0)
    situations = env.unwrapped.pool.situations
    assert {s.arm.model.name for s in situations} == {shipped_arm(arm).name}


def test_presets_are_drawn():
    drawn = envs.CatchChain("panda-easy", pool=3).pool.situations
    assert {s.name[:18] for s in drawn} <= {f"panda-easy-000000{k}" for k in range(3)}
    cage = solid_ball("cage", (0.0, 0.0, 0.0), radius=9.0)
    blocked = [replace(s, bodies=(*s.bodies, cage)) for s in drawn]
    said = refusal(ArenaError, envs.CatchChain, blocked)
    assert said == "situations: in none of them an episode can begin"


DRAWN = [("CatchArm", None), ("CatchArm", "gate"), ("CatchArm3D", "space-sequences"),
         ("CatchChain", "panda-easy")]  # fmt: skip


@pytest.mark.parametrize(("name", "source"), DRAWN)
def test_what_a_reset_draws_is_what_is_drawn_ahead(name, source, rng):
    """In any order, and with the same observations."""
    settings, count = SETTINGS[name](), 7
    ahead = pool_of(source or ARENAS[f"{name}-v0"].family, count, 5, settings)
    made, known = one(name, source, pool=count, pool_seed=5), one(name, ahead)
    for index in (None, *rng.permutation(2 * count) % count):
        options = None if index is None else {"index": index}
        seen, info = made.reset(seed=3, options=options)
        same, told = known.reset(seed=3, options=options)
        np.testing.assert_array_equal(seen, same)
        np.testing.assert_array_equal(info["hand"], told["hand"])
        assert made.situation == known.situation
    assert made.pool.situations == ahead.situations


@pytest.mark.parametrize("name", ["CatchArm", "CatchArm3D", "CatchChain"])
def test_making_one_draws_no_more_than_a_reset_does(name, monkeypatch):
    drawn = []
    monkeypatch.setattr(table, "draw", lambda *asked: drawn.append(asked) or families.draw(*asked))
    made = one(name, None)
    assert len(drawn) <= 1
    for seed in (0, 1, 0):
        made.reset(seed=seed)
    assert len(drawn) <= 3
    made.reset(options={"situation": made.situation})
    assert len(drawn) <= 3


def test_a_blocked_situation_gives_place_to_the_next(monkeypatch):
    cage = solid_ball("cage", (0.0, 0.0, 0.0), radius=9.0)

    def sometimes(family, seed, index):
        made = families.draw("throw-chain", seed, index)
        return replace(made, bodies=(*made.bodies, cage)) if index in blocked else made

    monkeypatch.setattr(table, "draw", sometimes)
    blocked, names = {1, 2, 4}, []
    made = one("CatchChain", None, pool=5)
    for index in range(5):
        made.reset(options={"index": index})
        names.append(int(made.situation.name[-1]))
    assert names == [0, 3, 3, 3, 0]
    blocked = set(range(5))
    said = refusal(ArenaError, one, "CatchChain", None, pool=5)
    assert said == "situations: in none of them an episode can begin"


@pytest.mark.parametrize("prefix", ["gcm_learn:", "gcm_learn/", "gcm_learn:gcm_learn/"])
def test_make_knows_it(name, pool, prefix):
    made = gymnasium.make(f"{prefix}{name}-v0", situations=pool)
    assert made.reset(seed=0)[0].shape == (WIDTH[name],)
    arms = gymnasium.make_vec(
        f"{prefix}{name}-v0", num_envs=3, vectorization_mode="vector_entry_point",
        situations=pool,
    )  # fmt: skip
    assert type(arms.unwrapped) is getattr(envs, MANY[name])
    assert arms.reset(seed=1)[0].shape == (3, WIDTH[name])


GUIDED = {"weights": {"guide": 1.0}, "slots": 2}
BATCHES = [*((name, GUIDED, 12) for name in NAMES), ("CatchArm", {}, 90),
           ("CatchArm", {"control": "joint"}, 90),
           ("CatchArm", {"fan": True} | GUIDED, 90)]  # fmt: skip


@pytest.mark.parametrize(("name", "settings", "count"), BATCHES)
def test_batches_are_single_ones(name, pool, settings, count):
    n, ends = len(pool), 0
    arms, alone = many(name, n, pool, settings=settings), one(name, pool, settings=settings)
    first, _ = arms.reset(options={"index": np.arange(n)})
    rng, steps = np.random.default_rng(3), []
    actions = rng.uniform(-1.2, 1.2, (count, n, alone.settings.commands))
    for action in actions:
        steps.append(arms.step(action))
    for e in range(n):
        np.testing.assert_array_equal(alone.reset(options={"index": e})[0], first[e])
        for k, (seen, rewards, ended, late, info) in enumerate(steps):
            own = alone.step(actions[k, e])
            assert (rewards[e], ended[e], late[e]) == own[1:4]
            terms = {term: values[e] for term, values in info["reward_terms"].items()}
            assert terms == own[4]["reward_terms"]
            over = ended[e] or late[e]
            np.testing.assert_array_equal(info["final_obs"][e] if over else seen[e], own[0])
            if over:
                final = info["final_info"]
                assert info["_final_obs"][e] and final["index"][e] == e
                assert final["outcome"][e] == own[4]["outcome"]
                assert final["time"][e] == own[4]["time"]
                ends += 1
                break
    assert ends == n or count < 90


def test_seeds_and_pickles_give_the_same_episode(name, pool):
    env = one(name, pool)
    copy = pickle.loads(pickle.dumps(env))
    action = ACTION[: env.settings.commands]
    np.testing.assert_array_equal(env.reset(seed=3)[0], copy.reset(seed=3)[0])
    np.testing.assert_array_equal(env.step(action)[0], copy.step(action)[0])
    halfway = pickle.loads(pickle.dumps(env))
    np.testing.assert_array_equal(env.step(action)[0], halfway.step(action)[0])
    others = [env.reset(seed=k)[0] for k in range(8)]
    assert len({o.tobytes() for o in others}) > 3


def test_pictures_show_the_moment(name, pool):
    env = one(name, pool, render_mode="rgb_array")
    env.reset(seed=0)
    first = env.render()
    for _ in range(4):
        env.step(FAST[: env.settings.commands])
    second = env.render()
    assert first.shape == (480, 480, 3) and first.dtype == np.uint8
    assert 100 < (first != second).any(axis=2).sum() < 150_000
    env.close()


def test_a_situation_can_be_given(name, pool):
    env = one(name, pool.part([0, 1]))
    observation, _ = env.reset(options={"situation": pool.situations[3]})
    np.testing.assert_array_equal(observation, one(name, pool).reset(options={"index": 3})[0])
    for options, message in (
        ({"situation": 3}, "options.situation: must be a situation"),
        ({"speed": 3}, "options: 'speed' is not one of"),
        ({"index": 2}, "options.index: must be from 0 to 1"),
    ):
        assert message in refusal(ArenaError, env.reset, options=options)


BAD_ACTIONS = [
    (lambda n: np.full(n, np.nan), r"must be finite \(got \[nan, "),
    (lambda n: np.r_[np.zeros(n - 1), np.inf], r"must be finite \(got \[0\.0, .*inf\]"),
    (lambda n: np.zeros(n + 1), r"must have shape \(\d,\) \(got"),
    (lambda n: 0.5, r"must have shape \(\d,\) \(got \(\)\)"),
    (lambda n: ["a"] * n, r"must be numbers \(\d,\) \(got \['a'"),
    (lambda n: None, r"must have shape"),
]


def test_a_bad_action_is_an_error_and_changes_nothing(name, pool):
    env, fresh = one(name, pool), one(name, pool)
    action = np.full(SETTINGS[name]().commands, 0.3)
    for arm in (env, fresh):
        arm.reset(options={"index": 0})
    for made, message in BAD_ACTIONS:
        said = refusal(ArenaError, env.step, made(len(action)))
        assert re.match(rf"{name}\.step: the action {message}", said)
    np.testing.assert_array_equal(env.step(action)[0], fresh.step(action)[0])


def test_a_bad_action_of_one_arm_of_many_is_an_error(name, pool):
    arms = many(name, 3, pool)
    arms.reset(seed=0)
    actions = np.zeros((3, SETTINGS[name]().commands))
    actions[1, 0] = np.nan
    for given, words in ((actions, r"finite \(got \[nan, 0\.0"), (actions[:2], r"shape \(3, \d\)")):
        said = refusal(ArenaError, arms.step, given)
        assert re.match(rf"{MANY[name]}\.step: .* {words}", said)
    arms.step(np.full_like(actions, 1e200))  # large, but finite


@pytest.fixture
def pygame():
    """Return the library, which ends with the test."""
    pygame = pytest.importorskip("pygame")
    yield pygame
    pygame.quit()


def test_a_window_shows_what_arrays_do(name, pool, pygame, monkeypatch):
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
    env, arrays = (one(name, pool, render_mode=mode) for mode in ("human", "rgb_array"))
    action = FAST[: env.settings.commands]
    for arm in (env, arrays):
        arm.reset(seed=0)
        arm.step(action)
    assert env.render() is None
    shown = pygame.surfarray.array3d(pygame.display.get_surface()).swapaxes(0, 1)
    np.testing.assert_array_equal(shown, arrays.render())
    env.close()
    assert not pygame.display.get_init()
    env.reset(seed=1)  # opens another
    env.close()


def test_a_window_is_renewed_no_faster_than_said(pools, pygame, monkeypatch):
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
    env = one("CatchArm", pools["CatchArm"], render_mode="human")
    env.reset(seed=0)
    start = time.perf_counter()
    for _ in range(10):
        env.render()
    assert time.perf_counter() - start > 0.8 * 10 / env.metadata["render_fps"]
    env.close()


def test_a_window_without_a_display_or_pygame_is_an_error(name, pool, pygame, monkeypatch):
    for variable in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(variable, raising=False)
    for driver in ("", "no such driver"):
        monkeypatch.setenv("SDL_VIDEODRIVER", driver)
        said = refusal(ArenaError, one(name, pool, render_mode="human").reset, seed=0)
        assert said.startswith("render_mode: 'human' needs a display (") and "'rgb_arr" in said
    monkeypatch.setitem(sys.modules, "pygame", None)
    said = refusal(MissingExtraError, one(name, pool, render_mode="human").reset, seed=0)
    assert "pygame: pip install 'gcm_learn[render]'" in said


def test_gymnasium_s_own_vectors_hold_it(name, pool):
    arms = gymnasium.make_vec(
        f"gcm_learn:{name}-v0", num_envs=2, vectorization_mode="sync", situations=pool
    )
    first = arms.reset(seed=5)[0]
    action = np.full((2, SETTINGS[name]().commands), 0.2, np.float32)
    seen, *_ = arms.step(action)
    arms.close()
    for e in range(2):
        own = one(name, pool)
        np.testing.assert_array_equal(own.reset(seed=5 + e)[0], first[e])
        np.testing.assert_array_equal(own.step(action[e])[0], seen[e])


REFUSALS = [
    ("CatchArm", {"control": "mind"}, "control: 'mind' is not one of hand, joint"),
    ("CatchArm", {"settings": {"speed": 1}}, "settings: 'speed' is not a known field"),
    ("CatchArm", {"body": "human"}, "body: arms of this arena have no mass"),
    ("CatchArm3D", {"control": "hand"}, "settings: 'control' is not a known field"),
    ("CatchArm3D", {"settings": 3}, "settings: must be SpatialSettings (got int)"),
    ("CatchArm3D", {"body": "human"}, "body: arms of this arena have no mass"),
    ("CatchChain", {"fan": True}, "fan: chains have none"),
    ("CatchChain", {"arm": "pandy"}, 'arm: "pandy" is not the name of an arm'),
    ("CatchChain", {"body": "human"}, "body: arms of this arena have no mass"),
    ("CatchArm3D", {"arm": "panda"}, "settings: 'arm' is not a known field"),
    ("CatchArmPhysics", {"control": "hand"}, "control: 'hand' is not one of joint, torque"),
    ("CatchArmPhysics", {"settings": {"dt": 0.005}}, "dt: must be whole steps of physics"),
    ("CatchChainPhysics", {"control": "hand"}, "control: 'hand' is not one of joint, torque"),
    *((name, arguments, message) for name in NAMES for arguments, message in (
        ({"situations": "nowhere"}, "situations: 'nowhere' is no file, folder or family"),
        ({"settings": {"dt": 0.0}}, "dt: must be from 0.0001 to 1 s (got 0.0)"),
        ({"settings": {"weights": {"joy": 1}}}, "settings.weights: 'joy'"),
        ({"render_mode": "ascii"}, "render_mode: 'ascii'"),
    )),
]  # fmt: skip


@pytest.mark.parametrize(("name", "arguments", "message"), REFUSALS)
def test_bad_arguments_are_refused_in_one_line(name, arguments, message):
    assert message in refusal(ArenaError, getattr(envs, name), **{"pool": 2, **arguments})


def test_bad_batches_are_refused(name, pool, with_bodies):
    for arguments, message in (
        ({"num_envs": 0}, "num_envs: must be at least 1 (got 0)"),
        ({"threads": 0}, "threads: must be at least 1 (got 0)"),
        ({"render_mode": "human"}, "render_mode: many arms are not drawn"),
    ):
        given = {"num_envs": 2, "situations": pool, **arguments}
        assert message in refusal(ArenaError, getattr(envs, MANY[name]), **given)
    said = refusal(ArenaError, many(name, 2, pool).reset, options={"index": [0, 10_000]})
    assert "options.index: must be 2 numbers" in said
    said = refusal(ArenaError, many, "CatchArmPhysics", 2, with_bodies, threads=2)
    assert "threads: arms with mass move one after the other" in said


def test_arms_of_the_other_kind_are_refused_in_one_line(name, pool, pools):
    kind = SETTINGS[name].kind
    other = {PLANAR: "CatchArm3D", SPATIAL: "CatchArm", CHAIN: "CatchArm3D"}[kind]
    family, situation = SETTINGS[other].kind.name, pools[other].situations[0]
    source = {"planar": "random-planar", "spatial": "static-clutter-space"}[family]
    for call in (
        lambda: getattr(envs, name)(source, pool=2),
        lambda: many(name, 2, [situation]),
        lambda: one(name, pools[other]),
        lambda: one(name, pool).reset(options={"situation": situation}),
    ):
        assert f"does not take {family} arms" in refusal(ArmKindError, call)


def test_arms_without_a_body_are_refused_in_one_line(with_bodies, arms):
    drawn = [families.draw("static-clutter-space", 1, k) for k in range(40)]
    mixed = next(s for s in drawn if s.arm.upper_arm[0] not in (1.0, 0.105))
    for call in (
        lambda: envs.CatchArmPhysics([mixed]),
        lambda: envs.CatchArmPhysics(with_bodies).reset(options={"situation": mixed}),
    ):
        said = refusal(PhysicsError, call)
        assert "none that is shipped fits the arm" in said and mixed.name in said
    said = refusal(ArenaError, envs.CatchArmPhysics, pool_for(SpatialSettings(), arms))
    assert "the arms of the pool have no bodies" in said


def test_the_body_may_be_chosen(with_bodies):
    pairs = zip(with_bodies.situations, with_bodies.bodies, strict=True)
    humans = [s for s, b in pairs if b.name == "human"]
    env = envs.CatchArmPhysics(humans, body="human")
    assert {body.name for body in env.pool.bodies} == {"human"}
    said = refusal(PhysicsError, envs.CatchArmPhysics, humans, body="nao")
    assert "body nao: does not fit" in said


def test_any_arm_file_with_a_body_moves_in_physics(tmp_path):
    """An arm of two joints from files; without its body it is refused in one line."""
    arm, body = tmp_path / "arm.json", tmp_path / "body.json"
    arm.write_text(json.dumps(arm_to_json(shipped_arm("planar-2"))), "utf-8")
    inertia = [[0.001, 0, 0], [0, 0.02, 0], [0, 0, 0.02]]
    link = {"mass": 1.0, "centre": [0.2, 0, 0], "inertia": inertia}
    made = {"format": "gcm-learn/body@2", "metres": 1.0, "gravity": [0, 0, -9.81]}
    made |= {"frames": [link] * 3, "joints": [{"torque": 9.0, "armature": 0.01}] * 2}
    body.write_text(json.dumps(made), "utf-8")
    name, drawn = "gcm_learn:CatchChainPhysics-v0", {"situations": "throw-chain", "pool": 3}
    env = gymnasium.make(name, arm=arm, body=body, **drawn)
    observation, _ = env.reset(seed=0)
    assert env.action_space.shape == (2,)
    assert observation.shape == (7 * 2 + 4 * len(shipped_arm("planar-2").links) + 121,)
    assert len(env.step(env.action_space.sample())[0]) == len(observation)
    said = refusal(PhysicsError, gymnasium.make, name, arm=arm, **drawn)
    assert "none that is shipped fits the arm" in said


def test_without_mujoco_the_extra_is_named(monkeypatch, with_bodies):
    monkeypatch.setitem(sys.modules, "mujoco", None)
    assert "sim" in refusal(MissingExtraError, envs.CatchArmPhysics(with_bodies).reset, seed=0)


@pytest.mark.parametrize(
    ("mass", "none"), [("CatchArmPhysics", "CatchArm3D"), ("CatchChainPhysics", "CatchChain")]
)
def test_mass_is_all_that_sets_the_arenas_apart(mass, none, pools):
    """The same first observation, and nearly the same way for a slow command."""
    physical = one(mass, pools[mass])
    kinematic, dof = one(none, list(physical.pool.situations)), physical.settings.commands
    for index in range(4):
        told = [env.reset(options={"index": index})[0] for env in (physical, kinematic)]
        np.testing.assert_array_equal(told[0], told[1])
        for _ in range(3):
            for env in (physical, kinematic):
                env.step(np.full(dof, 0.05))
        apart = physical.plant.posture[0, :dof] - kinematic.plant.posture[0, :dof]
        assert 0.0 < np.abs(apart).max() < 0.02
