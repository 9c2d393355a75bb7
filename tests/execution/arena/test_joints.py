"""Plants of joints: what they report is verified, limits hold, batches are single arms."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from gcm_learn.arms import CHAIN, SPATIAL, ByKind, kind_of
from gcm_learn.errors import ArenaError, ArmKindError
from gcm_learn.execution import (
    CAUGHT,
    COLLIDED,
    LATE,
    ChainSettings,
    KinematicPlant,
    Pool,
    Settings,
    SpatialSettings,
    pool_for,
    pool_of,
    run_episode,
    way_of,
)
from gcm_learn.motion.failures import Failure
from gcm_learn.motion.rules import opening
from gcm_learn.motion.verification import verify
from gcm_learn.scene.packing import pack
from gcm_learn.situation import Body, SolidQuadratic, Sphere
from tests.execution.conftest import good

SETTINGS = ByKind({SPATIAL: SpatialSettings(), CHAIN: ChainSettings()})


@pytest.fixture(params=["spatial", "chain"])
def some(request, arms, chains):
    """Return situations of one kind of arm."""
    return {"spatial": arms, "chain": chains}[request.param]


class Aiming:
    """Goes straight to where the target can be met."""

    def __init__(self, settings):
        self._part = slice(settings.straight, settings.straight + settings.commands)

    def act(self, moment):
        return moment.observations[:, self._part].astype(float)


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
    pool = Pool.of(situations)
    plant = KinematicPlant(pool, len(pool), settings or SETTINGS.of(pool.kind))
    return plant, run_episode(agent, plant, np.arange(len(pool)))


@pytest.mark.parametrize("wild", [False, True], ids=["aiming", "wild"])
def test_what_it_reports_is_what_the_verification_says(some, rng, wild):
    """A catch is a verified plan; a touch is one where it ends, and nothing is before."""
    agent = Wild(rng) if wild else Aiming(SETTINGS.of(some[0]))
    _, episodes = played(some, agent)
    for e, situation in enumerate(some):
        scene = pack(situation)
        rules = opening(scene).rules
        time, posture = episodes.path(e)
        way = way_of(situation.arm, time, posture)
        targets = [k for k, b in enumerate(situation.bodies) if b.role == "target"]
        verdicts = [verify(scene, rules, way, k) for k in targets]
        outcome = episodes.outcomes[e]
        assert (outcome == CAUGHT) == any(v.good for v in verdicts)
        if outcome == CAUGHT:
            continue
        # without its obstacles the way keeps every promise but the catch
        bare = without_obstacles(situation)
        if kind_of(situation) is CHAIN and outcome == COLLIDED:
            continue  # it may touch itself
        kept = verify(pack(bare), rules, way, 0)
        assert kept.reason is not None and kept.reason.failure is Failure.MISSED
        assert (outcome == LATE) == (way.duration == situation.horizon and outcome != COLLIDED)
        held = clearance_until(scene, rules, way, way.duration)
        assert (held <= rules.touch) == (outcome == COLLIDED)
        if outcome == COLLIDED and len(time) > 2:
            before = way_of(situation.arm, time[:-1], posture[:-1])
            assert clearance_until(scene, rules, before, before.duration) > rules.touch
    found = set(episodes.outcomes.tolist())
    assert COLLIDED in found and (CAUGHT in found or wild) and (LATE in found or not wild)


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
        way = way_of(arm, time, posture)
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


def resting(place):
    """Return the law of what rests."""
    return SolidQuadratic(tuple(float(x) for x in place), (0.0,) * 3, (0.0,) * 3)


def far_target(arm):
    """Return a resting target that the arm cannot reach."""
    place = np.array(arm.base.origin) + [9.0 * arm.reach, 0.0, 0.0]
    return Body("target", "far", Sphere(0.1 * arm.reach), resting(place))


def test_joints_go_where_they_are_told(arms):
    """Where nothing limits it, a command of 0.5 turns every joint half as fast as it can."""
    quick = [s for s in arms if s.arm.max_joint_acceleration is None][:6]
    free = [replace(s, bodies=(far_target(s.arm),)) for s in quick]
    free = [replace(s, arm=replace(s.arm, max_hand_speed=None)) for s in free]
    plant = KinematicPlant(Pool.of(free), len(free), SpatialSettings())
    plant.put(np.arange(len(free)), np.arange(len(free)))
    plant.move(np.full((len(free), 4), 0.01))
    for e, situation in enumerate(free):
        arm = situation.arm
        low, high = np.array(arm.joint_range).T
        turned = np.array(arm.joints) + 0.01 * 0.02 * np.array(arm.max_joint_speed)
        np.testing.assert_allclose(plant.posture[e, :4], np.clip(turned, low, high), rtol=1e-8)


def test_many_arms_are_single_ones(some, rng):
    """Whatever the batch and the threads."""
    settings = SETTINGS.of(some[0])
    pool = Pool.of(some)
    many = KinematicPlant(pool, len(pool), settings, threads=3)
    many.put(np.arange(len(pool)), np.arange(len(pool)))
    alone = KinematicPlant(pool, 1, settings)
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
    from gcm_learn.arms import forward_in_space

    hand = forward_in_space(arm, arm.joints)[1]
    held = resting(hand)
    ball = Body("target", "ball", Sphere(0.1 * arm.reach), held)
    _, episodes = played([replace(situation, bodies=(ball,))], Aiming(SpatialSettings()))
    assert episodes.outcomes[0] == CAUGHT and episodes.times[0] == 0.0
    way = way_of(arm, *episodes.path(0))
    assert way.duration == 0.0


def test_bad_situations_are_refused_in_one_line(arms):
    from gcm_learn import families

    flat = families.draw("random-planar", 3, 0)
    for refused in (
        lambda: pool_for(SpatialSettings(), [flat]),
        lambda: pool_of("random-planar", 2, 0, SpatialSettings()),
        lambda: Pool.of([arms[0], flat]),
        lambda: KinematicPlant(Pool.of([flat]), 1, SpatialSettings()),
    ):
        with pytest.raises(ArmKindError, match="the arena does not take planar arms"):
            refused()
    with pytest.raises(ArmKindError, match="the arena does not take spatial arms"):
        pool_for(Settings(), [arms[0]])
    with pytest.raises(ArenaError, match="there is none"):
        Pool.of([])
    arm = arms[0].arm
    ends = tuple(high for _, high in arm.joint_range)
    fast = replace(
        arm, joints=ends, max_joint_acceleration=(1.0,) * 4, joint_rates=arm.max_joint_speed
    )
    pool = Pool.of([replace(arms[0], arm=fast, bodies=arms[0].targets)])
    with pytest.raises(ArenaError, match=r"the arm cannot stop in steps of 0\.02 s"):
        KinematicPlant(pool, 1, SpatialSettings())
