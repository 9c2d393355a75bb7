"""Plants of joints: what they report is verified, limits hold, batches are single arms."""

from dataclasses import replace

import numpy as np
import pytest

from gcm_learn import execution
from gcm_learn.arms import CHAIN, SPATIAL, ByKind, hands_along, kind_of
from gcm_learn.motion.failures import Failure
from gcm_learn.motion.rules import opening
from gcm_learn.motion.verification import verify
from gcm_learn.planners import Attempt, JointProblem, checked, get_planner
from gcm_learn.scene.packing import pack
from gcm_learn.situation import shipped_arm
from tests.execution.conftest import Straight, begun, good
from tests.judging import judge
from tests.worlds import solid_ball

SETTINGS = ByKind({SPATIAL: execution.SpatialSettings(), CHAIN: execution.ChainSettings()})


@pytest.fixture(params=["spatial", "chain"])
def some(request, arms, chains):
    """Return situations of one kind of arm."""
    return {"spatial": arms, "chain": chains}[request.param]


class Wild:
    """Asks for what is far too much, now and then for the same thing for a while."""

    def __init__(self, rng):
        self._rng, self._kept = rng, None

    def act(self, moment):
        shape = (len(moment.time), moment.posture.shape[1] // 2)
        if self._kept is None or self._rng.random() < 0.3:
            self._kept = self._rng.normal(size=shape) * 3.0
        return self._kept


def played(situations, agent, settings=None):
    """Return a plant and what came of one episode in each situation."""
    pool = execution.Pool.of(situations)
    plant = execution.KinematicPlant(pool, len(pool), settings or SETTINGS.of(pool.kind))
    return plant, execution.run_episode(agent, plant, np.arange(len(pool)))


@pytest.mark.parametrize("wild", [False, True], ids=["aiming", "wild"])
def test_what_it_reports_is_what_the_verification_says(some, rng, wild):
    """A catch is a verified plan; a touch is one where it ends, and nothing is before."""
    agent = Wild(rng) if wild else Straight(SETTINGS.of(some[0]))
    _, episodes = played(some, agent)
    for e, situation in enumerate(some):
        scene = pack(situation)
        rules = opening(scene).rules
        time, posture = episodes.path(e)
        way = execution.way_of(situation.arm, time, posture)
        targets = [k for k, b in enumerate(situation.bodies) if b.role == "target"]
        verdicts = [verify(scene, rules, way, k) for k in targets]
        outcome = episodes.outcomes[e]
        assert (outcome == execution.CAUGHT) == any(v.good for v in verdicts)
        if outcome == execution.CAUGHT:
            continue
        # without its obstacles the way keeps every promise but the catch
        bare = without_obstacles(situation)
        if kind_of(situation) is CHAIN and outcome == execution.COLLIDED:
            continue  # it may touch itself
        kept = verify(pack(bare), rules, way, 0)
        assert kept.reason is not None and kept.reason.failure is Failure.MISSED
        assert (outcome == execution.LATE) == (
            way.duration == situation.horizon and outcome != execution.COLLIDED
        )
        held = clearance_until(scene, rules, way, way.duration)
        assert (held <= rules.touch) == (outcome == execution.COLLIDED)
        if outcome == execution.COLLIDED and len(time) > 2:
            before = execution.way_of(situation.arm, time[:-1], posture[:-1])
            assert clearance_until(scene, rules, before, before.duration) > rules.touch
    found = set(episodes.outcomes.tolist())
    assert (
        execution.COLLIDED in found
        and (execution.CAUGHT in found or wild)
        and (execution.LATE in found or not wild)
    )


def clearance_until(scene, rules, way, end):
    """Return the least distance of bones and obstacles over a way, as the verification finds it."""
    from gcm_learn.arms.curves import hermite, line
    from gcm_learn.collision.postures import desk_of, least_on

    desk, best = desk_of(scene), 1e300
    for k in range(len(way.time) - 1):
        q, p, since, until = way.joints[k], way.joints[k + 1], way.time[k], way.time[k + 1]
        if way.rates is None:
            line(q, p, desk.curve)
        else:
            hermite(q, way.rates[k], p, way.rates[k + 1], until - since, desk.curve)
        best = min(best, least_on(scene, since, until, rules.touch, 1e-4, 1e300, desk)[0])
    return best


def without_obstacles(situation):
    """Return a situation without what the limb must not touch."""
    ignoring = {"ignore": ()} if kind_of(situation) is CHAIN else {}
    return replace(situation, bodies=situation.targets, arm=replace(situation.arm, **ignoring))


def test_ranges_and_accelerations_hold_whatever_is_asked_for(some, rng):
    """Seen from outside: samples of the joints on the curves that are told."""
    _, episodes = played(some, Wild(rng))
    stopped, limited = 0, 0
    for e, situation in enumerate(some):
        arm = situation.arm
        time, posture = episodes.path(e)
        way = execution.way_of(arm, time, posture)
        if way.duration == 0.0:
            continue
        fine = np.linspace(0.0, way.duration, 3000)
        joints = way.joints_at(fine)
        low, high = np.array(arm.joint_range).T
        assert (joints >= low - 1e-7).all() and (joints <= high + 1e-7).all()
        stopped += ((joints <= low + 1e-9) | (joints >= high - 1e-9)).any()
        rates = np.diff(joints, axis=0) / np.diff(fine)[:, None]
        assert (np.abs(rates) <= np.array(arm.max_joint_speed) * (1.0 + 1e-6)).all()
        if arm.max_hand_speed is not None:
            steps = np.linalg.norm(np.diff(way.hand_at(fine), axis=0), axis=1)
            assert (steps <= arm.max_hand_speed * np.diff(fine) * (1.0 + 1e-6)).all()
        if arm.max_joint_acceleration is not None:
            limited += 1
            bends = np.diff(way.rates, axis=0) / np.diff(way.time)[:, None]
            assert (np.abs(bends) <= np.array(arm.max_joint_acceleration) * (1 + 1e-7)).all()
    assert limited > 3 and (stopped > 3 or kind_of(some[0]) is CHAIN)


def test_joints_that_brake_come_to_rest_at_the_end_of_their_range(arms):
    """Full speed ahead with limits of acceleration: it gets there, and no farther."""
    slow = [s for s in arms if s.arm.max_joint_acceleration is not None]
    free = [replace(s, bodies=(far_target(s.arm),), horizon=6.0) for s in slow]
    assert all(map(good, free))

    class Ahead:
        def act(self, moment):
            return np.tile([1.0, -1.0, 1.0, 1.0], (len(moment.time), 1))

    _, episodes = played(free, Ahead())
    for e, situation in enumerate(free):
        _, posture = episodes.path(e)
        low, high = np.array(situation.arm.joint_range).T
        ends = np.array([high[0], low[1], high[2], high[3]])
        np.testing.assert_allclose(posture[-1, :4], ends, atol=1e-6)
        np.testing.assert_allclose(posture[-1, 4:], 0.0, atol=1e-6)


def far_target(arm):
    """Return a resting target that the arm cannot reach."""
    place = np.array(arm.base.origin) + [9.0 * arm.reach, 0.0, 0.0]
    return solid_ball("far", place, role="target", radius=0.1 * arm.reach)


def test_joints_go_where_they_are_told(arms):
    """Where nothing limits it, a command of 0.5 turns every joint half as fast as it can."""
    quick = [s for s in arms if s.arm.max_joint_acceleration is None][:6]
    free = [replace(s, bodies=(far_target(s.arm),)) for s in quick]
    free = [replace(s, arm=replace(s.arm, max_hand_speed=None)) for s in free]
    plant = begun(execution.Pool.of(free), execution.SpatialSettings())
    plant.move(np.full((len(free), 4), 0.01))
    for e, situation in enumerate(free):
        arm = situation.arm
        low, high = np.array(arm.joint_range).T
        turned = np.array(arm.joints) + 0.01 * 0.02 * np.array(arm.max_joint_speed)
        np.testing.assert_allclose(plant.posture[e, :4], np.clip(turned, low, high), rtol=1e-8)


def test_many_arms_are_single_ones(some, rng):
    """Whatever the batch and the threads."""
    settings, pool = SETTINGS.of(some[0]), execution.Pool.of(some)
    many, alone = begun(pool, settings, threads=3), execution.KinematicPlant(pool, 1, settings)
    commands = rng.uniform(-1.5, 1.5, (15, len(pool), settings.commands))
    told, outcomes = [], []
    for command in commands:
        outcomes.append(many.move(command).copy())
        told.append(many.observations.copy())
    for e in range(len(pool)):
        alone.put(np.zeros(1, np.int64), np.array([e]))
        for k, command in enumerate(commands):
            assert alone.move(command[e : e + 1])[0] == outcomes[k][e]
            np.testing.assert_array_equal(alone.observations[0], told[k][e])


def test_a_target_in_the_hand_is_caught_at_once(arms):
    situation = next(s for s in arms if s.arm.max_joint_acceleration is None)
    arm = situation.arm
    hand = hands_along(arm, arm.joints)[0][0]
    ball = solid_ball("ball", hand, role="target", radius=0.1 * arm.reach)
    _, episodes = played(
        [replace(situation, bodies=(ball,))], Straight(execution.SpatialSettings())
    )
    assert episodes.outcomes[0] == execution.CAUGHT and episodes.times[0] == 0.0
    assert execution.way_of(arm, *episodes.path(0)).duration == 0.0


def test_the_referee_accepts_every_catch(chains):
    """Catches of the arena as solutions, among them some with an approach."""
    settings, caught, aimed = execution.ChainSettings(), 0, 0
    plant = execution.KinematicPlant(execution.Pool.of(chains), len(chains), settings)
    episodes = execution.run_episode(Straight(settings), plant, np.arange(len(chains)))
    for e in np.flatnonzero(episodes.outcomes == execution.CAUGHT):
        situation, way = chains[e], execution.way_of(chains[e].arm, *episodes.path(e))
        target = next(k for k, b in enumerate(situation.bodies) if b.role == "target")
        plan, reason = checked(JointProblem(situation, "arena"), Attempt(way, target))
        assert plan is not None, reason
        assert judge(situation, plan) == []
        caught += 1
        aimed += len(situation.bodies[target].approach)
    assert caught > 5 and aimed > 0


def test_plans_can_be_followed(chains):
    """What a planner catches is caught again, step by step."""
    settings = execution.ChainSettings()
    plans = [get_planner("straight").plan(s) for s in chains]
    kept = [(s, p.trajectory) for s, p in zip(chains, plans, strict=True) if p.caught]
    pool = execution.pool_for(settings, [s for s, _ in kept])
    plant = execution.KinematicPlant(pool, len(pool), settings)
    agent = execution.follower_of([way for _, way in kept], pool, settings.dt)
    episodes = execution.run_episode(agent, plant, np.arange(len(pool)))
    assert len(kept) > 3 and (episodes.outcomes == execution.CAUGHT).mean() > 0.8


def test_models_with_shorter_lists_stand_side_by_side(chains):
    """Pairs, bodies and ignored bodies may be fewer; every arm is observed as if alone."""
    model = chains[1].arm.model
    fewer = replace(model, self_collision=model.self_collision[:2])
    lone = replace(chains[2], bodies=chains[2].targets, arm=replace(chains[2].arm, ignore=()))
    some = [chains[0], replace(chains[1], arm=replace(chains[1].arm, model=fewer)), lone]
    told = []
    for situations in (some, *([one] for one in some)):
        plant = begun(execution.Pool.of(situations), execution.ChainSettings())
        plant.move(np.full((plant.count, 7), 0.3))
        told.append(plant.observations.copy())
    np.testing.assert_array_equal(told[0], np.concatenate(told[1:]))


def test_a_model_decides_how_much_is_observed():
    for name in ("panda", "ur5", "iiwa14", "xarm6"):
        model, settings = shipped_arm(name), execution.ChainSettings(arm=name)
        assert settings.commands == model.dof
        assert settings.width == 7 * model.dof + 4 * len(model.links) + 41 + 20 * settings.slots
