"""Draw the suites of the benchmark again; what is drawn is compared with the files that ship.

python -m experiments.benchmarks.draw_suites              compares all suites
python -m experiments.benchmarks.draw_suites NAME --write  writes a suite that has no file yet

Situations of a shipped version never change: another draw is another version.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from functools import partial
from itertools import islice

from gcm_learn import families
from gcm_learn.arms import PLANAR, kind_of
from gcm_learn.benchmark import SUITES, Item, suite_hash, suite_lines, write_suite
from gcm_learn.dataset import read_spec
from gcm_learn.evaluation import Entry, draw_suite
from gcm_learn.motion import start_clearance
from gcm_learn.planners import bounds
from gcm_learn.scene import pack
from gcm_learn.situation import AnySituation

FROZEN = 50  # of a suite whose hash `evaluation` knows
SEED = 30_117
SPACE_SPEC = "data/specs/space-accelerated.toml"


def items() -> dict[str, Callable[[], list[Item]]]:
    """Return what draws each suite, by name."""
    presets = ("panda-easy", "panda-crowded", "panda-crowded-accelerated", "panda-sequences")
    return {
        "plane": lambda: frozen("L", "W", "Q", "U"),
        "plane-held-out": lambda: frozen("pendulum", "long-arm", "faster"),
        "space": space,
        "space-accelerated": accelerated,
        "space-sequences": sequences,
    } | {name: partial(preset, name) for name in presets}


def frozen(*names: str) -> list[Item]:
    """Return a warm-up and the first 25 of each suite, whose first 50 have the hash they should."""
    drawn = [draw_suite(name, FROZEN) for name in names]
    rest = (_item(entry) for entries in drawn for entry in entries[:25])
    return [_warm_up(drawn[0][25].situation), *rest]


def space() -> list[Item]:
    """Return equal parts of what two planners say of situations in space; their U is open."""
    drawn = draw_suite("space-demo", FROZEN + 1)
    return [_warm_up(drawn[FROZEN].situation), *(_item(entry) for entry in drawn[:FROZEN])]


def accelerated() -> list[Item]:
    """Return families of a specification in turns, joints with limits of acceleration."""
    shares = read_spec(SPACE_SPEC).families
    members = [families.family_from_dict({"family": s.family, **s.config}) for s in shares]
    return _free(members[k % len(members)] for k in range(10**6))


def sequences() -> list[Item]:
    """Return situations in space that ask for most of three to five targets."""
    (family,) = families.preset_families("space-sequences")
    return _free(family for _ in range(10**6))


def preset(name: str) -> list[Item]:
    """Return items of a preset."""
    return _free(name for _ in range(10**6))


def _free(sources: Iterable[str | families.Family]) -> list[Item]:
    """Return a warm-up and 60 situations that do not begin with a touch."""
    drawn = list(islice(_drawn(sources), 61))
    return [_warm_up(drawn[60].situation), *drawn[:60]]


def _drawn(sources: Iterable[str | families.Family]) -> Iterator[Item]:
    for k, source in enumerate(sources):
        situation = families.draw(source, SEED, k)
        if start_clearance(pack(situation)) > 0.0:
            yield Item(situation, _family(source, k))


def _family(source: str | families.Family, k: int) -> str:
    if isinstance(source, str):
        members = families.preset_families(source)
        return members[k % len(members)].name
    return source.name


def _item(entry: Entry) -> Item:
    """Return an entry under a name that no other suite has; U is what the oracle rules out."""
    situation, stratum = entry.situation, entry.stratum
    if stratum == "U" and not (kind_of(situation) == PLANAR and bounds(situation).decided):
        stratum = "open"
    return Item(replace(situation, name=f"{entry.suite}-{situation.name}"), entry.family, stratum)


def _warm_up(situation: AnySituation) -> Item:
    return Item(situation, "", "warm-up")


def main() -> None:
    """Compare or write."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("names", nargs="*", default=list(SUITES))
    parser.add_argument("--write", action="store_true")
    given = parser.parse_args()
    for name in given.names:
        lines = suite_lines(SUITES[name], items()[name]())
        if given.write:
            print(name, write_suite(SUITES[name], lines), flush=True)
        else:
            same = suite_hash(lines) == SUITES[name].sha256
            print(f"{name}: {'as it ships' if same else 'DIFFERS from what ships'}", flush=True)


if __name__ == "__main__":
    main()
