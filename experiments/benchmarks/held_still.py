"""Compare the behaviour of planar and spatial arms between two checkouts, answer by answer.

    python experiments/benchmarks/held_still.py --write base.json.gz
    python experiments/benchmarks/held_still.py --against base.json.gz --share 0.1
    python experiments/benchmarks/held_still.py --against base.json.gz --only "plans gcm"

Every question has a name, "part who kind family number", and its answer is hashed. Answers are
JSON with sorted keys; arrays count to the last bit, with their types and shapes. `--against` prints
the groups in which answers differ, with the first few names, and exits with 1. `--show NAME` prints
an answer itself, so that two checkouts can be compared with diff.

Questions are asked in a process of their own, in this checkout or in that of `--checkout`. A
question that raises an error of the package's own has the error's type as its answer. Any other
error is an answer that equals none, so a name that has moved shows up as a difference and stops
nothing else.

Planning times and messages are left out. So is everything that depends on processor time:
deadlines other than 0, loops in which thinking takes as long as it takes, and `st-rrt-star`, which
searches until its time is over.
"""

from __future__ import annotations

import argparse
import gzip
import hashlib
import json
import os
import re
import subprocess
import sys
import tempfile
import time
import zlib
from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping
from functools import cache, partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
BROKEN = "cannot be asked: "  # how an answer begins that equals none
SHOWN = 5  # names that are printed for a group
ONE = ("NUMBA_NUM_THREADS", "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")


SEED = 2024
LARGE = 64  # elements from which on an array's bytes are hashed
UNTOLD = ("planning_ms", "message")  # keys that are no part of an answer

VARIETIES = {"planar": "planar", "limited": "planar", "spatial": "spatial", "ramped": "spatial"}
"""What is asked about, and the kind of arm: limited planar arms have limits of joint speed, ramped
spatial arms have limits of acceleration and move at t = 0."""
LIMITS = [3.0, 4.0]  # of a limited arm's joints [rad/s]
RAMPED = {"ramp": [0.03, 0.15], "moving": 0.5}
MOST = {"planar": 42, "limited": 11, "spatial": 42, "ramped": 42}
"""Situations of a family: about 1000 for each kind of arm."""
PLANS = {
    "straight": MOST,
    "straight-wait": MOST,
    "potential": MOST,
    "layered": MOST,
    "gcm": MOST,
    "marching": MOST,
    "layered-wave": MOST,
    "oracle": {"planar": 2, "limited": 1, "spatial": 1, "ramped": 1},
    "recall": MOST,
    "recall-1": MOST,
    "hybrid": MOST,
    "recall-raw": MOST,
    "recall-random": MOST,
}
"""Situations of a family that a planner is asked about, fewer of those that take long."""


class Group(NamedTuple):
    """Questions that differ by a number."""

    name: str
    """Part, who, kind and family."""
    count: int
    ask: Callable[[int], Any]
    """The answer to the question of a number."""


@cache
def drawn(variety: str, family: str, k: int) -> Any:
    """Situation k of a family, or of the paper's scenes."""
    from gcm_learn import families, paper_scene
    from gcm_learn.situation import situation_from_json, situation_to_json

    if family == "paper":
        return paper_scene(_scenes(variety)[k])
    if variety == "ramped":
        return families.draw(families.family_from_dict({"family": family, "arm": RAMPED}), SEED, k)
    if variety == "limited":
        values = situation_to_json(drawn("planar", family, k))
        values["arm"]["max_joint_speed"] = LIMITS
        return situation_from_json(values)
    return families.draw(family, SEED, k)


def _scenes(variety: str) -> list[str]:
    from gcm_learn import families

    scenes = {"planar": families.PAPER_SCENES, "spatial": families.SPATIAL_SCENES}
    return list(scenes.get(variety, ()))


def about(
    part: str, who: str, counts: Mapping[str, int], ask: Callable[[Any], Any]
) -> Iterator[Group]:
    """Groups of a question about situations, so many of every family."""
    from gcm_learn import families

    for variety, count in counts.items():
        names = [(family, count) for family in families.family_names(VARIETIES[variety])]
        for family, most in [*names, ("paper", min(count, len(_scenes(variety))))]:
            found = partial(drawn, variety, family)
            yield Group(
                f"{part} {who} {variety} {family}", most, lambda k, found=found: ask(found(k))
            )


