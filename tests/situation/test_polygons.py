"""Only simple counter-clockwise polygons pass, and the decision is exact."""

import math
import time
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from gcm_learn.errors import SituationError
from gcm_learn.situation import Polygon
from gcm_learn.situation.shapes import orientation
from tests.refusals import refusal

SQUARE = ((0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0))


IN_LINE = "the 3 points lie in line and enclose no area"
CLOCKWISE = "the points run clockwise, not counter-clockwise"
CORRIDORS = [
    (0, 0), (3, 0), (3, 2), (2, 2), (2, 1), (1, 1), (1, 0), (0.5, 0), (0.5, 3), (0, 3),
]  # fmt: skip
"""Edges of two different corridors on the same line."""
REFUSED = [
    ([], ": must have at least 3 points (got 0)"),
    (SQUARE[:2], ": must have at least 3 points (got 2)"),
    ("square", ': must be a list of points (got "square")'),
    ([(0, 0), 1, (0, 1)], "[1]: must be a list of 2 numbers (got 1)"),
    ([(0, 0), (1, 0, 0), (0, 1)], "[1]: must be a list of 2 numbers (got 3)"),
    ([(0, 0), (1, math.nan), (0, 1)], "[1][1]: must be finite (got nan)"),
    ((*SQUARE[:2], *SQUARE[1:]), ": point 2 repeats point 1: (1.0, 0.0)"),
    ((*SQUARE, SQUARE[0]), ": point 0 repeats point 4: (0.0, 0.0)"),
    ([(0, 0), (1, 1), (3, 3)], f": {IN_LINE}"),
    ([(0, 0), (0.1, 0.3), (0.2, 0.6)], f": {IN_LINE}"),
    (SQUARE[::-1], f": {CLOCKWISE}"),
    ([(0, 0), (1e-300, 0), (0, -1e-300)], f": {CLOCKWISE}"),
    ([(0, 0), (1e50, 0), (0, -1e50)], f": {CLOCKWISE}"),
    ([(0, 0), (1, 1), (1, 0), (0, 1)], ": edges 0 and 2 of 4 cross or touch"),
    # a spike out of a corner, and one into it
    ([(0, 0), (2, 0), (1, 0), (0, 1)], ": the edges at point 1 (2.0, 0.0) overlap"),
    ([(0, 0), (1, 0), (0, 1), (0, 2)], ": the edges at point 3 (0.0, 2.0) overlap"),
    # a corner on another edge, and on another corner
    ([(0, 0), (2, 0), (2, 2), (1, 0), (0, 2)], ": edges 0 and 3 of 5 cross or touch"),
    ([(0, 0), (2, 0), (1, 1), (2, 2), (0, 2), (1, 1)], ": edges 1 and 4 of 6 cross or touch"),
    (CORRIDORS, ": edges 0 and 6 of 10 cross or touch"),
]


@pytest.mark.parametrize(("vertices", "reason"), REFUSED)
def test_refused(vertices, reason):
    assert refusal(SituationError, Polygon, vertices) == f"vertices{reason}"


@pytest.mark.parametrize(
    "vertices",
    [
        SQUARE,
        [(0, 0), (1, 0), (2, 0), (0, 1)],  # a corner in the middle of a side
        [(0, 0), (3, 0), (3, 3), (2, 3), (2, 1), (1, 1), (1, 3), (0, 3)],  # U
        [(0, 0), (1e-300, 0), (0, 1e-300)],
        [(0, 0), (5e-324, 0), (0, 5e-324)],
        [(-1e50, -1e50), (1e50, -1e50), (0, 1e50)],
        # a notch that stays off the opposite side by one unit in the last place
        [(0, 0), (1, 0), (1, 1), (0.5, math.ulp(0.0)), (0, 1)],
    ],
)
def test_accepted(vertices):
    assert len(Polygon(vertices).vertices) == len(vertices)


@pytest.mark.parametrize(("points", "rounds"), [(5, 2), (7, 2), (7, 3), (40, 3), (40, 19)])
@pytest.mark.parametrize("turn", np.linspace(0.0, 2.0 * np.pi, 9))
def test_a_star_that_turns_left_at_every_point_is_refused(points, rounds, turn):
    """Like a convex polygon, but it turns more than once round: its edges cross."""
    corners = turn + 2.0 * np.pi * rounds * np.arange(points) / points
    with pytest.raises(SituationError, match="cross or touch"):
        Polygon(tuple((math.cos(a), math.sin(a)) for a in corners))


