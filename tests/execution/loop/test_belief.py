"""Belief: exact without noise, else as near as theory predicts, and no nearer."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import chi2, kstest

from gcm_learn import families, seeding
from gcm_learn.execution import Belief, Percept, Perception
from gcm_learn.rendering import body_poses
from gcm_learn.scene import bodies_later, later
from gcm_learn.situation import Body, Pendulum, SolidQuadratic, Sphere
from tests.execution.loop.test_perception import BOUNCES, WAY, known
from tests.worlds import among, flight

PLACE, FASTER, PRIOR = 0.02, 5.0, 10.0
TAKEN = families.family_names("planar") + families.family_names("spatial")
"""Families whose arms the closed loop takes."""
EYES = Perception(place=PLACE, faster=FASTER, delay=0)
SWING = Pendulum(
    pivot=(0.3, 0.1, 1.5), axis=(0.0, 1.0, 0.0), down=(0.0, 0.0, -1.0), length=0.9, gravity=9.0,
    angle=1.1, rate=-0.5, damping=0.2, hang=0.8,
)  # fmt: skip


@pytest.fixture(scope="module")
def arm():
    """Return an arm whose forearm is not of length 1."""
    found = families.draw("static-clutter-space", 1400, 0).arm
    return replace(found, forearm=(0.5, 0.0, 0.0))


def world(arm, *motions):
    """Return a situation with balls that move so, the first of them a target."""
    roles = ["target", *["obstacle"] * (len(motions) - 1)]
    balls = [
        Body(role, f"ball {k}", Sphere(0.05), motion)
        for k, (role, motion) in enumerate(zip(roles, motions, strict=True))
    ]
    return among(arm, *balls, horizon=3.0)


def told(belief, eyes, situation, looks, *seed):
    """Join all looks that are told up to a number of them; return the surprises."""
    percepts = [eyes.told(situation, k, *seed) for k in range(looks)]
    return np.array([belief.join(percept) for percept in percepts if percept is not None])


def believing(situation, looks, *seed, eyes=EYES, **prior):
    """Return the belief after some looks."""
    belief = Belief(situation, eyes, **prior)
    told(belief, eyes, situation, looks, *seed)
    return belief


def flown(rng, forearm):
    """Return a motion whose acceleration is drawn from the prior."""
    place, velocity, pull = rng.normal(size=3), rng.normal(size=3), PRIOR * forearm
    return flight(place, velocity, pull * rng.normal(size=3))


@pytest.mark.parametrize("name", TAKEN)
def test_without_noise_two_percepts_suffice(name):
    """From the second percept on the world goes on as believed, to the end."""
    situation = families.draw(name, 1400, 1)
    belief = believing(situation, 3, 0, eyes=Perception())
    assert belief.looks == 2
    for now in (0.04, 0.5 * situation.horizon):
        believed = belief.situation(now, situation.arm)
        assert believed.horizon == pytest.approx(situation.horizon - now, abs=1e-12)
        for t in (0.0, 0.4 * situation.horizon):
            thought = bodies_later(believed.bodies, t)
            true = bodies_later(situation.bodies, now + t)
            for one, other in zip(thought, true, strict=True):
                for field, value in vars(other.motion).items():
                    if value is not None:
                        assert getattr(one.motion, field) == pytest.approx(value, abs=1e-6)


def test_the_arm_is_the_one_that_is_told(arm):
    moving = replace(arm, max_joint_acceleration=(50.0,) * 4, joint_rates=(0.1, 0.0, -0.2, 0.3))
    situation = world(moving, flight((1.0, 0.0, 0.0)))
    belief = believing(situation, 2, 0)
    assert belief.situation(0.3, moving).arm == moving


def test_nothing_is_known_before_the_first_look(arm):
    """What a belief takes from a situation is not its bodies; accelerations have a prior only."""
    thought = []
    for pull in (5.0, -5.0):
        situation = world(arm, flight((1.0, 0.0, 0.0), (0.3, 0.0, 0.0), (pull, 0.0, 0.0)))
        seen = believing(situation, 1, 0, eyes=Perception(delay=0))
        thought.append(seen.situation(0.5, arm))
    assert thought[0] == thought[1]
    assert thought[0].bodies[0].motion.position == pytest.approx((1.15, 0.0, 0.0))


def test_a_body_at_rest_is_known_ever_better(arm):
    """By all looks together: the mean of them, and the deviation falls with their root."""
    situation = world(arm, flight((1.0, 0.2, 0.4)))
    for looks in (1, 4, 25):
        belief = believing(situation, looks, 3)
        seen = [EYES.told(situation, k, 3).bodies[0].motion.position for k in range(looks)]
        believed = belief.situation(1.0, arm).bodies[0].motion
        assert believed.position == pytest.approx(np.mean(seen, axis=0), abs=1e-9)
        assert believed.velocity == believed.acceleration == (0.0, 0.0, 0.0)
        assert belief.deviations(1.0)[0] == pytest.approx(PLACE * 0.5 / math.sqrt(looks))


def test_the_filter_is_least_squares(arm):
    """Mean and deviation are those of all looks and the prior in one system of equations."""
    rng, looks, now = seeding.rng(8), 12, 0.6
    situation = world(arm, flown(rng, 0.5))
    belief = believing(situation, looks, 4, acceleration=PRIOR)
    rows, values = [], []
    for k in range(looks):
        t, seen = 0.02 * k, EYES.told(situation, k, 4).bodies[0].motion
        rows += [np.array([1.0, t, 0.5 * t * t]) / 0.01, np.array([0.0, 1.0, t]) / 0.05]
        values += [np.array(seen.position) / 0.01, np.array(seen.velocity) / 0.05]
    rows.append(np.array([0.0, 0.0, 1.0]) / 5.0)
    values.append(np.zeros(3))
    system = np.array(rows)
    best = np.linalg.lstsq(system, np.array(values), rcond=None)[0]
    there = np.array([1.0, now, 0.5 * now * now])
    believed = belief.situation(now, arm).bodies[0].motion
    assert believed.position == pytest.approx(there @ best, abs=1e-8)
    assert believed.acceleration == pytest.approx(best[2], abs=1e-6)
    spread = np.linalg.inv(system.T @ system)
    assert belief.deviations(now)[0] == pytest.approx(math.sqrt(there @ spread @ there), rel=1e-6)


def test_errors_are_as_believed_and_unbiased(arm):
    """Over many worlds: errors over their deviations have mean 0 and variance 1."""
    ratios = {0.3: [], 0.8: []}
    for k in range(200):
        motion = flown(seeding.rng(21, k), 0.5)
        situation = world(arm, motion)
        belief = believing(situation, 10, 22, k, acceleration=PRIOR)
        for now, found in ratios.items():
            true = later(situation, now, joints=arm.joints).bodies[0].motion.position
            off = np.subtract(belief.situation(now, arm).bodies[0].motion.position, true)
            found += (off / belief.deviations(now)[0]).tolist()
    for found in ratios.values():
        assert abs(np.mean(found)) < 4.0 / math.sqrt(len(found))
        assert abs(np.var(found) - 1.0) < 4.0 * math.sqrt(2.0 / len(found))


def test_bodies_that_fall_are_followed_from_the_first_looks_on():
    """Gravity is no error of the eyes: what is believed before the first look allows for it."""
    ratios = []
    for k in range(12):
        situation = families.draw("falling-space", 1400, k)
        belief = believing(situation, 8, 61, k)
        true = later(situation, 0.5).bodies
        believed, deviations = belief.situation(0.5, situation.arm).bodies, belief.deviations(0.5)
        for one, other, body, deviation in zip(
            believed, true, situation.bodies, deviations, strict=True
        ):
            if isinstance(body.motion, SolidQuadratic) and np.any(body.motion.acceleration):
                off = np.subtract(one.motion.position, other.motion.position)
                ratios.append(np.abs(off).max() / deviation)
    assert len(ratios) > 20
    assert np.median(ratios) < 2.5
    assert max(ratios) < 6.0


def test_surprises_are_chi_square(arm):
    """What is seen strays from what was expected as far as it should, no less and no more."""
    rest = flight((0.5, 0.5, 0.0))
    eyes = replace(EYES, dropouts=1.0)
    found = []
    for k in range(120):
        situation = world(arm, flown(seeding.rng(31, k), 0.5), rest, SWING)
        found.append(told(Belief(situation, eyes, PRIOR), eyes, situation, 15, 32, k)[1:])
    surprises = np.concatenate(found)
    for column, degrees in zip(surprises.T, (6, 3, 2), strict=True):
        assert kstest(column, chi2(degrees).cdf).pvalue > 1e-3
    # the question can be answered with no: looks that are worse than is thought
    worse = replace(EYES, place=1.3 * PLACE)
    situation = world(arm, rest)
    wrong = [told(Belief(situation, EYES), worse, situation, 15, 33, k)[1:, 0] for k in range(50)]
    assert kstest(np.concatenate(wrong), chi2(3).cdf).pvalue < 1e-6


@pytest.mark.parametrize("motion", [WAY, BOUNCES], ids=["sampled", "piecewise"])
def test_the_shift_of_a_known_law_is_the_mean_of_all_looks(motion):
    """It is believed at all later times, whatever the law does between two looks and after."""
    situation, looks = known(motion), 30
    belief = believing(situation, looks, 5)
    offs = []
    for k in range(looks):
        percept = EYES.told(situation, k, 5)
        seen, _ = body_poses(replace(situation, bodies=percept.bodies), [0.0])
        there, _ = body_poses(situation, [percept.time])
        offs.append(seen[0, 0] - there[0, 0])
    for now in (0.6, 1.2):
        believed = belief.situation(now, situation.arm)
        places, turns = body_poses(believed, np.linspace(0.0, 0.7, 8))
        there, turned = body_poses(situation, now + np.linspace(0.0, 0.7, 8))
        np.testing.assert_allclose(places[:, 0], there[:, 0] + np.mean(offs, axis=0), atol=1e-9)
        np.testing.assert_allclose(turns, turned, atol=1e-9)
        forearm = 0.5 * situation.arm.reach
        assert belief.deviations(now)[0] == pytest.approx(PLACE * forearm / math.sqrt(looks))


@pytest.mark.parametrize("motion", [WAY, BOUNCES], ids=["sampled", "piecewise"])
def test_surprises_of_known_laws_are_chi_square(motion):
    situation = known(motion)
    found = [told(Belief(situation, EYES), EYES, situation, 30, 34, k)[1:, 0] for k in range(60)]
    assert kstest(np.concatenate(found), chi2(3).cdf).pvalue > 1e-3


def test_a_pendulum_is_followed(arm):
    """Over a large swing the angle stays within its deviation, which shrinks."""
    ratios, spans = [], []
    situation = world(arm, SWING)
    for k in range(60):
        beliefs = [believing(situation, looks, 42, k) for looks in (3, 45)]
        before, after = (belief.deviations(1.0)[0] for belief in beliefs)
        spans.append(after / before)
        true = later(situation, 1.0, joints=arm.joints).bodies[0].motion.angle
        thought = beliefs[1].situation(1.0, arm).bodies[0].motion
        assert thought.pivot == SWING.pivot
        ratios.append((thought.angle - true) * 0.8 / after)
    assert max(spans) < 0.4
    assert abs(np.mean(ratios)) < 4.0 / math.sqrt(len(ratios))
    assert 0.5 < np.var(ratios) < 1.8


def test_dropouts_make_less_certain(arm):
    """Without looks the spread grows, by the law of motion and nothing else."""
    situation = world(arm, flown(seeding.rng(51), 0.5), SWING)
    seen, missed = Belief(situation, EYES, PRIOR), Belief(situation, EYES, PRIOR)
    for k in range(12):
        percept = EYES.told(situation, k, 52)
        seen.join(percept)
        if not 6 <= k <= 10:
            missed.join(percept)
        if k == 10:
            assert (missed.deviations(0.2) > 1.3 * seen.deviations(0.2)).all()
    assert (missed.deviations(0.22) > seen.deviations(0.22)).all()
    grown = [missed.deviations(now)[0] for now in (0.22, 0.3, 0.5, 0.8)]
    assert grown == sorted(grown)


def test_what_begins_to_move_is_believed_anew(arm):
    """A body that was seen at rest and is not any more has no past."""
    rest = world(arm, flight((1.0, 0.0, 0.0)))
    belief = believing(rest, 3, 0, eyes=Perception(delay=0))
    flies = replace(rest.bodies[0].motion, velocity=(2.0, 0.0, 0.0))
    belief.join(Percept(0.06, (replace(rest.bodies[0], motion=flies),), (False,)))
    assert belief.situation(0.06, arm).bodies[0].motion.velocity == (2.0, 0.0, 0.0)
