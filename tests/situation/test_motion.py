"""Motion laws check their vectors."""

from __future__ import annotations

import math

import pytest

from gcm_learn.errors import SituationError
from gcm_learn.situation import Pendulum, PlanarQuadratic, SolidQuadratic

PLANAR = {"position": (1, 2), "velocity": (0, 0), "acceleration": (0, -1)}
SOLID = {"position": (1, 2, 3), "velocity": (0, 0, 0), "acceleration": (0, -1, 0)}
PENDULUM = {
    "pivot": (0, 0, 5),
    "axis": (0, 1, 0),
    "down": (0, 0, -1),
    "length": 5,
    "gravity": 70,
    "angle": 0.5,
    "rate": 0,
}


LAWS = {
    "planar": (PlanarQuadratic, PLANAR),
    "solid": (SolidQuadratic, SOLID),
    "pendulum": (Pendulum, PENDULUM),
}


def test_defaults():
    planar = PlanarQuadratic(**PLANAR)
    assert (planar.angle, planar.spin) == (0.0, 0.0)
    solid = SolidQuadratic(**SOLID)
    assert (solid.orientation, solid.spin) == ((1.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    pendulum = Pendulum(**PENDULUM)
    assert (pendulum.damping, pendulum.hang, pendulum.hang_distance) == (0.0, None, 5.0)
    assert Pendulum(**PENDULUM, hang=2).hang_distance == 2.0


@pytest.mark.parametrize(
    ("law", "change", "expected"),
    [
        ("planar", {"position": (1, 2, 3)}, "position: must be a list of 2 numbers (got 3)"),
        ("planar", {"velocity": (1, True)}, "velocity[1]: must be a number (got true)"),
        ("planar", {"acceleration": None}, "acceleration: must be a list of 2 numbers (got null)"),
        ("planar", {"angle": math.inf}, "angle: must be finite (got inf)"),
        ("planar", {"spin": (0, 0, 1)}, "spin: must be a number (got a list of 3)"),
        ("solid", {"position": (1, 2)}, "position: must be a list of 3 numbers (got 2)"),
        ("solid", {"spin": 2.0}, "spin: must be a list of 3 numbers (got 2.0)"),
        ("solid", {"orientation": (1, 0, 0)}, "orientation: must be a list of 4 numbers (got 3)"),
        (
            "solid",
            {"orientation": (1, 0, 0, 0.1)},
            "orientation: must have length 1 (got 1.00498756)",
        ),
        ("solid", {"orientation": (0, 0, 0, 0)}, "orientation: must have length 1 (got 0)"),
        ("pendulum", {"axis": (0, 2, 0)}, "axis: must have length 1 (got 2)"),
        ("pendulum", {"down": (0, 0, 0)}, "down: must have length 1 (got 0)"),
        ("pendulum", {"down": (0, 0.6, 0.8)}, "down: must be orthogonal to axis (dot product 0.6)"),
        ("pendulum", {"length": 0}, "length: must be positive (got 0.0)"),
        ("pendulum", {"gravity": -1}, "gravity: must not be negative (got -1.0)"),
        ("pendulum", {"rate": "fast"}, 'rate: must be a number (got "fast")'),
        ("pendulum", {"damping": -0.1}, "damping: must not be negative (got -0.1)"),
        ("pendulum", {"hang": -2}, "hang: must not be negative (got -2.0)"),
        ("pendulum", {"hang": False}, "hang: must be a number (got false)"),
    ],
)
def test_laws_refuse(law, change, expected):
    record, fields = LAWS[law]
    with pytest.raises(SituationError) as caught:
        record(**fields | change)
    assert str(caught.value) == expected


def test_unit_vectors_may_be_off_by_rounding():
    third = 1 / math.sqrt(3)
    rounded = tuple(round(x, 7) for x in (third, third, third))
    assert Pendulum(**PENDULUM | {"axis": rounded, "down": (0.70710678, -0.70710678, 0)})
