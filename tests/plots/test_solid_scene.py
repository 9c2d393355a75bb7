"""Solid scenes of planar arms: outlines and projections."""

from __future__ import annotations

import numpy as np
import pytest

from gcm_learn.families import paper
from gcm_learn.plots.figures.solid_scene import camera, to_world
from gcm_learn.rendering import faces
from gcm_learn.scene.outlines import outline
from gcm_learn.situation import Plane


def test_faces_refuse_a_planar_shape():
    with pytest.raises(TypeError, match="not a solid"):
        faces(paper.fig4().targets[0].shape)


def test_outline_of_a_disc_is_a_circle_about_its_place():
    situation = paper.fig4()
    corners = outline(situation, 0, 0.0)
    shape, motion = situation.bodies[0].shape, situation.bodies[0].motion
    np.testing.assert_allclose(np.hypot(*(corners - motion.position).T), shape.radius)


def test_outline_of_a_spinning_polygon_turns():
    situation = paper.fig3()
    index = [body.name for body in situation.bodies].index("square")
    motion = situation.bodies[index].motion
    t = 0.3
    first = outline(situation, index, 0.0) - motion.position
    later = outline(situation, index, t) - np.add(motion.position, np.multiply(motion.velocity, t))
    c, s = np.cos(motion.spin * t), np.sin(motion.spin * t)
    np.testing.assert_allclose(later, first @ np.array([[c, s], [-s, c]]), atol=1e-12)


def test_outline_is_none_where_the_plane_misses():
    situation = paper.fig6()
    assert outline(situation, 0, 0.0) is None
    assert outline(situation, 0, 100 * paper.KAPPA) is not None


PLANES = [
    Plane((0, 0, 0), (1, 0, 0), (0, 0, 1)),
    Plane((1, 2, 3), (0, 1, 0), (0, 0, 1)),
    Plane((0, 0, 1), (1, 0, 0), (0, 1, 0)),
]


@pytest.mark.parametrize("plane", PLANES, ids=repr)
def test_camera_is_orthonormal_and_in_front_of_the_plane(plane):
    view = camera(plane, azimuth=30.0, elevation=15.0)
    axes = np.stack([view.right, view.up, view.nearer])
    np.testing.assert_allclose(axes @ axes.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(axes) == pytest.approx(1.0)
    seen = view.see(np.array([plane.origin, np.add(plane.origin, plane.normal)]))
    assert seen[1, 2] > seen[0, 2]


def test_to_world_puts_arm_plane_points_into_the_plane():
    plane = PLANES[1]
    points = to_world(plane, np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]))
    np.testing.assert_allclose(points, [[1, 2, 3], [1, 3, 3], [1, 2, 4]])
    np.testing.assert_allclose(to_world(plane, np.array([0.0, 0.0, 1.0])), [2, 2, 3])