def test_polygons_of_many_points_are_quick():
    turns = np.arange(3000) * 2 * math.pi / 3000
    circle = np.stack((np.cos(turns), np.sin(turns)), axis=1)
    star = circle * (1 - 0.8 * (np.arange(3000) % 2))[:, None]
    Polygon(SQUARE)  # compiles what is not compiled yet
    start = time.perf_counter()
    assert Polygon(star).bounding_radius == Polygon(circle).bounding_radius == 1.0
    assert time.perf_counter() - start < 2.0  # takes 0.01 s, quadratic Python took 1.3 s
    with pytest.raises(SituationError, match="clockwise"):
        Polygon(circle[::-1])


grid = st.integers(-3, 3).map(lambda k: 0.1 * k)
points = st.tuples(grid, grid)


@given(points, points, points)
def test_orientation_is_exact(a, b, c):
    ax, ay, bx, by, cx, cy = map(Fraction, (*a, *b, *c))
    turn = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
    assert orientation(a, b, c) == (turn > 0) - (turn < 0)


def verdict(vertices):
    try:
        Polygon(vertices)
    except SituationError as error:
        return "clockwise" if "clockwise" in error.reason else "not simple"
    return "counter-clockwise"


@given(st.lists(st.tuples(st.integers(0, 4), st.integers(0, 4)), min_size=3, max_size=6))
def test_same_verdict_for_every_first_point_and_the_mirror_image(corners):
    first = verdict(corners)
    for k in range(1, len(corners)):
        assert verdict(corners[k:] + corners[:k]) == first
    other = {"clockwise": "counter-clockwise", "counter-clockwise": "clockwise"}
    assert verdict([(-x, y) for x, y in corners]) == other.get(first, first)
    assert verdict(corners[::-1]) == other.get(first, first)


def on_segment(a, b, p):
    line = (b[0] - a[0]) * (p[1] - a[1]) == (b[1] - a[1]) * (p[0] - a[0])
    return line and all(min(a[k], b[k]) <= p[k] <= max(a[k], b[k]) for k in (0, 1))


def brute_force_verdict(corners):
    """Compare every two edges, and look at the sign of the area, in rational arithmetic."""
    points = [tuple(map(Fraction, corner)) for corner in corners]
    edges = list(zip(points, points[1:] + points[:1], strict=True))
    if any(a == b for a, b in edges):
        return "not simple"
    for k, (a, b) in enumerate(edges):
        for c, d in edges[:k]:
            if any(on_segment(a, b, p) and p not in (a, b) for p in (c, d)):
                return "not simple"
            if any(on_segment(c, d, p) and p not in (c, d) for p in (a, b)):
                return "not simple"
            if turn(a, b, c) * turn(a, b, d) < 0 and turn(c, d, a) * turn(c, d, b) < 0:
                return "not simple"
    if len(set(points)) < len(points):
        return "not simple"
    area = sum(a[0] * b[1] - b[0] * a[1] for a, b in edges)
    return "counter-clockwise" if area > 0 else "clockwise"


def turn(a, b, c):
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])


@settings(max_examples=400)
@given(st.lists(points, min_size=3, max_size=7))
def test_verdict_is_that_of_brute_force(corners):
    assert verdict(corners) == brute_force_verdict(corners)


@given(st.integers(4, 8), st.data())
def test_swapping_two_corners_of_a_convex_polygon_spoils_it(count, data):
    corners = [(math.cos(k), math.sin(k)) for k in np.arange(count) * 2 * math.pi / count]
    i, j = data.draw(st.lists(st.integers(0, count - 1), min_size=2, max_size=2, unique=True))
    corners[i], corners[j] = corners[j], corners[i]
    # opposite corners of a quadrilateral: only its direction changes
    expected = "clockwise" if count == 4 and abs(i - j) == 2 else "cross"
    with pytest.raises(SituationError, match=expected):
        Polygon(corners)
