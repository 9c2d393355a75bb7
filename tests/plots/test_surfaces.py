"""Surfaces in arrays over space, and hand-space in space that is drawn with them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from gcm_learn.arms import forward_in_space
from gcm_learn.charts import cell_clearances
from gcm_learn.maps import CognitiveMap, Interception, build_map
from gcm_learn.plots import style
from gcm_learn.plots.figures import hand_ball
from gcm_learn.plots.figures.surfaces import softened, surface
from gcm_learn.rendering import normals, turned_view, view_of
from gcm_learn.situation import arm_frame, read_situations
from gcm_learn.wave import MarchingParams
from tests.rendering.test_rendering import near, turning
from tests.spatial import EXAMPLES

N = 20
BALL = np.linalg.norm(np.indices((N, N + 2, N + 4)).T - (9.3, 10.1, 11.4), axis=-1).T


def test_the_surface_of_a_ball_is_a_sphere():
    corners, normal = surface(BALL, 6.2)
    out = (corners - (9.3, 10.1, 11.4)) / 6.2
    np.testing.assert_allclose(np.linalg.norm(out, axis=-1), 1.0, atol=0.02)
    assert ((out * normal).sum(axis=-1) > 0.98).all()
    assert ((normals(corners) * out.mean(axis=1)).sum(axis=-1) > 0.95).all()


@pytest.mark.parametrize("level", [3.0, 12.0])  # the larger one leaves the array
def test_surfaces_are_closed(level):
    corners, _ = surface(BALL, level)
    area = np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])
    np.testing.assert_allclose(area.sum(axis=0), 0.0, atol=1e-9)
    edges = {}
    for quad in np.round(corners, 9).tolist():
        for a, b in zip(quad, quad[1:] + quad[:1], strict=True):
            edges[tuple(a), tuple(b)] = edges.get((tuple(a), tuple(b)), 0) + 1
    assert all(edges.get((b, a)) == count for (a, b), count in edges.items())


def test_nothing_to_draw_is_no_surface():
    corners, normal = surface(np.ones((4, 4, 4)))
    assert corners.shape == normal.shape == (0, 4, 3)


def test_softening_keeps_the_sum_and_spreads_to_neighbours():
    cells = np.zeros((5, 5, 5), dtype=bool)
    cells[2, 2, 2] = True
    soft = softened(cells)
    assert soft.sum() == pytest.approx(1.0) and soft[2, 2, 2] == 0.125
    assert soft[1, 2, 2] == soft[2, 3, 2] == 0.0625


@pytest.fixture(scope="module")
def case():
    """A situation, and a map as a front would leave it that nothing delays."""
    situation = read_situations(EXAMPLES)[7]
    arm = situation.arm
    free = replace(situation, bodies=situation.targets, horizon=3.0)
    found = build_map(free, MarchingParams(n=40, margin=0.0, until="horizon"))
    chart, joints = found.chart, found.joints
    axes, origin = arm_frame(situation)
    hand = (forward_in_space(arm, arm.joints)[1] - origin) @ axes.T
    away = np.linalg.norm(chart.hands - hand, axis=1).reshape(chart.shape)
    shut = cell_clearances(situation, chart, 0.0, joints) < 0.1
    open_ = np.isfinite(joints[:, 0]).reshape(chart.shape) & ~shut
    target = axes @ (np.asarray(situation.targets[0].motion.position) - origin)
    met = Interception(chart.cell_of(target), tuple(target), 0.4, "ball")
    arrival = np.ma.masked_array(away / 4.0, mask=~open_)
    nothing = np.zeros(chart.shape, dtype=bool)
    rest = met, 1 / 400, "marching", None, None, joints
    return situation, CognitiveMap(chart, tuple(hand), arrival, shut, nothing, *rest)


def test_places_of_a_lattice_are_those_of_its_hands(case):
    situation, cognitive_map = case
    chart = cognitive_map.chart
    axes, origin = arm_frame(situation)
    index = np.array([[1, 2, 3], [10, 4, 7]])
    hands = chart.hands.reshape(*chart.shape, 3)[tuple(index.T)]
    found = hand_ball.places_of(chart, index)
    np.testing.assert_allclose(found, hands @ axes + origin, atol=1e-12)


def test_extended_obstacles_look_outward_and_hold_what_is_touched(case):
    situation, cognitive_map = case
    faces = hand_ball.extended_faces(situation, 0.0, cognitive_map)
    a, b = faces.corners[:, 2] - faces.corners[:, 0], faces.corners[:, 3] - faces.corners[:, 1]
    areas = np.cross(a, b)
    outward = (areas[:, None] * faces.normals).sum(axis=-1)[np.linalg.norm(areas, axis=1) > 1e-9]
    assert np.mean(outward > 0.0) > 0.98
    volume = (faces.corners.mean(axis=1) * areas).sum() / 6
    chart = cognitive_map.chart
    rooms = cell_clearances(situation, chart, 0.0, cognitive_map.joints)
    touched = (rooms < 0.0).sum() * chart.spacing**3
    assert volume == pytest.approx(touched, rel=0.2)


def test_the_front_is_where_its_time_says(case):
    situation, cognitive_map = case
    axes, origin = arm_frame(situation)
    hand = np.asarray(cognitive_map.hand) @ axes + origin
    faces = hand_ball.front_faces(cognitive_map, 0.1)
    away = np.linalg.norm(faces.corners - hand, axis=-1)
    assert np.median(away) == pytest.approx(0.4, abs=0.3 * cognitive_map.chart.spacing)
    assert len(hand_ball.front_faces(cognitive_map, -1.0).corners) == 0


def test_effective_obstacles_come_with_the_front(case):
    _, cognitive_map = case
    counts = [len(hand_ball.effective_faces(cognitive_map, t).corners) for t in (0.0, 0.35, 9.0)]
    assert counts[0] == 0 < counts[1] < counts[2]


def test_a_map_is_cut_through_hand_and_catch_facing_the_camera(case):
    situation, cognitive_map = case
    view = hand_ball.ball_view(situation, view_of(situation))
    things = hand_ball.map_faces(situation, cognitive_map, view, turning(situation))
    ax = style.new_figure(3.0, 3.0).subplots()
    hand_ball.draw_ball(ax, situation, view, things, 120)
    image = np.asarray(ax.images[0].get_array())
    assert near(image, style.EFFECTIVE) > 0.001
    assert near(image, style.MAP_COLOURS(0.8)[:3]) > 0.1
    axes, origin = arm_frame(situation)
    start = np.asarray(cognitive_map.hand) @ axes + origin
    middle, u, v = hand_ball.cut_frame(start, start + (0.1, 0.2, -0.4), view)
    normal = np.cross(u, v)
    assert normal @ view.nearer > 0.0 and abs((start - middle) @ normal) < 1e-12
    quarter = turned_view(view, 90.0)
    turned = hand_ball.cut_frame(start, start, quarter)
    np.testing.assert_allclose(np.cross(*turned[1:]), quarter.nearer)
