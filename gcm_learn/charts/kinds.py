"""Charts by the kind of arm; no other file of this folder branches on the kind."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from gcm_learn.arms import PLANAR, ByKind
from gcm_learn.charts.chart import Chart
from gcm_learn.charts.hand_lattice import HandLattice
from gcm_learn.charts.lattice import Lattice

CHARTS: ByKind[Callable[..., Chart]] = ByKind(
    {PLANAR: lambda arm, n: Lattice(n, arm.upper_arm, arm.elbow)}, default=HandLattice
)
_LATTICES: ByKind[Callable[[Any], Lattice]] = ByKind(
    {PLANAR: lambda chart: chart}, who="a lattice of the plane"
)


def chart_of(subject: Any, n: int) -> Chart:
    """Return the default chart of an arm's hand-space, n cells along a side.

    Parameters
    ----------
    subject : Arm, SpatialArm, Chain or Situation
        An arm or what has one.
    n : int
        Cells along a side.

    Raises
    ------
    LatticeError
        If the size is out of range.
    """
    return CHARTS.of(subject)(getattr(subject, "arm", subject), n)


def lattice_of(chart: Chart) -> Lattice:
    """Return a chart that is the lattice of a planar arm.

    Raises
    ------
    ArmKindError
        If it is a chart of another kind of arm.
    """
    return _LATTICES.of(chart.kind)(chart)
