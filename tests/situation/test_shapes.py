"""Shapes check their sizes and know how far they reach."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given

from gcm_learn.errors import SituationError
from gcm_learn.situation import Box, Capsule, Cylinder, Disc, Polygon, Sphere
from tests import strategies

SIZES = {
    Disc: ("radius",),
    Sphere: ("radius",),
    Capsule: ("radius", "half_length"),
    Cylinder: ("radius", "half_length"),
}
CASES = [(record, name) for record, names in SIZES.items() for name in names]


def build(record, name, value):
    return record(**{field: value if field == name else 1.0 for field in SIZES[record]})


@pytest.mark.parametrize(("record", "name"), CASES)
@pytest.mark.parametrize(
    ("value", "reason"),
    [
        (0, "must be positive (got 0.0)"),
        (-0.5, "must be positive (got -0.5)"),
        (math.nan, "must be finite (got nan)"),
        (-math.inf, "must be finite (got -inf)"),
        (1e51, "is too large (1e+51, max 1e+50)"),
        (10**400, "is too large (an integer of 1329 bits, max 1e+50)"),
        pytest.param(10**5000, "is too large (an integer of 16610 bits, max 1e+50)", id="10**5000"),
        (True, "must be a number (got true)"),
        (None, "must be a number (got null)"),
        ("1", 'must be a number (got "1")'),
        ([1.0], "must be a number (got a list of 1)"),
        ({}, "must be a number (got an object)"),
        (1j, "must be a number (got a value of type complex)"),
    ],
)
def test_sizes_are_positive_numbers(record, name, value, reason):
    with pytest.raises(SituationError) as caught:
        build(record, name, value)
    assert str(caught.value) == f"{name}: {reason}"


@pytest.mark.parametrize(
    ("value", "message"),
    [
        ((1.0, 2.0), "half_extents: must be a list of 3 numbers (got 2)"),
        ((1.0, 2.0, 0.0), "half_extents[2]: must be positive (got 0.0)"),
        ((1.0, "a", 1.0), 'half_extents[1]: must be a number (got "a")'),
        (1.0, "half_extents: must be a list of 3 numbers (got 1.0)"),
        ("123", 'half_extents: must be a list of 3 numbers (got "123")'),
    ],
)
def test_box_refuses(value, message):
    with pytest.raises(SituationError) as caught:
        Box(value)
    assert str(caught.value) == message


def test_numbers_are_stored_as_plain_floats_and_tuples():
    box = Box(np.array([1, 2, 3]))
    assert box.half_extents == (1.0, 2.0, 3.0)
    assert [type(x) for x in box.half_extents] == [float] * 3
    polygon = Polygon([[0, 0], [np.float32(1), 0], (0, np.int64(1))])
    assert polygon.vertices == ((0.0, 0.0), (1.0, 0.0), (0.0, 1.0))
    assert {type(x) for corner in polygon.vertices for x in corner} == {float}
    assert hash(box) == hash(Box((1.0, 2.0, 3.0)))


@pytest.mark.parametrize(
    ("shape", "radius"),
    [
        (Disc(0.3), 0.3),
        (Polygon(((-3, -4), (1, 0), (0, 1))), 5.0),
        (Sphere(0.2), 0.2),
        (Box((2, 3, 6)), 7.0),
        (Capsule(0.5, 2.0), 2.5),
        (Cylinder(3.0, 4.0), 5.0),
    ],
)
def test_bounding_radius(shape, radius):
    assert shape.bounding_radius == pytest.approx(radius, rel=1e-15)


@given(strategies.polygons())
def test_star_shaped_polygons_are_accepted(polygon):
    assert polygon.bounding_radius <= 0.5 + 1e-12
