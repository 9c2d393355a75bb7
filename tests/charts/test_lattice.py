"""The lattice over hand-space."""

from __future__ import annotations

import numpy as np
import pytest

from gcm_learn.arms import Arm
from gcm_learn.charts import Lattice
from gcm_learn.charts.lattice import hand_space
from gcm_learn.errors import LatticeError
from tests.planar_geometry import elbow_of

ARMS = [(1.0, "right"), (0.7, "left"), (1.4, "right")]


def test_it_covers_the_disc_of_the_reach():
    lattice = Lattice(80, 1.0)
    assert lattice.spacing == pytest.approx(0.05)
    assert lattice.extent == (-2.0, 2.0, -2.0, 2.0)
    assert lattice.centres[0] == pytest.approx(-1.975)
    np.testing.assert_allclose(np.diff(lattice.centres), 0.05)
    np.testing.assert_allclose(lattice.centres, -lattice.centres[::-1], atol=1e-12)


def test_an_unknown_side_is_refused():
    with pytest.raises(LatticeError, match=r"elbow.*'up'"):
        Lattice(80, 1.0, "up")


@pytest.mark.parametrize(("rho", "elbow"), ARMS)
def test_hand_space_knows_every_cell(rho, elbow):
    lattice = Lattice(40, rho, elbow)
    space = hand_space(lattice)
    x, y = np.meshgrid(lattice.centres, lattice.centres)
    np.testing.assert_allclose(space.limb[:, 0].reshape(40, 40), x)
    np.testing.assert_allclose(space.limb[:, 1].reshape(40, 40), y)
    radius = np.hypot(x, y)
    ring = (radius <= rho + 1.0) & (radius >= abs(rho - 1.0))
    np.testing.assert_array_equal(space.inside.reshape(40, 40), ring)
    arm = Arm(hand=(rho, 1.0) if rho < 1 else (1.0, 0.5), max_hand_speed=1.0, upper_arm=rho)
    arm = Arm(arm.hand, 1.0, rho, elbow)
    inside = space.limb[space.inside]
    np.testing.assert_allclose(inside[:, 2:], elbow_of(arm, inside[:, :2]), atol=1e-7)


@pytest.mark.parametrize(("rho", "elbow"), ARMS)
def test_the_stride_is_the_way_of_the_limb_to_the_edges_of_the_cell(rho, elbow):
    lattice = Lattice(40, rho, elbow)
    space, half = hand_space(lattice), 0.5 * lattice.spacing
    arm = Arm((1.0, 0.5), 1.0, rho, elbow)
    hand, here = space.limb[:, :2], space.limb[:, 2:]
    for step in ((half, 0.0), (-half, 0.0), (0.0, half), (0.0, -half)):
        moved = np.linalg.norm(elbow_of(arm, hand + step) - here, axis=1)
        assert (moved[space.inside] <= space.stride[space.inside] + 1e-7).all()
    assert (space.stride >= half).all()


def test_shared_arrays_are_read_only():
    for array in hand_space(Lattice(20)):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0
