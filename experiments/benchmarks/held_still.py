"""Compare the behaviour of planar and spatial arms between two checkouts, answer by answer.

    python experiments/benchmarks/held_still.py --write base.json.gz
    python experiments/benchmarks/held_still.py --against base.json.gz --share 0.1
    python experiments/benchmarks/held_still.py --against base.json.gz --only "plans gcm"

Every question has a name, "part who kind family number", and its answer is hashed. Answers are
JSON with sorted keys. Arrays count to the last bit, with their types and shapes. `--against` prints
the groups in which answers differ and the first few names, and exits with 1. `--show NAME` prints
one answer, so that diff can compare it with that of another checkout.

Questions are asked in a process of their own, in this checkout or in that of `--checkout`. A
question that raises an error of the package's own has the error's type as its answer. Any other
error is an answer that equals none. A name that has moved is then a difference, and stops nothing.

These are left out, because they depend on processor time:

- planning times, and messages
- deadlines other than 0
- closed loops in which thoughts take as long as they take; here they take a fixed time
- `st-rrt-star`, whose search ends with its time

Rendered pictures and training are left out, too.
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

VARIETIES = dict(
    planar="planar", limited="planar", spatial="spatial", ramped="spatial", bodied="spatial"
)
"""Situations that are asked about, and their kind of arm. Limited planar arms have limits of joint
speed. Ramped spatial arms have limits of acceleration and move at t = 0. Bodied ones have such
limits, rest at t = 0 and are arms with a shipped body."""
LIMITS = [3.0, 4.0]  # of a limited arm's joints [rad/s]
ARMS = {
    "ramped": {"ramp": [0.03, 0.15], "moving": 0.5},
    "bodied": {"ramp": [0.08, 0.14], "human": 0.5, "nao": 0.5},
}
"""Ranges of arms, where they are not the family's own."""
MOST = {"planar": 42, "limited": 11, "spatial": 42, "ramped": 42}
"""Situations of a family: about 1000 for each kind of arm."""
FEW = {"planar": 4, "limited": 1, "spatial": 4, "ramped": 4}
PLANS = {
    "straight": MOST,
    "straight-wait": MOST,
    "potential": MOST,
    "layered": {"planar": 42, "limited": 6},
    "gcm": {"planar": 42, "limited": 11},
    "marching": MOST | {"spatial": 4, "ramped": 2},
    "oracle": {"planar": 1, "limited": 1, "spatial": 1, "ramped": 1},
    "recall": MOST,
    "recall-1": MOST,
    "hybrid": MOST | {"limited": 6, "spatial": 10, "ramped": 4},
    "recall-raw": MOST,
    "recall-random": MOST,
}
"""Situations of a family that a planner is asked about, fewer of those that take long."""
MAPS = {"planar": 2, "limited": 1, "spatial": 1}
SHARDS: dict[str, dict[str, Any]] = {
    "planar": {"planners": ["straight", "gcm", "marching", "layered"], "map": "marching"},
    "spatial": {"planners": ["straight", "search"], "map": "none", "effort": 0.25},
    "ramped": {"planners": ["search"], "map": "none", "effort": 0.25},
}
"""Fields of the specifications of which shards are made."""
ACTOR = "ppo-space"  # acts in closed loops
STEPS = 40  # of an arm in an arena
GUIDED: dict[str, Any] = {"settings": {"weights": {"guide": 1.0}}}
ARENAS: dict[str, tuple[tuple[str, ...], dict[str, dict[str, Any]]]] = {
    "CatchArm-v0": (
        ("planar", "limited"),
        {"plain": {}, "fan": {"fan": True}, "joint": {"control": "joint"}, "guided": GUIDED,
         "embedding": {"embedding": True}, "map": {"map": True}},
    ),
    "CatchArm3D-v0": (
        ("spatial", "ramped"),
        {"plain": {}, "fan": {"settings": {"fan": True}}, "guided": GUIDED},
    ),
    "CatchArmPhysics-v0": (
        ("spatial", "ramped"),
        {"plain": {}, "torque": {"settings": {"control": "torque", "fan": True}}},
    ),
}  # fmt: skip
"""Varieties of situations and options of environments."""


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
    if variety == "limited":
        values = situation_to_json(drawn("planar", family, k))
        values["arm"]["max_joint_speed"] = LIMITS
        return situation_from_json(values)
    return families.draw(family_of(variety, family), SEED, k)


