"""Faces and their pictures: shapes, projections, places of what is painted."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from matplotlib.colors import to_rgb

from gcm_learn import rendering
from gcm_learn.arms import Chain, hands_along
from gcm_learn.motion import Movement
from gcm_learn.rendering import solids
from gcm_learn.situation import Box, Capsule, Cylinder, Sphere, read_situations, shipped_arm
from tests.panda import PANDA
from tests.spatial import EXAMPLES
from tests.strategies import spatial_situations, third_situations

SOLIDS = [Sphere(0.3), Box((0.2, 0.5, 0.9)), Capsule(0.1, 0.7), Cylinder(0.4, 0.05)]
VIEW = rendering.camera_from(30.0, 20.0, (0.1, 0.2, 0.3), 8.0)
WINDOW = rendering.Window(np.zeros(2), 1.0)


def turning(situation, duration=None):
    """A movement to the middle of the joints' ranges, linear in the joints."""
    arm = situation.arm
    middle = np.array(arm.joint_range).mean(axis=1)
    end = situation.horizon if duration is None else duration
    return Movement(arm, np.array([0.0, end]), np.array([arm.joints, middle]))


def near(image, colour, tolerance=0.12):
    """Share of pixels of a colour, in whatever light."""
    pure = np.array(to_rgb(colour))
    hue = image - image.mean(axis=-1, keepdims=True)
    wanted = pure - pure.mean()
    alike = (hue @ wanted) / np.maximum(np.linalg.norm(hue, axis=-1) * np.linalg.norm(wanted), 1e-9)
    return float(((alike > 1 - tolerance) & (np.linalg.norm(hue, axis=-1) > 0.1)).mean())


@pytest.fixture(scope="module", params=[EXAMPLES, PANDA], ids=["spatial", "chain"])
def case(request):
    situation = read_situations(request.param)[0]
    return situation, turning(situation)


@pytest.mark.parametrize("shape", SOLIDS, ids=repr)
def test_normals_of_round_solids_look_out_of_them(shape):
    corners = solids.faces(shape)
    normal = solids.round_normals(shape, corners)
    if isinstance(shape, Box):
        assert normal is None
        return
    np.testing.assert_allclose(np.linalg.norm(normal, axis=-1), 1.0, atol=1e-9)
    flat = rendering.normals(corners)
    sized = np.linalg.norm(corners[:, 2] - corners[:, 0], axis=1) > 1e-9
    assert (np.einsum("nki,ni->nk", normal, flat)[sized] > 0.8).all()


def test_faces_of_a_tube_look_outward():
    angle = np.linspace(0.0, 5.0, 40)
    path = np.stack([np.cos(angle), np.sin(angle), 0.2 * angle], axis=1)
    quads = solids.tube(path, 0.05, 6).reshape(-1, 6, 4, 3)
    middles = 0.5 * (path[1:] + path[:-1])
    outward = quads.mean(axis=2) - middles[:, None]
    facing = np.einsum(
        "nki,nki->nk", rendering.normals(quads.reshape(-1, 4, 3)).reshape(-1, 6, 3), outward
    )
    assert (facing > 0.0).all()


def test_a_ball_is_a_disc_of_its_size_in_the_middle():
    ball = solids.placed(Sphere(0.5), VIEW.centre, np.eye(3), np.array([1.0, 0.0, 0.0]))
    image = rendering.render(VIEW, WINDOW, [ball], 100)
    painted = (image < 0.99).any(axis=-1)
    assert painted.mean() == pytest.approx(np.pi * 0.25 / 4, rel=0.03)
    rows, columns = np.nonzero(painted)
    assert abs(rows.mean() - 49.5) < 0.5 and abs(columns.mean() - 49.5) < 0.5


def test_what_is_nearer_hides_what_is_behind_in_any_order():
    red, blue = np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0])
    before = solids.placed(Sphere(0.2), VIEW.centre + VIEW.nearer, np.eye(3), red)
    behind = solids.placed(Sphere(0.4), VIEW.centre - VIEW.nearer, np.eye(3), blue)
    for things in ([before, behind], [behind, before]):
        image = rendering.render(VIEW, WINDOW, things, 60)
        assert image[30, 30, 0] > 0.5 > image[30, 30, 2]
        ring = image[30, 30 + 9]
        assert ring[2] > ring[0]


def test_glass_lets_through_what_is_behind_and_hides_behind_what_is_before():
    red, blue = np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0])
    solid = solids.placed(Sphere(0.2), VIEW.centre, np.eye(3), blue)
    plain = rendering.render(VIEW, WINDOW, [solid], 60)[30, 30]
    for place, changes in ((VIEW.centre + VIEW.nearer, True), (VIEW.centre - VIEW.nearer, False)):
        glass = solids.placed(Sphere(0.2), place, np.eye(3), red, 0.3)
        seen = rendering.render(VIEW, WINDOW, [solid, glass], 60)[30, 30]
        assert (np.abs(seen - plain).max() > 0.1) == changes
        assert seen[2] > seen[0]


