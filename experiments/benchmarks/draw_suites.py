"""Draw the suites of the benchmark again; what is drawn is compared with the files that ship.

python -m experiments.benchmarks.draw_suites              compares all suites
python -m experiments.benchmarks.draw_suites NAME --out F   writes a suite to a file

Situations of a shipped version never change: another draw is another version.
"""

from __future__ import annotations

import argparse
import gzip
from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from functools import partial
from itertools import islice
from pathlib import Path

from gcm_learn import families
from gcm_learn.arms import PLANAR, kind_of
from gcm_learn.dataset import read_spec
from gcm_learn.evaluation import SHIPPED, Case, cases, suite_lines
from gcm_learn.motion import start_clearance
from gcm_learn.planners import bounds
from gcm_learn.scene import pack
from gcm_learn.situation import AnySituation
from gcm_learn.storage import content_hash

FROZEN = 50  # of a suite whose hash `evaluation` knows
SEED = 30_117
FORMER = {"held-out": "pendulum"}  # names of suites in names of situations
SPACE_SPEC = "data/specs/space-accelerated.toml"


def items() -> dict[str, Callable[[], list[Case]]]:
    """Return what draws each suite, by name."""
    presets = ("panda-easy", "panda-crowded", "panda-crowded-accelerated", "panda-sequences")
    return {
        "plane": lambda: frozen("L", "W", "Q", "U"),
        "plane-held-out": lambda: frozen("held-out", "long-arm", "faster"),
        "space": space,
        "space-accelerated": accelerated,
        "space-sequences": sequences,
    } | {name: partial(preset, name) for name in presets}


def frozen(*names: str) -> list[Case]:
    """Return a warm-up and the first 25 of each suite, whose first 50 have the hash they should."""
    drawn = [cases(name, count=FROZEN) for name in names]
    rest = (_item(case) for found in drawn for case in found[:25])
    return [_warm_up(drawn[0][25].situation), *rest]


def space() -> list[Case]:
    """Return equal parts of what two planners say of situations in space; their U is open."""
    drawn = cases("space-demo", count=FROZEN + 1)
    return [_warm_up(drawn[FROZEN].situation), *(_item(case) for case in drawn[:FROZEN])]


def accelerated() -> list[Case]:
    """Return families of a specification in turns, joints with limits of acceleration."""
    shares = read_spec(SPACE_SPEC).families
    members = [families.family_from_dict({"family": s.family, **s.config}) for s in shares]
    return _free(members[k % len(members)] for k in range(10**6))


def sequences() -> list[Case]:
    """Return situations in space that ask for most of three to five targets."""
    (family,) = families.preset_families("space-sequences")
    return _free(family for _ in range(10**6))


def preset(name: str) -> list[Case]:
    """Return items of a preset."""
    return _free(name for _ in range(10**6))


def _free(sources: Iterable[str | families.Family]) -> list[Case]:
    """Return a warm-up and 60 situations that do not begin with a touch."""
    drawn = list(islice(_drawn(sources), 61))
    return [_warm_up(drawn[60].situation), *drawn[:60]]


def _drawn(sources: Iterable[str | families.Family]) -> Iterator[Case]:
    for k, source in enumerate(sources):
        situation = families.draw(source, SEED, k)
        if start_clearance(pack(situation)) > 0.0:
            yield Case(situation, family=_family(source, k))


def _family(source: str | families.Family, k: int) -> str:
    if isinstance(source, str):
        members = families.preset_families(source)
        return members[k % len(members)].name
    return source.name


def _item(case: Case) -> Case:
    """Return a case under a name that no other suite has; U is what the oracle rules out."""
    situation, stratum = case.situation, case.stratum
    if stratum == "U" and not (kind_of(situation) == PLANAR and bounds(situation).decided):
        stratum = "open"
    suite = FORMER.get(case.suite, case.suite)
    named = replace(situation, name=f"{suite}-{situation.name}")
    return Case(named, case.suite, case.family, stratum)


def _warm_up(situation: AnySituation) -> Case:
    return Case(situation, stratum="warm-up")


def main() -> None:
    """Compare or write."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("names", nargs="*", default=list(SHIPPED))
    parser.add_argument("--out", type=Path, help="file for the only suite")
    given = parser.parse_args()
    for name in given.names:
        lines = suite_lines(SHIPPED[name], items()[name]())
        if given.out is not None:
            given.out.write_bytes(gzip.compress(lines, mtime=0))
        same = content_hash(lines) == SHIPPED[name].sha256
        print(f"{name}: {'as it ships' if same else 'DIFFERS from what ships'}", flush=True)


if __name__ == "__main__":
    main()