def family_of(variety: str, family: str) -> Any:
    """A family with the ranges of a variety."""
    from gcm_learn import families

    if variety not in ARMS:
        return families.get_family(family)
    return families.family_from_dict({"family": family, "arm": ARMS[variety]})


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


def anytime() -> Iterator[Group]:
    """Solutions at once, and under a bound on the time of the catch."""
    from gcm_learn.planners import plan_to_json, plan_with

    def bounded(name: str, situation: Any) -> Any:
        found = planner(name).plan(situation, bound=0.6 * situation.horizon)
        return plan_to_json(found, situation)

    def at_once(name: str, situation: Any) -> Any:
        return plan_to_json(plan_with(planner(name), situation, 0.0), situation)

    for name in ("search", "hybrid"):
        yield from about("plans-at-once", name, FEW, partial(at_once, name))
        yield from about("plans-under-a-bound", name, FEW, partial(bounded, name))


def maps() -> Iterator[Group]:
    """Arrays of maps, by engine."""
    from gcm_learn import MarchingParams, WaveParams, build_map

    fields = ("arrival", "later", "via", "effective_obstacles", "effective_target", "kappa",
              "engine", "hand")  # fmt: skip

    def mapped(params: Any, wait: bool, situation: Any) -> Any:
        made = build_map(situation, params, wait=wait)
        met = made.interception and vars(made.interception)
        return {"interception": met, **{name: getattr(made, name) for name in fields}}

    marching, plane = MarchingParams(until="horizon"), {k: MAPS[k] for k in ("planar", "limited")}
    for name, params, wait, counts in (
        ("wave", WaveParams(until="horizon"), False, plane),
        ("marching", marching, False, MAPS),
        ("marching-waiting", marching, True, plane),
    ):
        yield from about("maps", name, counts, partial(mapped, params, wait))


def shards() -> Iterator[Group]:
    """Columns and headers of shards of four records."""
    from gcm_learn import families

    def made(spec: Mapping[str, Any], k: int) -> Any:
        import pyarrow.parquet as pq

        from gcm_learn.dataset import Folder, make_shard, spec_from_json

        with tempfile.TemporaryDirectory() as folder:
            Folder(folder).make()
            make_shard(spec_from_json(spec), k, folder)
            (path,) = Path(folder).rglob("*.parquet")
            table = pq.read_table(path)
        header = json.loads(table.schema.metadata[b"gcm-learn"])
        del header["info"]["code"]  # tells one state of the sources from another
        return {"header": header, **{name: table[name].to_pylist() for name in table.column_names}}

    for variety, values in SHARDS.items():
        names = families.family_names(VARIETIES[variety])
        arm = {"config": {"arm": ARMS[variety]}} if variety in ARMS else {}
        count = 8 if variety == "planar" else 4
        spec = {
            "format": "gcm-learn/dataset-spec@1", "name": "held", "seed": SEED, "shard_size": 4,
            "count": 4 * count, "families": [{"family": name, **arm} for name in names], **values,
        }  # fmt: skip
        yield Group(f"shards made {variety} all", count, partial(made, spec))


def stored() -> Iterator[Group]:
    """Records of the shipped samples and entries of the shipped memories, as they are read."""
    from gcm_learn.planners import plan_to_json
    from gcm_learn.situation import situation_to_json

    def record(name: str, k: int) -> Any:
        from gcm_learn import artifacts, dataset

        folder = artifacts.find("data", name)
        item = dataset.open(folder)[7 * k]
        plans = {who: plan_to_json(plan, item.situation) for who, plan in item.plans.items()}
        arrival = None if item.map is None else item.map.arrival
        situation = situation_to_json(item.situation)
        return [situation, plans, arrival, item.stratum, item.split, item.quantities]

    def entry(variety: str, k: int) -> Any:
        kept = memory(variety)[97 * k]
        return [situation_to_json(kept.situation), kept.waypoints, kept.family, kept.stratum]

    yield Group("stored sample planar all", 20, partial(record, "sample"))
    yield Group("stored sample spatial all", 20, partial(record, "sample-space"))
    for variety in ("planar", "spatial"):
        yield Group(f"stored memory {variety} all", 20, partial(entry, variety))


