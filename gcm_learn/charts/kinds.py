"""Charts of the kinds of arms: the only file of this folder that asks which kind it has."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from gcm_learn.arms import CHAIN, PLANAR, SPATIAL, Arm, ByKind
from gcm_learn.charts.chart import Chart
from gcm_learn.charts.hand_lattice import hand_lattice_of
from gcm_learn.charts.lattice import Lattice
from gcm_learn.charts.posture_lattice import posture_lattice_of
from gcm_learn.errors import LatticeError


def _cells(arm: Arm, n: int, postures: int = 1) -> Lattice:
    if postures != 1:
        raise LatticeError(f"{postures} postures: a cell of a planar arm has 1")
    return Lattice(n, arm.upper_arm, arm.elbow)


CHARTS: ByKind[Callable[..., Chart]] = ByKind(
    {PLANAR: _cells, SPATIAL: posture_lattice_of, CHAIN: hand_lattice_of}, who="a front"
)
_LATTICES: ByKind[Callable[[Any], Lattice]] = ByKind(
    {PLANAR: lambda chart: chart}, who="a lattice of the plane"
)


def chart_of(subject: Any, n: int, postures: int = 1) -> Chart:
    """Return the default chart of an arm's hand-space, n cells along a side.

    Parameters
    ----------
    subject : Arm, SpatialArm, Chain or Situation
        An arm or what has one.
    n : int
        Cells along a side.
    postures : int
        Postures in a cell; more than one for spatial arms only.

    Raises
    ------
    ArmKindError
        If there are no charts for arms of this kind.
    LatticeError
        If the size or the number of postures is out of range.
    """
    return CHARTS.of(subject)(getattr(subject, "arm", subject), n, postures)


def lattice_of(chart: Chart) -> Lattice:
    """Return a chart that is the lattice of a planar arm.

    Raises
    ------
    ArmKindError
        If it is a chart of another kind of arm.
    """
    return _LATTICES.of(chart.kind)(chart)
