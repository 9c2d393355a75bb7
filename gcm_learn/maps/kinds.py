"""Maps by the kind of arm: the only file of this folder that asks which kind it has."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict
from typing import Any, NamedTuple

from gcm_learn.arms import CHAIN, PLANAR, SPATIAL, Base, ByKind, Chain, SpatialArm
from gcm_learn.charts import Chart, HandLattice, Lattice, PostureLattice
from gcm_learn.errors import FileFormatError
from gcm_learn.situation import arm_from_json, arm_to_json
from gcm_learn.wave import MarchingParams, WaveParams

IN_SPACE = MarchingParams(n=40, margin=0.0)
"""Moves in space are judged for what they are, so that cells need no margin."""


class MapKind(NamedTuple):
    """Differences between maps of several kinds of arms."""

    format: str
    """Format of files."""
    header: Callable[[Any], dict[str, Any]]
    """Entries of a file's header for a chart."""
    chart: Callable[[dict[str, Any]], Chart]
    """Chart of a file's header."""
    hand: Callable[[Any, Any], tuple[float, ...]]
    """Hand of an arm at t = 0 in the frame of a chart."""
    params: WaveParams | MarchingParams
    """Default of `build_map`."""


def _lattice_header(chart: Lattice) -> dict[str, Any]:
    return {"n": chart.n, "upper_arm": chart.upper_arm, "elbow": chart.elbow}


def _lattice(header: dict[str, Any]) -> Lattice:
    return Lattice(header["n"], header["upper_arm"], header["elbow"])


def _space_header(chart: PostureLattice) -> dict[str, Any]:
    return {"n": chart.n, "postures": chart.postures, "arm": asdict(chart.arm)}


def _space(header: dict[str, Any]) -> PostureLattice:
    arm = header["arm"] | {"base": Base(**header["arm"]["base"])}
    return PostureLattice(SpatialArm(**arm), header["n"], header["postures"])


def _chain_header(chart: HandLattice) -> dict[str, Any]:
    arm = chart.arm
    given = {"joints": arm.joints, "grasp": arm.grasp, "base": asdict(arm.base)}
    return {"n": chart.n, "arm": given | {"model": arm_to_json(arm.model)}}


def _chain(header: dict[str, Any]) -> HandLattice:
    arm = header["arm"]
    arm |= {"model": arm_from_json(arm["model"]), "base": Base(**arm["base"])}
    return HandLattice(Chain(**arm), header["n"])


MAPS = ByKind(
    {
        PLANAR: MapKind(
            "gcm-learn/map@1",
            _lattice_header,
            _lattice,
            lambda arm, chart: arm.hand,
            WaveParams(),
        ),
        SPATIAL: MapKind(
            "gcm-learn/map@2",
            _space_header,
            _space,
            lambda arm, chart: chart.hand,
            IN_SPACE,
        ),
        CHAIN: MapKind(
            "gcm-learn/map@3",
            _chain_header,
            _chain,
            lambda arm, chart: chart.hand,
            IN_SPACE,
        ),
    },
    who="a map",
)


def header_of(chart: Chart) -> dict[str, Any]:
    """Return the header of a file for a chart."""
    kind = MAPS.of(chart.kind)
    return {"format": kind.format} | kind.header(chart)


def chart_from(header: dict[str, Any]) -> Chart:
    """Return the chart of a file's header.

    Raises
    ------
    FileFormatError
        If the format is none of the formats of maps.
    """
    for kind in MAPS.entries():
        if kind.format == header["format"]:
            return kind.chart(header)
    known = " or ".join(repr(kind.format) for kind in MAPS.entries())
    raise FileFormatError(f"format is {header['format']!r}, expected {known}")
