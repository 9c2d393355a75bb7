"""Small specifications, and a small dataset that many tests read."""

from __future__ import annotations

import pytest

pytest.importorskip("pyarrow")

from gcm_learn import dataset
from gcm_learn.dataset import DatasetSpec, FamilyShare, Holdout, Split
from gcm_learn.dataset.folder import Folder
from gcm_learn.dataset.manifest import manifest_of, write_manifest
from gcm_learn.dataset.shards import make_shard

SMALL = DatasetSpec(
    "small", seed=3, count=50, families=(FamilyShare("random-planar"),),
    planners=("marching", "layered"), map="marching", n=40, rungs=2, shard_size=20,
)  # fmt: skip

MARKED = DatasetSpec(
    "marked", seed=5, count=80, planners=("layered",), map="none", n=40, rungs=1, shard_size=80,
    families=(
        FamilyShare("moving-point", config={"arm": {"grasp": [0.05, 0.05]}}),
        FamilyShare("static-clutter", config={"arm": {"grasp": [0.06, 0.06]}}),
        FamilyShare("gate", config={"arm": {"grasp": [0.08, 0.08]}}),
    ),
    split=Split(validation=0.25, test=0.25),
    holdouts=(
        Holdout("test-gate", family="gate"), Holdout("test-long", quantity="upper_arm", above=1.1),
    ),
)  # fmt: skip
"""Two families are for training, one is held out; what a hand grasps tells which it is."""


SPACE = DatasetSpec(
    "space", seed=7, count=12, planners=("straight", "search"), map="none", shard_size=4,
    families=tuple(map(FamilyShare, ("window-space", "late-target-space", "pendulum-space"))),
)  # fmt: skip
SLOW_BELTS = {"parts": [2, 3], "posts": [0, 1], "directed": 0.0, "pace": [0.05, 0.2]}
LIMITED = {"accelerations": [15.0, 7.5, 10.0, 12.5, 15.0, 20.0, 20.0]}
PICKED = {"holds": {"share": 1.0}, "bins": {"share": 1.0}, "arm": LIMITED}
PICKS = DatasetSpec(
    "picks", seed=7, count=3, planners=("search",), map="none", shard_size=4,
    families=(FamilyShare("drawer-chain", config=PICKED),),
)  # fmt: skip
CHAINS = DatasetSpec(
    "chains", seed=7, count=8, planners=("straight", "search"), map="none", shard_size=4,
    families=(
        FamilyShare("conveyor-chain", 2.0, SLOW_BELTS), FamilyShare("falling-chain"),
        FamilyShare("other-arm-chain"),
    ),
    holdouts=(Holdout("test-others", family="other-arm-chain"),),
)  # fmt: skip


@pytest.fixture
def small() -> DatasetSpec:
    """Return a specification of 50 items in three shards, quick to make."""
    return SMALL


def make_here(spec: DatasetSpec, folder: str) -> None:
    """Make a dataset in this process."""
    place = Folder(folder)
    place.make()
    infos = {shard: make_shard(spec, shard, folder) for shard in range(spec.shards)}
    write_manifest(place, manifest_of(place, spec, infos, []))


@pytest.fixture
def records(small_folder):
    """Return the records of that dataset."""
    return dataset.open(small_folder)
