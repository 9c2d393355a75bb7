"""The table of suites: versions, hashes, licences and cards."""

from __future__ import annotations

import gzip
from dataclasses import dataclass
from pathlib import Path

from gcm_learn import artifacts
from gcm_learn.errors import SuiteError
from gcm_learn.storage import content_hash, write_whole

FOLDER = "benchmark"
LICENCE = "MIT"


@dataclass(frozen=True)
class Suite:
    """A frozen file of situations."""

    name: str
    version: int
    sha256: str
    """Of the file, unpacked."""
    count: int
    """Situations, without the warm-up."""
    card: str
    """Origin, use, and what is known of it."""
    licence: str = LICENCE

    @property
    def file(self) -> str:
        """Path of the file among the data."""
        return f"{FOLDER}/{self.name}-{self.version}.jsonl.gz"


_UNKNOWN = (
    "No stratum is known: some situations have no catch, and shares are of all of them. "
    "Starts that touch are left out."
)
_SEVERAL = (
    "A situation counts as caught if one of them is; the targets that are caught are counted "
    "beside it. " + _UNKNOWN
)
_PANDA = "a Panda of seven joints; six families in turns, seed 30117. " + _UNKNOWN
_TABLE = (
    Suite(
        "plane", 1,
        "fbbf56ab2642401a5bf039b4f2dfc23bc3b6c75d7345e5eb38b720164a21da13",
        100,
        "The first 25 of each of the frozen suites L, W, Q and U of `gcm-learn evaluate` (seed "
        "9108, all planar families in turns). L: a straight line catches; W: a way round; Q: "
        "waiting; U: the oracle rules all catches out; open: the oracle cannot tell.",
    ),
    Suite(
        "plane-held-out", 1,
        "95c22934ead6ee28a93dc58871f986195172e876f87d46e25d865a3aa5a4d1a0",
        75,
        "The first 25 of each of the suites `pendulum`, `long-arm` and `faster`: a family, arms "
        "and speeds that the shipped models never met in training. Strata as in `plane`.",
    ),
    Suite(
        "space", 1,
        "b7b46795d288620f3aad8e7a3715f2e8060859275a45ed72638c472e1c9b0611",
        50,
        "The suite `space-demo` of `gcm-learn evaluate` (seed 9111): arms of four joints, all "
        "families in space. Strata are what `straight` and `search` of this package say, and "
        "open means that neither catches. So shares are of all situations.",
    ),
    Suite(
        "space-accelerated", 1,
        "b987ddd2b8a2900d9a14339198f318bc2f32c1beb25274e97b3b6c796cd7e61f",
        60,
        "Families and arms of `data/specs/space-accelerated.toml` in turns, seed 30117: joints "
        "need 30 to 150 ms to come to full speed, and most move at the start. " + _UNKNOWN,
    ),
    Suite(
        "space-sequences", 1,
        "c6a56e134131b54e2b3b6a0c93567e55ab46660d93739101af1b533a102420ed",
        60,
        "The family `sequence-space`, seed 30117: three to five balls fly by arms of four joints "
        "under limits of acceleration, and most of them are to be caught. " + _SEVERAL,
    ),
    Suite(
        "panda-easy", 1,
        "62acb3e281ecb3e458bad4f1ebc2b0cf6f3c36517bee1e47fffc1996b4007e11",
        60,
        "The preset `panda-easy`: few bodies, " + _PANDA,
    ),
    Suite(
        "panda-crowded", 1,
        "d6ec76e0609c3dcaf32c0ec4123ab47413db50367f25ba1744a8134d0e78132f",
        60,
        "The preset `panda-crowded`: many bodies and prescribed approaches, " + _PANDA,
    ),
    Suite(
        "panda-crowded-accelerated", 1,
        "60eda44eda9c0ca42dc4211a4fa99421ee395e27c5c22a34c8385e7a51d4f3ca",
        60,
        "The preset `panda-crowded-accelerated`: as `panda-crowded`, and joints have limits of "
        "acceleration; " + _PANDA,
    ),
    Suite(
        "panda-sequences", 1,
        "e7dc0347bd281dc26297c5a2e48206076375add5199b0c70c3d8756f00d21547",
        60,
        "The preset `panda-sequences`, seed 30117: three to five balls drift by a Panda of seven "
        "joints under limits of acceleration, and most of them are to be caught. " + _SEVERAL,
    ),
)  # fmt: skip
SUITES: dict[str, Suite] = {suite.name: suite for suite in _TABLE}
OUTSIDE: dict[str, str] = {
    name: f"gcm-learn convert {name} SOURCE --out {name}.jsonl"
    for name in ("motionbenchmaker", "si-rrt", "table-tennis")
}
"""Suites of others, whose files are not ours to ship, and the commands that make them."""


def suite_hash(content: bytes) -> str:
    """Return the hash of the content of a suite's file, unpacked."""
    return content_hash(content)


def suite_file(suite: Suite) -> Path:
    """Return the file of a suite.

    Raises
    ------
    SuiteError
        If it is missing.
    """
    found = artifacts.find("data", suite.file)
    if found is None:
        raise SuiteError(artifacts.missing("data", f"suite {suite.file!r}"))
    return found


def write_suite(suite: Suite, content: bytes) -> str:
    """Write the file of a suite that has none yet, packed, and return its hash."""
    place = artifacts.shipped("data") / suite.file
    if place.exists():
        raise SuiteError(f"suite {suite.name!r}: version {suite.version} is written already")
    place.parent.mkdir(parents=True, exist_ok=True)
    write_whole(place, gzip.compress(content, mtime=0))
    return suite_hash(content)
