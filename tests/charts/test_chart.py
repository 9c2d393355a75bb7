"""Charts of all kinds of arms obey the same laws."""

from __future__ import annotations

import numpy as np
import pytest

from gcm_learn import charts
from gcm_learn.errors import ArmKindError, LatticeError
from gcm_learn.situation import situation_from_json
from tests.situation.scenes import NAO, PLANAR

BALL = {"kind": "sphere", "radius": 0.1}
STILL = {"kind": "quadratic", "position": [1, 0, 0], "velocity": [0] * 3, "acceleration": [0] * 3}
CHAIN = {
    "format": "gcm-learn/situation@3",
    "name": "links",
    "horizon": 1.5,
    "arm": {"kind": "chain", "model": "planar-2", "posture": [0.3, -0.5], "grasp": 0.05},
    "catch": "any",
    "bodies": [{"role": "target", "name": "ball", "shape": BALL, "motion": STILL}],
}
PLANE, SPACE, LINKS = (situation_from_json(data) for data in (PLANAR, NAO, CHAIN))
CHARTS = {
    "short arm": charts.Lattice(33, 0.6),
    "paper's arm": charts.Lattice(33, 1.0),
    "long arm": charts.Lattice(33, 1.7),
    "space": charts.HandLattice(SPACE.arm, 17),
    "chain": charts.HandLattice(LINKS.arm, 16),
}


@pytest.mark.parametrize("chart", CHARTS.values(), ids=CHARTS)
def test_every_centre_lies_in_its_own_cell(chart):
    hands, dimensions = chart.hands, chart.hands.shape[1]
    assert len(hands) == chart.size == np.prod(chart.shape)
    for node in range(0, chart.size, 7):
        index = np.unravel_index(node, chart.shape)
        assert chart.cell_of(hands[node]) == index[:dimensions]
        np.testing.assert_allclose(chart.centres[list(index[:dimensions])[::-1]], hands[node])
        np.testing.assert_allclose(chart.hand_at(node), hands[node])
    corner = [-99.0] + [99.0] * (dimensions - 1)
    assert chart.cell_of(corner) == (chart.n - 1,) * (dimensions - 1) + (0,)


@pytest.mark.parametrize("chart", CHARTS.values(), ids=CHARTS)
def test_a_contact_reaches_the_corners_of_a_cell(chart):
    half = 0.5 * np.sqrt(chart.hands.shape[1])
    assert half <= chart.half_diagonal <= 1.01 * half
    assert chart.n * chart.spacing == pytest.approx(2.0 * chart.reach)


@pytest.mark.parametrize(
    ("subject", "n", "most"),
    [
        (PLANE, charts.SMALLEST_LATTICE - 1, charts.LARGEST_LATTICE),
        (PLANE, charts.LARGEST_LATTICE + 1, charts.LARGEST_LATTICE),
        (SPACE, charts.SMALLEST_LATTICE - 1, charts.LARGEST_HAND_LATTICE),
        (LINKS, charts.LARGEST_HAND_LATTICE + 1, charts.LARGEST_HAND_LATTICE),
    ],
)
def test_absurd_sizes_are_refused_with_the_numbers(subject, n, most):
    with pytest.raises(LatticeError, match=rf"outside \d+\.\.{most}"):
        charts.chart_of(subject, n)


def test_the_kind_of_arm_chooses_the_chart():
    assert charts.chart_of(PLANE, 20) == charts.Lattice(20, PLANE.arm.upper_arm, PLANE.arm.elbow)
    assert charts.chart_of(SPACE.arm, 20) == charts.HandLattice(SPACE.arm, 20)
    assert charts.lattice_of(charts.chart_of(PLANE.arm, 20)).kind is charts.chart_of(PLANE, 20).kind
    with pytest.raises(ArmKindError, match="does not take spatial arms"):
        charts.lattice_of(charts.chart_of(SPACE, 20))
    assert charts.chart_of(LINKS, 20) == charts.HandLattice(LINKS.arm, 20)
    with pytest.raises(ArmKindError, match="does not take chains"):
        charts.lattice_of(charts.chart_of(LINKS, 20))
