"""Motion laws in arrays: poses against closed forms, and bounds of the way, for every law."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from gcm_learn import situation as records
from gcm_learn.arms import SpatialArm, rotation_of
from gcm_learn.scene import bodies as k, later, pack_bodies
from gcm_learn.scene.packing import pose
from gcm_learn.situation.timed_motion import flown
from tests import strategies

ARM = SpatialArm(
    upper_arm=(1, 0, 0), forearm=(1, 0, 0), joints=(0,) * 4, joint_range=((-1, 1),) * 4,
    max_joint_speed=(1,) * 4, grasp=0.1,
)  # fmt: skip
BOX = records.Box((0.3, 0.2, 0.1))
LAWS = {
    records.SolidQuadratic: strategies.solid_quadratics,
    records.Pendulum: strategies.pendulums(),
    records.Piecewise: strategies.piecewise(),
    records.Sampled: strategies.sampled(),
}
CORNERS = np.array(np.meshgrid(*[(-1.0, 1.0)] * 3)).reshape(3, -1).T * BOX.half_extents
still = pytest.mark.parametrize("law", [pytest.param(LAWS[law], id=law.kind) for law in LAWS])


def scene(*motions, shape=BOX, horizon=3.0, arm=ARM):
    """Return a situation of version 3 whose first body is the target."""
    bodies = tuple(
        records.Body("obstacle" if b else "target", str(b), shape, motion)
        for b, motion in enumerate(motions)
    )
    return records.Situation("scene", horizon, arm, bodies, format="gcm-learn/situation@3")


def corners_at(bodies, b, t):
    """Corners (8, 3) of body b, a box, at a time."""
    poses = np.zeros((len(bodies.rows), 12))
    k.pose_at(bodies, b, t, poses)
    return CORNERS @ poses[b, 3:].reshape(3, 3).T + poses[b, :3]


@given(strategies.piecewise(), st.floats(0.0, 3.0))
def test_a_piece_holds_from_its_start_to_the_next(motion, t):
    piece = [each for each in motion.pieces if each.start <= t][-1]
    position, turn = flown(piece.motion, t - piece.start)
    centre, rotation = pose(scene(motion), 0, t)
    np.testing.assert_allclose(centre, position, atol=1e-12)
    np.testing.assert_allclose(rotation, rotation_of(turn), atol=1e-9)
    assert motion.at(t) == piece


@given(strategies.sampled(), st.floats(0.0, 1.0))
def test_samples_are_met_and_joined_by_straight_lines(motion, share):
    situation = scene(motion)
    times, places = motion.times, np.array(motion.positions)
    for i, time in enumerate((*times, times[-1] + 5.0)):
        k = min(i, len(times) - 1)  # after the last sample the body rests
        centre, rotation = pose(situation, 0, time)
        np.testing.assert_allclose(centre, places[k], atol=1e-12)
        np.testing.assert_allclose(rotation, rotation_of(motion.turns[k]), atol=1e-9)
    for i, (before, after) in enumerate(pairwise(times)):
        t = before + share * (after - before)
        along = (t - before) / (after - before)
        line = places[i] * (1.0 - along) + places[i + 1] * along
        np.testing.assert_allclose(pose(situation, 0, t)[0], line, atol=1e-12)


def test_a_sampled_body_turns_the_short_way():
    half = np.sqrt(0.5)
    motion = records.Sampled(
        (0.0, 1.0), ((0.0,) * 3,) * 2, ((1.0, 0.0, 0.0, 0.0), (-half, 0, 0, -half))
    )
    rotation = pose(scene(motion), 0, 0.5)[1]
    c = np.cos(np.pi / 4.0)
    np.testing.assert_allclose(rotation, [[c, -c, 0], [c, c, 0], [0, 0, 1]], atol=1e-12)


@still
@settings(max_examples=40)
@given(data=st.data(), start=st.floats(0.0, 2.0), span=st.floats(1e-3, 1.0))
def test_drift_bounds_the_way_of_every_point(law, data, start, span):
    bodies = pack_bodies(scene(data.draw(law)))
    times = np.linspace(start, start + span, 60)
    corners = np.array([corners_at(bodies, 0, t) for t in times])
    way = np.linalg.norm(np.diff(corners, axis=0), axis=-1).sum(axis=0).max()
    assert way <= k.drift(bodies, 0, start, start + span) * (1.0 + 1e-9) + 1e-12
    fastest = bodies.rows[0, k.TOP_SPEED]
    assert way <= fastest * span * (1.0 + 1e-6) + 1e-9


def test_drift_counts_the_gap_between_pieces():
    still, off = (0.0,) * 3, (9e-7, 0.0, 0.0)
    first = records.SolidQuadratic(still, still, still)
    motion = records.Piecewise(
        (records.Piece(0.0, first), records.Piece(1.0, records.SolidQuadratic(off, still, still)))
    )
    bodies = pack_bodies(scene(motion))
    assert k.drift(bodies, 0, 0.5, 0.9) == 0.0
    assert k.drift(bodies, 0, 0.5, 1.0) == pytest.approx(9e-7)
    assert k.drift(bodies, 0, 1.0, 2.0) == 0.0


@still
@settings(max_examples=40)
@given(data=st.data(), t=st.floats(0.01, 1.0), ahead=st.floats(0.0, 1.0))
def test_later_goes_on_as_it_would_have(law, data, t, ahead):
    situation = scene(data.draw(law))
    for now, then in zip(
        pose(situation, 0, t + ahead), pose(later(situation, t), 0, ahead), strict=True
    ):
        np.testing.assert_allclose(then, now, atol=2e-6)


@still
@settings(max_examples=40)
@given(data=st.data(), base=strategies.bases(), t=st.floats(0.0, 2.0))
def test_the_canonical_form_moves_alike(law, data, base, t):
    arm = replace(ARM, upper_arm=(1.0, 0.2, 0.0), forearm=(1.0, -0.4, 0.0), base=base)
    situation = scene(data.draw(law), arm=arm)
    form, frame = records.canonical(situation)
    world = corners_at(pack_bodies(situation), 0, t) * (1.0, -1.0 if frame.mirrored else 1.0, 1.0)
    near = corners_at(pack_bodies(form), 0, t)
    gaps = np.linalg.norm(world[:, None] - near[None], axis=-1)
    assert gaps.min(axis=1).max() < 1e-8


def test_balls_are_not_turned():
    spinning = records.SolidQuadratic((0.0,) * 3, (0.0,) * 3, (0.0,) * 3, spin=(0.0, 0.0, 9.0))
    bodies = pack_bodies(
        scene(records.Piecewise((records.Piece(0.0, spinning),)), shape=records.Sphere(0.2))
    )
    assert bodies.rows[0, k.TOP_SPEED] == 0.0 == k.drift(bodies, 0, 0.0, 1.0)
