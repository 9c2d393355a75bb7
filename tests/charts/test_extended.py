"""Extended obstacles: the curves of Eq. 8 and erratum 6 against the limb itself."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import assume, given, strategies as st

from gcm_learn.arms import SIDE, Arm
from gcm_learn.charts import Lattice, extended_obstacle, occupied_cells
from gcm_learn.charts.extended import reach_angle
from gcm_learn.charts.lattice import hand_space
from gcm_learn.situation import Body, Disc, PlanarQuadratic, Situation
from tests.planar_geometry import elbow_of, segment_distances

sides = st.sampled_from(["right", "left"])
uppers = st.sampled_from([1.0, 0.6, 1.5]) | st.floats(0.3, 3.0)


@st.composite
def reachable_points(draw):
    """Upper arm, and a point that some posture of the arm can touch."""
    rho = draw(uppers)
    share, angle = draw(st.floats(0.02, 0.98)), draw(st.floats(-math.pi, math.pi))
    radius = share * (rho + 1.0)
    if abs(radius - rho) < 0.02:  # singular (erratum 4)
        radius = rho + 0.02
    return rho, np.array([radius * math.cos(angle), radius * math.sin(angle)])


def distances(rho, side, hands, point):
    """Distances (n,) of a point to the upper arms and to the forearms of hands (n, 2)."""
    elbows = elbow_of(Arm((rho, 1.0), 1.0, rho, side), hands) if len(hands) else hands
    here = np.zeros((len(hands), 3)), np.broadcast_to(np.eye(3), (len(hands), 3, 3))
    here[0][:, :2] = point
    dot = Disc(1e-12)
    upper_arm = segment_distances(dot, here, np.zeros_like(hands), elbows)
    return upper_arm, segment_distances(dot, here, elbows, hands)


def on_ring(rho, hands):
    radius = np.hypot(hands[:, 0], hands[:, 1])
    return (radius <= rho + 1.0 + 1e-9).all() and (radius >= abs(rho - 1.0) - 1e-9).all()


@given(reachable_points(), sides)
def test_every_hand_on_the_curve_touches_the_point(arm, side):
    rho, point = arm
    curve = extended_obstacle(point, rho, side, 101)
    assert on_ring(rho, curve)
    upper_arm, forearm = distances(rho, side, curve, point)
    if np.hypot(*point) < rho - 1.0:  # out of the forearm's reach: what is left is the arc's end
        assert upper_arm.max() < 1e-6
    else:
        assert forearm[:-1].max() < 1e-6  # the last hand is on the rim, or in the shoulder


@given(st.floats(0.2, 0.8), st.floats(0.05, 0.95), sides)
def test_points_within_one_minus_rho_use_the_clipped_angle(rho, share, side):
    """Erratum 2: Eq. 5 is undefined there; every elbow position can reach the point."""
    point = np.array([share * (1.0 - rho), 0.0])
    assume(abs(point[0] - rho) > 1e-3)  # erratum 4: singular there
    assert reach_angle(point, rho) == pytest.approx(math.pi)
    curve = extended_obstacle(point, rho, side, 101)
    assert np.isfinite(curve).all() and on_ring(rho, curve)
    _, forearm = distances(rho, side, curve, point)
    assert forearm[:-1].max() < 1e-6 and forearm[-1] < 1e-4


@given(reachable_points(), sides)
def test_the_curve_runs_from_the_point_to_the_stretched_or_folded_arm(arm, side):
    rho, point = arm
    radius = float(np.hypot(*point))
    curve = extended_obstacle(point, rho, side, 64)
    direction = point / radius
    end = (rho + 1.0) if radius > rho else (rho - 1.0)
    np.testing.assert_allclose(curve[-1], end * direction, atol=1e-9)
    if radius >= abs(1.0 - rho):
        # At phi_max the forearm just touches with the hand itself.
        np.testing.assert_allclose(curve[0], point, atol=1e-6)


@given(reachable_points())
def test_phi_max_is_where_the_forearm_begins_to_be_long_enough(arm):
    """Erratum 3: the domain of F ends there."""
    rho, point = arm
    radius, limit = float(np.hypot(*point)), reach_angle(point, rho)
    phi = np.linspace(0.0, np.pi, 721)
    gap = np.hypot(radius - rho * np.cos(phi), rho * np.sin(phi))  # from elbow to point
    clear = np.abs(gap - 1.0) > 1e-9
    if radius >= abs(rho - 1.0):
        np.testing.assert_array_equal((gap <= 1.0)[clear], (phi <= limit)[clear])
    else:  # always or never (erratum 2)
        assert limit == (np.pi if rho < 1.0 else 0.0)
        assert (gap[clear] <= 1.0).all() == (rho < 1.0)


@given(reachable_points())
def test_the_left_arm_is_the_mirror_image(arm):
    rho, point = arm
    mirror = np.array([1.0, -1.0])
    left, right = extended_obstacle(point * mirror, rho, "left"), extended_obstacle(point, rho)
    np.testing.assert_allclose(left, right * mirror, atol=1e-9)


@given(reachable_points(), sides, st.floats(-3.0, 3.0))
def test_turning_the_point_turns_the_curves(arm, side, angle):
    rho, point = arm
    c, s = math.cos(angle), math.sin(angle)
    turn = np.array([[c, -s], [s, c]])
    turned, plain = (extended_obstacle(p, rho, side) for p in (turn @ point, point))
    np.testing.assert_allclose(turned, plain @ turn.T, atol=1e-8)


def scene(rho, side, shape, position, thickness=0.0):
    still = PlanarQuadratic(position, (0.0, 0.0), (0.0, 0.0))
    away = PlanarQuadratic((9.0, 9.0), (0.0, 0.0), (0.0, 0.0))
    bodies = (Body("target", "ball", Disc(0.1), away), Body("obstacle", "disc", shape, still))
    arm = Arm((0.5 * rho, 0.9), 1.0, rho, side, thickness=thickness)
    return Situation("scene", 1.0, arm, bodies)


def upper_arm_image(point, rho, side, n):
    """Return the hands (n, 2) whose upper arm touches a point, if any can (erratum 6)."""
    radius, angles = np.hypot(*point), SIDE[side] * np.linspace(0.0, np.pi, n)
    psi = np.arctan2(point[1], point[0]) + angles
    arc = rho * point / radius + np.stack([np.cos(psi), np.sin(psi)], axis=-1)
    return arc if radius < rho else np.zeros((0, 2))


def widened(cells):
    """Cells and their eight neighbours."""
    padded = np.pad(cells, 1)
    n, m = cells.shape
    return np.logical_or.reduce([padded[i : i + n, j : j + m] for i in range(3) for j in range(3)])


@pytest.mark.parametrize("side", ["right", "left"])
@pytest.mark.parametrize(
    ("rho", "position", "radius"),
    [
        (1.0, (1.2, 0.4), 0.12),
        (1.0, (0.3, -0.5), 0.1),
        (0.7, (0.9, 0.9), 0.15),
        (1.3, (-1, 0.3), 0.1),
    ],
)
def test_cells_are_occupied_where_the_curves_run(rho, position, radius, side):
    """The predicate against a raster of the curves of all points of the disc, within a cell."""
    lattice = Lattice(80, rho, side)
    cells = occupied_cells(scene(rho, side, Disc(radius), position), lattice, 0.0)
    rings = [
        np.array(position) + r * np.stack([np.cos(a), np.sin(a)], axis=1)
        for r in np.linspace(0.0, radius, 9)
        for a in [np.linspace(0.0, 2.0 * np.pi, 48)]
    ]
    raster = np.zeros_like(cells)
    points = [p for p in np.concatenate(rings) if np.hypot(*p) < rho + 1.0]
    images = (extended_obstacle, upper_arm_image)
    for curve in (image(p, rho, side, 160) for image in images for p in points):
        for x, y in curve:
            raster[lattice.cell_of((x, y))] = True
    assert cells.sum() > 100
    assert (cells <= widened(raster)).all()
    # At the rims the elbow swings fast: two cells of the ring are left out there.
    radius = np.hypot(*np.meshgrid(lattice.centres, lattice.centres))
    low, high = abs(rho - 1.0) + 2.0 * lattice.spacing, rho + 1.0 - 2.0 * lattice.spacing
    inner = (radius > low) & (radius < high)
    assert ((raster & inner) <= widened(cells)).all()


@pytest.mark.parametrize("thickness", [0.0, 0.08])
def test_cells_are_those_whose_limb_touches(thickness):
    situation = scene(1.1, "left", Disc(0.2), (0.8, 0.6), thickness)
    lattice = Lattice(40, 1.1, "left")
    cells = occupied_cells(situation, lattice, 0.0).ravel()
    space = hand_space(lattice)
    hands = space.limb[:, :2]
    upper_arm, forearm = distances(1.1, "left", hands, np.array([0.8, 0.6]))
    touches = np.minimum(upper_arm, forearm) <= 0.2 + thickness
    np.testing.assert_array_equal(cells, touches & space.inside)


def test_cells_follow_the_bodies_in_time():
    situation = scene(1.0, "right", Disc(0.2), (0.8, 0.6))
    moving = PlanarQuadratic((0.8, 0.6), (-1.0, 0.0), (0.0, -2.0))
    obstacle = Body("obstacle", "disc", Disc(0.2), moving)
    later = Situation("later", 1.0, situation.arm, (situation.bodies[0], obstacle))
    lattice = Lattice(40)
    there = scene(1.0, "right", Disc(0.2), (0.3, 0.35))
    np.testing.assert_array_equal(
        occupied_cells(later, lattice, 0.5), occupied_cells(there, lattice, 0.0)
    )
    assert (occupied_cells(later, lattice, 0.5) != occupied_cells(later, lattice, 0.0)).any()


def test_targets_occupy_nothing():
    situation = scene(1.0, "right", Disc(0.2), (9.0, 9.0))
    target = Body("target", "ball", Disc(0.3), PlanarQuadratic((1.0, 0.5), (0, 0), (0, 0)))
    situation = Situation("scene", 1.0, situation.arm, (target, situation.bodies[1]))
    assert not occupied_cells(situation, Lattice(40), 0.0).any()
