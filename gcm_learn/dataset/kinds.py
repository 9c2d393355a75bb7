"""The table of records by kind of arm: columns, numbers, cases, and what else a dataset has."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import pyarrow as pa

from gcm_learn.arms import CHAIN, PLANAR, SPATIAL, ByKind, Kind
from gcm_learn.dataset import arm_columns as columns
from gcm_learn.dataset.arm_columns import Types
from gcm_learn.dataset.cases import Case, ChainCase, PlanarCase, SpatialCase
from gcm_learn.situation import Frame, SpatialFrame


@dataclass(frozen=True)
class RecordKind:
    """Records of situations with one kind of arm."""

    version: str
    """Format of records."""
    plan: pa.StructType
    """Columns of a plan."""
    base: Types
    """Columns of the arm's base, empty without a base."""
    path_cells: Callable[[Any], dict[str, Any]]
    """Cells of a plan's path."""
    path: Callable[[Any, Mapping[str, Any]], Any]
    """Path of an arm, of its cells."""
    frame: Callable[..., Frame | SpatialFrame]
    """Frame of base, angle and mirroring."""
    word: Callable[[Any], str]
    """Name of the arm in a situation's structure."""
    numbers: Callable[[Any, float], list[float]]
    """Parameters of an arm, for a horizon [s]."""
    forearm: Callable[[Any], float]
    """Length of an arm's forearm."""
    sizes: Callable[[Any], tuple[float, float]]
    """Length of the upper arm and top speed of the hand of a situation's arm."""
    case: type[Case]
    """A situation with the answers of planners to it."""
    maps: bool
    """True if records may have maps."""
    efforts: bool
    """True if the effort of a search may be limited."""
    oracle: bool = True
    """True if there is an oracle that labels."""
    several: bool = False
    """True if a plan may have several catches."""


RECORDS = ByKind(
    {
        PLANAR: RecordKind(
            version="gcm-learn/record@1",
            plan=columns.HAND_PLAN,
            base={},
            path_cells=columns.hand_cells,
            path=columns.hand_path,
            frame=columns.planar_frame,
            word=columns.planar_word,
            numbers=columns.planar_numbers,
            forearm=columns.planar_forearm,
            sizes=columns.planar_sizes,
            case=PlanarCase,
            maps=True,
            efforts=False,
        ),
        SPATIAL: RecordKind(
            version="gcm-learn/record@2",
            plan=columns.JOINT_PLAN,
            base=columns.BASE,
            path_cells=columns.joint_cells,
            path=columns.joint_path,
            frame=columns.spatial_frame,
            word=columns.spatial_word,
            numbers=columns.spatial_numbers,
            forearm=columns.spatial_forearm,
            sizes=columns.spatial_sizes,
            case=SpatialCase,
            maps=False,
            efforts=True,
        ),
        CHAIN: RecordKind(
            version="gcm-learn/record@3",
            plan=columns.CHAIN_PLAN,
            base=columns.BASE,
            path_cells=columns.joint_cells,
            path=columns.joint_path,
            frame=columns.spatial_frame,
            word=columns.chain_word,
            numbers=columns.chain_numbers,
            forearm=columns.chain_reach,
            sizes=columns.chain_sizes,
            case=ChainCase,
            maps=False,
            efforts=False,
            oracle=False,
            several=True,
        ),
    },
    who="dataset",
)
VERSIONS = tuple(kind.version for kind in RECORDS.entries())


def kind_of_version(version: str) -> Kind:
    """Return the kind of arm whose records have a format."""
    return next(kind for kind in RECORDS if RECORDS.of(kind).version == version)