def test_what_is_at_the_eye_is_left_out():
    ball = solids.placed(Sphere(0.2), VIEW.centre + 8.0 * VIEW.nearer, np.eye(3), np.zeros(3))
    assert (rendering.render(VIEW, WINDOW, [ball], 20) == 1.0).all()


def test_a_camera_turned_all_round_is_where_it_was():
    turned = rendering.turned_view(VIEW, 360.0)
    point = np.array([0.4, -0.3, 0.9])
    np.testing.assert_allclose(turned.see(point), VIEW.see(point), atol=1e-12)
    quarter = rendering.turned_view(VIEW, 90.0)
    np.testing.assert_allclose(np.cross(quarter.right, quarter.up), quarter.nearer, atol=1e-12)
    assert quarter.up[2] == pytest.approx(VIEW.up[2])


def test_bodies_are_where_their_motion_says():
    situation = read_situations(EXAMPLES)[0]
    centres, turns = rendering.body_poses(situation, [0.0, 0.3])
    for k, body in enumerate(situation.bodies):
        motion = body.motion
        later = np.add(motion.position, 0.3 * np.array(motion.velocity))
        later = later + 0.045 * np.array(motion.acceleration)
        np.testing.assert_allclose(centres[:, k], [motion.position, later], atol=1e-9)
    identity = np.broadcast_to(np.eye(3), turns.shape)
    np.testing.assert_allclose(turns @ np.swapaxes(turns, -1, -2), identity, atol=1e-9)


def test_the_hand_is_painted_where_it_is(case):
    situation, trajectory = case
    view = rendering.view_of(situation, trajectory)
    things = rendering.arm_faces(situation.arm, situation.arm.joints)
    window = rendering.window_of(situation, view, things)
    image = rendering.staged(view, window, rendering.floor_of(situation, things), things, 200)
    hand = view.see(hands_along(situation.arm, situation.arm.joints)[0][0])[:2]
    column, row = (200 * (hand - window.middle + window.half) / (2 * window.half)).astype(int)
    assert near(image[row - 1 : row + 2, column - 1 : column + 2], rendering.ARM) == 1.0


@settings(max_examples=12, deadline=None, suppress_health_check=list(HealthCheck))
@given(spatial_situations() | third_situations())
def test_any_situation_can_be_drawn(situation):
    for trajectory in (None, turning(situation)):
        view = rendering.view_of(situation, trajectory)
        things = [
            *rendering.body_faces(situation, 0.0),
            *rendering.arm_faces(situation.arm, situation.arm.joints),
        ]
        if trajectory is not None:
            things += rendering.path_faces(situation, trajectory)
        window = rendering.window_of(situation, view, things)
        image = rendering.staged(view, window, rendering.floor_of(situation, things), things, 40)
        assert np.isfinite(image).all() and image.std() > 0.01


def area_vector(face: np.ndarray) -> np.ndarray:
    return 0.5 * np.cross(face, np.roll(face, -1, axis=0)).sum(axis=0)


@pytest.mark.parametrize("shape", SOLIDS, ids=repr)
def test_faces_close_and_look_outward(shape):
    areas = np.array([area_vector(face) for face in solids.faces(shape)])
    middles = np.array([face.mean(axis=0) for face in solids.faces(shape)])
    np.testing.assert_allclose(areas.sum(axis=0), 0.0, atol=1e-12)
    assert (np.einsum("ij,ij->i", areas, middles) >= -1e-12).all()


VOLUMES = {
    "sphere": lambda s: 4 / 3 * np.pi * s.radius**3,
    "box": lambda s: 8 * np.prod(s.half_extents),
    "cylinder": lambda s: 2 * np.pi * s.radius**2 * s.half_length,
    "capsule": lambda s: np.pi * s.radius**2 * (2 * s.half_length + 4 / 3 * s.radius),
}


@pytest.mark.parametrize("shape", SOLIDS, ids=repr)
def test_faces_hold_the_solids_volume(shape):
    """Gauss: the volume is a third of the flux of x through the faces."""
    volume = sum(area_vector(f) @ f.mean(axis=0) for f in solids.faces(shape)) / 3
    assert volume == pytest.approx(VOLUMES[shape.kind](shape), rel=0.06)


def test_links_whose_axis_is_a_point_are_balls():
    """Link 1 of the xArm 6 is one."""
    model = shipped_arm("xarm6")
    middle = tuple(0.5 * (low + high) for low, high in (joint.range for joint in model.joints))
    arm = Chain(model, middle, 0.02)
    things = rendering.arm_faces(arm, arm.joints)
    balls = len(list(rendering.balls_of(rendering.limb_along(arm, [arm.joints]))))
    assert len(things) == len(model.links) + balls
    ends = rendering.limb_along(arm, [arm.joints]).ends[0]
    assert (ends[1, 0] == ends[1, 1]).all()