def situations() -> Iterator[Group]:
    """Situations as they are drawn, and in their canonical frame."""
    from gcm_learn.situation import situation_to_json

    def turned(situation: Any) -> Any:
        from gcm_learn.situation import canonical

        return situation_to_json(canonical(situation)[0])

    yield from about("situations", "drawn", MOST, situation_to_json)
    yield from about("situations", "canonical", {v: n // 4 for v, n in MOST.items()}, turned)


def planned(name: str, situation: Any) -> Any:
    """A solution in the exchange format."""
    from gcm_learn.planners import plan_to_json, plan_with

    return plan_to_json(plan_with(planner(name), situation), situation)


@cache
def planner(name: str) -> Any:
    """A planner with its default settings."""
    from gcm_learn import get_planner

    return get_planner(name)


def plans() -> Iterator[Group]:
    """Solutions of all planners whose answers repeat."""
    for name, counts in PLANS.items():
        yield from about("plans", name, counts, partial(planned, name))


PARTS = (situations, plans)


def plain(value: Any) -> Any:
    """A value as JSON has it; arrays with their types and shapes, large ones as hashes."""
    if isinstance(value, Mapping):
        return {str(key): plain(v) for key, v in value.items() if key not in UNTOLD}
    if isinstance(value, np.ma.MaskedArray):
        return [plain(value.filled(-1)), plain(np.ma.getmaskarray(value))]
    if isinstance(value, np.ndarray) and value.dtype != object:
        content = value.tolist() if value.size < LARGE else digest(value.tobytes())
        return [value.dtype.str, value.shape, content]
    if isinstance(value, (list, tuple, np.ndarray)):
        return [plain(v) for v in value]
    if isinstance(value, bytes):
        return digest(value)
    return value.item() if isinstance(value, np.generic) else value


def digest(content: bytes) -> str:
    """A hash, short."""
    return hashlib.sha256(content).hexdigest()[:16]


def text_of(ask: Callable[[int], Any], k: int) -> str:
    """An answer as text: JSON, or why there is none."""
    from gcm_learn.errors import GcmError

    try:
        return json.dumps(plain(ask(k)), sort_keys=True)
    except GcmError as error:
        return json.dumps({"refused": type(error).__name__})
    except Exception as error:
        return f"{BROKEN}{type(error).__name__}: {error}"


def chosen(name: str, only: str, share: float) -> bool:
    """Whether a question is asked: its name matches, and it falls into the share."""
    place = zlib.crc32(name.encode()) / 2**32
    return place < share and re.search(only, name) is not None


def serve(arguments: argparse.Namespace) -> None:
    """Ask the chosen questions, a line of JSON for each answer."""
    out, sys.stdout = sys.stdout, sys.stderr  # nothing else may come between the lines
    for part in PARTS:
        for group in part():
            for name, k in ((f"{group.name} {k}", k) for k in range(group.count)):
                if arguments.show != name and (
                    arguments.show or not chosen(name, arguments.only, arguments.share)
                ):
                    continue
                since = time.process_time()
                answer = text_of(group.ask, k)
                if not answer.startswith(BROKEN) and not arguments.show:
                    answer = digest(answer.encode())
                row = {"name": name, "answer": answer, "seconds": time.process_time() - since}
                print(json.dumps(row), file=out, flush=True)


def asked(arguments: argparse.Namespace) -> Iterator[dict[str, str | float]]:
    """Yield the answers of a process in the chosen checkout, as they come."""
    options = [f"--{name}={getattr(arguments, name)}" for name in ("share", "only", "show")]
    checkout = arguments.checkout.resolve()
    process = subprocess.Popen(
        [arguments.python, str(Path(__file__).resolve()), "--serve", *options],
        cwd=checkout, text=True,
        env={**os.environ, **dict.fromkeys(ONE, "1"), "MPLBACKEND": "Agg",
             "PYTHONPATH": str(checkout)},
        stdout=subprocess.PIPE,
    )  # fmt: skip
    assert process.stdout is not None
    for line in process.stdout:
        yield json.loads(line)
    if process.wait():
        print(f"the questions ended with exit code {process.returncode}", file=sys.stderr)


def answers(arguments: argparse.Namespace) -> tuple[dict[str, str], dict[str, float]]:
    """Answers by name, and processor time by part, who and kind [s]."""
    found, times = dict[str, str](), defaultdict[str, float](float)
    for row in asked(arguments):
        name = str(row["name"])
        found[name] = str(row["answer"])
        times[" ".join(name.split()[:3])] += float(row["seconds"])
        if sys.stderr.isatty():
            print(f"\r\033[K{len(found)} {name}", end="", file=sys.stderr, flush=True)
    if sys.stderr.isatty():
        print("\r\033[K", end="", file=sys.stderr)
    return found, dict(times)


def write(path: Path, found: Mapping[str, str]) -> None:
    """Write answers to a file, compressed if its name ends with .gz."""
    text = json.dumps(found, indent=0, sort_keys=True).encode()
    path.write_bytes(gzip.compress(text, mtime=0) if path.suffix == ".gz" else text)


def read(path: Path) -> dict[str, str]:
    """Answers of a file."""
    content = path.read_bytes()
    text = gzip.decompress(content) if path.suffix == ".gz" else content
    return {str(name): str(answer) for name, answer in json.loads(text).items()}


def group_of(name: str) -> str:
    """Part, who, kind and family of a question."""
    return name.rpartition(" ")[0]


def compared(found: Mapping[str, str], before: Mapping[str, str]) -> int:
    """Print which answers differ, by group; returns how many do."""
    groups, wrong = defaultdict[str, list[str]](list), defaultdict[str, list[str]](list)
    for name in sorted({*found, *before}, key=lambda name: (group_of(name), len(name), name)):
        if name not in before:
            continue
        groups[group_of(name)].append(name)
        answer = found.get(name, BROKEN + "not asked any more")
        if answer != before[name] or answer.startswith(BROKEN):
            reason = f" ({answer})" if answer.startswith(BROKEN) else ""
            wrong[group_of(name)].append(name.rpartition(" ")[2] + reason)
    for group, names in wrong.items():
        print(f"{group}: {len(names)} of {len(groups[group])} differ: {', '.join(names[:SHOWN])}")
    count, new = sum(map(len, wrong.values())), len(found.keys() - before.keys())
    print(f"{count} of {sum(map(len, groups.values()))} answers differ")
    if new:
        print(f"{new} answers are not in the file")
    return count


def main() -> int:
    """Ask, and write or compare."""
    parser = argparse.ArgumentParser(description="Compare behaviour between two checkouts.")
    parser.add_argument("--write", type=Path, metavar="FILE", help="where the answers go")
    parser.add_argument("--against", type=Path, metavar="FILE", help="what they are compared with")
    parser.add_argument("--checkout", type=Path, default=ROOT, help="by default this one")
    parser.add_argument("--python", default=sys.executable, help="the checkout's Python")
    parser.add_argument("--only", default="", help="questions whose name matches this expression")
    parser.add_argument("--share", type=float, default=1.0, help="share of the questions, by name")
    parser.add_argument("--show", default="", metavar="NAME", help="print the answer of a question")
    parser.add_argument("--times", action="store_true", help="print processor times by planner")
    parser.add_argument("--serve", action="store_true", help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.serve:
        serve(arguments)
        return 0
    if not (arguments.checkout / "gcm_learn").is_dir():
        parser.error(f"--checkout: {arguments.checkout} has no gcm_learn")
    if arguments.show:
        for row in asked(arguments):
            print(json.dumps(json.loads(str(row["answer"])), indent=1))
        return 0
    if arguments.write is None and arguments.against is None:
        parser.error("--write or --against is missing")
    before = {} if arguments.against is None else read(arguments.against)
    found, times = answers(arguments)
    if arguments.times:
        for name, seconds in sorted(times.items(), key=lambda row: -row[1]):
            print(f"{seconds:8.1f} s  {name}")
    if arguments.write is not None:
        write(arguments.write, found)
        broken = [f"{name}: {a}" for name, a in found.items() if a.startswith(BROKEN)]
        print(f"{len(found)} answers in {sum(times.values()):.0f} s", *broken, sep="\n")
    if arguments.against is None:
        return 0
    return 1 if compared(found, _chosen(before, arguments)) else 0


def _chosen(before: Mapping[str, str], arguments: argparse.Namespace) -> dict[str, str]:
    """Answers of a file to the questions that were asked."""
    return {
        name: answer
        for name, answer in before.items()
        if chosen(name, arguments.only, arguments.share)
    }


if __name__ == "__main__":
    sys.exit(main())
