"""Is what was called caught ever not? Random situations, planned for, judged by the referee.

    python -m experiments benchmarks/promise plane --catches 50000
    python -m experiments benchmarks/promise space --catches 10000 --planner layered straight
    python -m experiments benchmarks/promise space --acceleration --out accelerated.json
    python -m experiments benchmarks/promise chains --catches 10000 --planner search
    python -m experiments benchmarks/promise space --file tests/spatial.jsonl
    python -m experiments benchmarks/promise plane --again gate 1234 --planner layered

Item k is of family k mod n and goes to one planner, in turn. With `--file` an item is one of the
file's situations, its bodies and its arm a little elsewhere. It counts claims until there are
enough, writes what it has found every few seconds and after Ctrl-C, and goes on from there when it
is started again. After 500 items in a row without a claim it ends. What is broken is printed with
what draws it again. Exit code 1 if anything is, or if there are too few claims.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Callable
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from experiments.common import judging
from gcm_learn import families, get_planner, read_situations, rng
from gcm_learn.arms import SpatialArm
from gcm_learn.situation import AnySituation, Pendulum, Situation, SolidQuadratic
from gcm_learn.storage import write_whole

ROOT = Path(__file__).resolve().parents[2]
OUT = Path(__file__).parent / "out"
EVERY = 10.0  # what is found is written down this often [s]
BARREN = 500  # items in a row without a claim, after which there is nothing to be judged
KINDS = {"plane": "planar", "space": "spatial", "chains": "chain"}
"""Kinds of arms by the words of the command line."""
SHIFT = 0.1  # of bodies and joints of a file's situations [arm's reach, rad]


@dataclass
class Account:
    """Claims that have been asked for, and complaints."""

    asked: dict[str, Any]
    """Arm, seed, planners, families or file: a file of others is not gone on with."""
    following: int = 0
    """The next item."""
    claimed: int = 0
    """Catches that were judged."""
    claims: dict[str, int] = field(default_factory=dict)
    """The same by family and planner."""
    broken: list[dict[str, Any]] = field(default_factory=list)
    """Family, index, planner and complaints."""
    slowest_ms: float = 0.0
    """Of the referee."""
    commits: list[str] = field(default_factory=list)
    """Of the code that was asked."""


def nearby(situation: Situation[SpatialArm], seed: int, index: int) -> Situation[SpatialArm]:
    """A situation whose bodies and joints are a little elsewhere."""
    r, arm = rng(seed, index), situation.arm
    low, high = np.array(arm.joint_range).T
    joints = np.clip(np.array(arm.joints) + r.uniform(-SHIFT, SHIFT, 4), low, high)
    bodies = []
    for body in situation.bodies:
        motion, shift = body.motion, r.uniform(-SHIFT, SHIFT, 3) * arm.reach
        if isinstance(motion, Pendulum):
            motion = replace(motion, pivot=tuple(shift + motion.pivot))
        elif isinstance(motion, SolidQuadratic):
            motion = replace(motion, position=tuple(shift + motion.position))
        bodies.append(replace(body, motion=motion))
    return replace(situation, arm=replace(arm, joints=tuple(joints)), bodies=tuple(bodies))


def forced(situation: Situation[Any], seed: int, index: int) -> Situation[Any]:
    """A situation whose joints need a while to their top speeds, and move already, or do not."""
    r, arm = rng(seed, index, 1), situation.arm
    speeds = np.array(arm.max_joint_speed)
    limits = tuple(speeds / r.uniform(0.05, 0.3))
    rates = tuple(0.5 * speeds * r.uniform(-1.0, 1.0, len(speeds))) if r.random() < 0.5 else None
    return replace(situation, arm=replace(arm, max_joint_acceleration=limits, joint_rates=rates))


def source_of(args: argparse.Namespace) -> tuple[list[str], Callable[[str, int], AnySituation]]:
    """Names of what is drawn from, and what draws an item of it."""
    if args.file is None:
        names = args.family or families.family_names(KINDS[args.arm])
        if args.acceleration:
            return names, lambda name, index: forced(
                families.draw(name, args.seed, index), args.seed, index
            )
        return names, lambda name, index: families.draw(name, args.seed, index)
    situations: dict[str, Any] = {s.name: s for s in read_situations(args.file)}
    names = [n for n, s in situations.items() if s.is_spatial]
    return names, lambda name, index: nearby(situations[name], args.seed, index)


def complaints(situation: AnySituation, planner: str) -> tuple[list[str] | None, float]:
    """Return the referee's complaints, None without a claim, and its time [ms]."""
    plan = get_planner(planner).plan(situation)
    if not plan.caught:
        return None, 0.0
    begun = time.perf_counter()
    found = judging.complaints(situation, plan)
    return found, 1e3 * (time.perf_counter() - begun)