@cache
def memory(variety: str) -> Any:
    """The shipped memory of a kind of arm."""
    from gcm_learn import artifacts
    from gcm_learn.recall import Memory

    return Memory.load(artifacts.find("models", "recall" + "-space" * (variety != "planar")))


def memories() -> Iterator[Group]:
    """Waypoints of plans, and features of situations."""

    def waypoints(name: str, situation: Any) -> Any:
        from gcm_learn.recall import waypoints_of

        plan = planner(name).plan(situation)
        return waypoints_of(situation, plan) if plan.caught else plan.status

    def raw(situation: Any) -> Any:
        from gcm_learn.recall import kinds

        # Former checkouts have other names.
        ask: Any = kinds.raw_features if hasattr(kinds, "raw_features") else kinds.raw_numbers
        return ask(situation)

    def features(situation: Any) -> Any:
        from gcm_learn.recall import kinds

        if hasattr(kinds, "MEMORIES"):
            return kinds.MEMORIES.of(situation).features(situation)
        return kinds.kind_of(situation).look(situation)

    def recalled(situation: Any) -> Any:
        kept = memory("spatial" if situation.is_spatial else "planar")
        place = kept.index.embed_query(situation)
        return [place, kept.recall(place, 20)]

    for name in ("straight", "search"):
        yield from about("waypoints", name, FEW, partial(waypoints, name))
    yield from about("features", "raw", MOST, raw)
    yield from about("features", "clearance", MOST, features)
    yield from about("features", "embedding", FEW, recalled)


def arenas() -> Iterator[Group]:
    """Observations, rewards and ends under random actions, of one arm and of several."""
    from gcm_learn import families

    for name, (varieties, choices) in ARENAS.items():
        for variety in varieties:
            for family in families.family_names(VARIETIES[variety]):
                place = family_of(variety, family)
                if variety == "limited":
                    place = [drawn(variety, family, k) for k in range(3)]
                for choice, options in choices.items():
                    who, rest = f"{name}-{choice}", f"{variety} {family}"
                    yield Group(f"arena {who} {rest}", 2, partial(one_arm, name, place, options))
                    if choice != "map":
                        ask = partial(many_arms, name, place, options, None)
                        yield Group(f"arenas {who} {rest}", 1, ask)


def one_arm(name: str, place: Any, options: Mapping[str, Any], k: int) -> Any:
    """Steps of one arm; with the option `map` its observations have the map's picture."""
    import gymnasium

    given = {key: value for key, value in options.items() if key != "map"}
    env = gymnasium.make(f"gcm_learn:{name}", situations=place, pool=3, pool_seed=SEED, **given)
    if "map" in options:
        from gcm_learn.envs import WithMap

        env = WithMap(env)
    env.action_space.seed(k)
    seen: list[Any] = [env.reset(seed=k)]
    for _ in range(STEPS):
        seen.append(env.step(env.action_space.sample()))
        if seen[-1][2] or seen[-1][3]:
            seen.append(env.reset())
    env.close()
    return seen


def many_arms(name: str, place: Any, options: Mapping[str, Any], actor: Any, k: int) -> Any:
    """Steps of several arms, under random actions or an actor's."""
    import gymnasium

    envs = gymnasium.make_vec(
        f"gcm_learn:{name}", num_envs=6, vectorization_mode="vector_entry_point",
        situations=place, pool=6, pool_seed=SEED, **options,
    )  # fmt: skip
    envs.action_space.seed(k)
    seen: list[Any] = [envs.reset(seed=k)]
    for _ in range(STEPS):
        observations = seen[-1][0]
        action = envs.action_space.sample() if actor is None else actor.act(observations)
        seen.append([*envs.step(action), action])
    envs.close()
    return seen


def policies() -> Iterator[Group]:
    """Plans and actions of the shipped actors."""
    from gcm_learn import families
    from gcm_learn.arms import SPATIAL
    from gcm_learn.planners import plan_to_json
    from gcm_learn.policies import ActorPlanner, actor_names, shipped_actor

    def tried(name: str, situation: Any) -> Any:
        return plan_to_json(ActorPlanner(shipped_actor(name), name).plan(situation), situation)

    def acting(name: str, env: str, place: Any, k: int) -> Any:
        actor = shipped_actor(name)
        return many_arms(env, place, {"settings": actor.settings}, actor, k)

    rows = [(name, "CatchArm-v0", ("planar", "limited")) for name in actor_names()]
    rows += [(name, "CatchArm3D-v0", ("spatial", "ramped")) for name in actor_names(SPATIAL)]
    for name, env, varieties in rows:
        yield from about("policy-plans", name, {v: 2 for v in varieties}, partial(tried, name))
        for family in families.family_names(VARIETIES[varieties[0]]):
            ask = partial(acting, name, env, family_of(varieties[0], family))
            yield Group(f"policy-actions {name} {varieties[0]} {family}", 1, ask)


class Noted:
    """A planner that notes what it answers."""

    def __init__(self, name: str) -> None:
        self.name, self.answers = name, list[Any]()

    def plan(self, situation: Any) -> Any:
        """Answer a situation."""
        from gcm_learn.planners import plan_to_json

        plan = planner(self.name).plan(situation)
        self.answers.append(plan_to_json(plan, situation))
        return plan


def loops() -> Iterator[Group]:
    """Closed loops whose thoughts take a fixed time, and movements of arms with mass."""

    def looped(habit: str, situation: Any) -> Any:
        from gcm_learn.execution import ExactPlant, Loop, Perception, Planning, run_closed_loop
        from gcm_learn.policies import shipped_actor

        noted = Noted("search")
        mind = shipped_actor(habit).mind() if habit == ACTOR else Planning(noted, habit)
        loop = Loop(Perception(place=0.0125, dropouts=0.5), thinking=0.02)
        course = run_closed_loop(mind, ExactPlant(situation), situation, loop, SEED, 1)
        return [course.outcome, course.time, course.thoughts, noted.answers]

    def seen(name: str, situation: Any) -> Any:
        from gcm_learn.execution import Loop, Perception, Planning, execute_seen, execution_to_json

        noted = Noted(name)
        loop = Loop(Perception(place=0.0125, dropouts=0.5), thinking=0.02)
        done = execute_seen(Planning(noted), situation, loop, SEED)
        return [execution_to_json(done), noted.answers]

    def executed(name: str, situation: Any) -> Any:
        from gcm_learn.execution import execute, execution_to_json

        plan = planner(name).plan(situation)
        done = execute(plan, situation)
        way = done.movement if plan.caught else None
        return [execution_to_json(done), way and [way.time, way.joints]]

    for habit in ("once", "broken", "always", ACTOR):
        few = {"spatial": 1, "bodied": 1}
        if habit != ACTOR:
            few |= {"planar": 1, "limited": 1}
        yield from about("closed-loop", habit, few, partial(looped, habit))
    yield from about("closed-loop-in-physics", "search", {"bodied": 1}, partial(seen, "search"))
    for name in ("straight", "search"):
        yield from about("execution", name, {"bodied": 2}, partial(executed, name))


PARTS = (
    situations, plans, anytime, maps, stored, memories, shards, policies, loops, arenas,
)  # fmt: skip


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
    """An answer as JSON, or the reason for having none."""
    try:
        return json.dumps(plain(ask(k)), sort_keys=True)
    except Exception as error:
        if any(kind.__name__ == "GcmError" for kind in type(error).__mro__):
            return json.dumps({"refused": type(error).__name__})
        return f"{BROKEN}{type(error).__name__}: {error}"


def groups() -> Iterator[Group]:
    """Groups of all parts; a part that cannot be asked is reported and left out."""
    for part in PARTS:
        try:
            yield from part()
        except Exception as error:
            print(f"{part.__name__}: {BROKEN}{type(error).__name__}: {error}", file=sys.stderr)


def chosen(name: str, only: str, share: float) -> bool:
    """Return whether a question is asked: its name matches, and it falls into the share."""
    place = zlib.crc32(name.encode()) / 2**32
    return place < share and re.search(only, name) is not None


def serve(arguments: argparse.Namespace) -> None:
    """Ask the chosen questions, a line of JSON for each answer."""
    out, sys.stdout = sys.stdout, sys.stderr  # nothing else may come between the lines
    for group in groups():
        for k in range(group.count):
            name = f"{group.name} {k}"
            shown = name == arguments.show
            if not shown and (arguments.show or not chosen(name, arguments.only, arguments.share)):
                continue
            since = time.process_time()
            answer = text_of(group.ask, k)
            if not answer.startswith(BROKEN) and not shown:
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
            answer = str(row["answer"])
            print(answer if answer.startswith(BROKEN) else json.dumps(json.loads(answer), indent=1))
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