def account_of(path: Path, asked: dict[str, Any]) -> Account:
    """The account in a file, or a new one."""
    if not path.exists():
        return Account(asked)
    account = Account(**json.loads(path.read_text("utf-8")))
    if account.asked != asked:
        sys.exit(f"{path} is about something else: {account.asked}; give another --out")
    return account


def commit() -> str:
    """The commit that is checked out."""
    command = ["git", "-C", str(ROOT), "rev-parse", "--short", "HEAD"]
    return subprocess.run(command, capture_output=True, text=True, check=False).stdout.strip()


def ask(account: Account, names: list[str], planners: list[str], draw: Any) -> None:
    """Plan for the next item and have its claim judged."""
    k = account.following
    name, index = names[k % len(names)], k // len(names)
    planner = planners[index % len(planners)]
    found, spent = complaints(draw(name, index), planner)
    account.following = k + 1
    if found is None:
        return
    account.claimed += 1
    account.claims = dict(Counter(account.claims) + Counter([name, planner]))
    account.slowest_ms = max(account.slowest_ms, spent)
    if found:
        broken = {"family": name, "index": index, "planner": planner, "complaints": found}
        account.broken.append(broken)
        print(f"broken: --again {name} {index} --planner {planner}: {'; '.join(found)}", flush=True)


def run(account: Account, path: Path, catches: int, step: Callable[[], None]) -> None:
    """Ask until there are enough claims, or none comes for BARREN items.

    Findings are written now and then, and at the end.
    """

    def write() -> None:
        write_whole(path, json.dumps(asdict(account), indent=1) + "\n")
        done = f"{account.claimed} of {catches} claims, {len(account.broken)} broken"
        print(f"{done}, {account.following} items", flush=True)

    path.parent.mkdir(parents=True, exist_ok=True)
    account.commits = sorted({*account.commits, commit()})
    written = time.monotonic()
    claimed, since = account.claimed, account.following
    try:
        while account.claimed < catches:
            step()
            if account.claimed > claimed:
                claimed, since = account.claimed, account.following
            elif account.following - since >= BARREN:
                print(f"no claim in {BARREN} items in a row: nothing to be judged", flush=True)
                break
            if time.monotonic() - written > EVERY:
                write()
                written = time.monotonic()
    finally:
        write()


def arguments() -> argparse.Namespace:
    """Return the options of the command line."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("arm", choices=list(KINDS))
    parser.add_argument("--catches", type=int, default=1000, help="claims to be judged")
    parser.add_argument("--planner", nargs="+", default=["layered"])
    parser.add_argument("--family", nargs="+", help="default: all of the arm's kind")
    parser.add_argument("--file", type=Path, help="situations in space, drawn from instead")
    parser.add_argument("--acceleration", action="store_true", help="limit it, but in the plane")
    parser.add_argument("--seed", type=int, default=14)
    parser.add_argument("--out", type=Path, help="default: out/promise-ARM.json beside this file")
    parser.add_argument("--again", nargs=2, metavar=("FAMILY", "INDEX"), help="only this item")
    return parser.parse_args()


def main() -> int:
    """Ask, and say whether anything is broken or too little was claimed."""
    args = arguments()
    names, draw = source_of(args)
    if args.again is not None:
        found, _ = complaints(draw(args.again[0], int(args.again[1])), args.planner[0])
        print("not claimed" if found is None else "\n".join(found) or "kept")
        return 1 if found else 0
    asked = {"arm": args.arm, "seed": args.seed, "planners": args.planner, "names": names}
    asked |= {"acceleration": True} if args.acceleration else {}
    path = args.out or OUT / f"promise-{args.arm}.json"
    account = account_of(path, asked)
    try:
        run(account, path, args.catches, lambda: ask(account, names, args.planner, draw))
    except KeyboardInterrupt:
        print(f"interrupted; the same command goes on from {path}")
        return 130
    return 1 if account.broken or account.claimed < args.catches else 0


if __name__ == "__main__":
    sys.exit(main())
