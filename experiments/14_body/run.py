"""From plan to body: do arms with mass catch what was planned for them? Writes h10.json.

python -m experiments 14_body tubes   first: the tubes, on situations of their own; minutes
python -m experiments 14_body         then: 1,000 plans of each condition; half an hour

`tubes --kind chain` measures the tube of the Panda.

Finished parts are kept in out/ and not repeated; Ctrl-C is safe.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator
from dataclasses import asdict, replace
from pathlib import Path
from time import process_time
from typing import Any

import pandas as pd
from masses import CONDITIONS, followed
from report import JUDGED, WAYS
from tubes import measured_tube

from experiments import recompute
from gcm_learn.arms import CHAIN, SPATIAL, ByKind, kind_named
from gcm_learn.execution import (
    Execution,
    body_for,
    with_motor_limits,
)
from gcm_learn.families import draw, family_names, get_family
from gcm_learn.planners import InTube, Tube, get_planner
from gcm_learn.situation import Situation
from gcm_learn.storage import write_whole

HERE = Path(__file__).resolve().parent

DEVELOPMENT, SEED = 1410, 1411
EACH_DEVELOPMENT = 10  # situations of each family that tubes are measured on
PLANS = 1000  # that are wanted of each condition
MOST = 200  # situations of each family, at most
OUT, TUBES = HERE / "out" / "h10.jsonl", HERE / "tubes.json"

Bodied = Situation[Any]


BODIED: ByKind[dict[str, Any]] = ByKind({SPATIAL: {"human": 0.5, "nao": 0.5}, CHAIN: {}})
"""Fields of the families' arms with which only arms are drawn that have bodies."""


def drawn(family: str, seed: int, index: int) -> Bodied:
    """A situation with an arm that has a body, without limits of acceleration."""
    config: Any = get_family(family)
    arms = replace(config.arm, **BODIED.of(kind_named(config.kind)))
    situation: Any = draw(replace(config, arm=arms), seed, index)
    return replace(
        situation,
        arm=replace(situation.arm, max_joint_acceleration=None, joint_rates=None),
    )


def measure_tubes(kind: str) -> None:
    """Write the tubes of bodies of a kind of arms in all conditions, in metres; others stay."""
    done: dict[tuple[str, str], list[Execution]] = {}
    for family in family_names(kind):
        for index in range(EACH_DEVELOPMENT):
            free = drawn(family, DEVELOPMENT, index)
            if free.catch != "any":
                continue
            body = body_for(free.arm)
            situation = with_motor_limits(free, body)
            plan = get_planner("search").plan(situation)
            if not plan.caught:
                continue
            for condition in CONDITIONS:
                one = followed(plan, situation, condition)
                done.setdefault((body.name, condition), []).append(one)
    tubes: dict[str, Any] = json.loads(TUBES.read_text())
    for (body_name, condition), executed in sorted(done.items()):
        tube = asdict(measured_tube(executed)) | {"plans": len(executed)}
        tubes.setdefault(body_name, {})[condition] = tube
    write_whole(TUBES, (json.dumps(tubes, indent=1) + "\n").encode())
    print(json.dumps(tubes, indent=1))


def answer(family: str, index: int, tubes: dict[str, Any]) -> dict[str, Any]:
    """A situation planned and executed in all ways."""
    free = drawn(family, SEED, index)
    body = body_for(free.arm)
    situation, planner = with_motor_limits(free, body), get_planner("search")
    row: dict[str, Any] = {"family": family, "index": index, "body": body.name}
    row["kinematic"] = planner.plan(free).caught
    plans: dict[str, Any] = {}
    since = process_time()
    plans["none"] = planner.plan(situation)
    row["ms"] = round(1e3 * (process_time() - since), 1)
    for condition in JUDGED:
        given = tubes[body.name][condition]
        tube = Tube(given["still"], given["per_speed"]).scaled(1.0 / body.metres)
        plans[condition] = InTube(planner, tube).plan(situation)
    for condition in JUDGED:
        for tube, plan in (("without", plans["none"]), ("with", plans[condition])):
            row[f"{condition} {tube}"] = told(followed(plan, situation, condition))
    return row


def told(done: Execution) -> dict[str, Any]:
    """Summary of an execution."""
    out: dict[str, Any] = {"status": done.status}
    if done.error is not None:
        out["error"] = [round(1e3 * error, 3) for error in done.error]
        out["torque"] = round(float(done.torque or 0.0), 3)
        out["late"] = None if done.catch_time is None else round(done.catch_time - done.planned, 4)
        out["stays"], out["braked"] = done.stays, done.braked
        out["touches"] = None if done.contact is None else done.contact.name
        out["braked_into"] = done.braked_into is not None
    return out


def work() -> list[dict[str, Any]]:
    """Answer situations until each condition has its plans."""
    tubes = json.loads(TUBES.read_text())
    OUT.parent.mkdir(exist_ok=True)
    rows = [json.loads(line) for line in OUT.read_text().splitlines()] if OUT.exists() else []
    known = {(row["family"], row["index"]) for row in rows}
    counts = {k: sum(r[k]["status"] != "no plan" for r in rows) for k in WAYS}
    with OUT.open("a") as stream:
        for index in range(MOST):
            for family in family_names("spatial"):
                if min(counts.values()) >= PLANS:
                    return rows
                if (family, index) in known:
                    continue
                rows.append(answer(family, index, tubes))
                for k in WAYS:
                    counts[k] += rows[-1][k]["status"] != "no plan"
                stream.write(json.dumps(rows[-1]) + "\n")
                stream.flush()
    return rows


def outcome_rows(rows: list[dict[str, Any]]) -> Iterator[dict[str, Any]]:
    """Yield one outcome for each situation and way, `kinematic` among the ways."""
    for row in rows:
        known = {"situation": f"{row['family']}-{row['index']}", "family": row["family"]}
        known["body"] = row["body"]
        yield known | {"method": "kinematic", "caught": row["kinematic"]}
        for way in WAYS:
            done = row[way]
            values = {"status": done["status"], "caught": done["status"] == "caught"}
            values["ms"] = row["ms"] if way == WAYS[0] else None
            if "error" in done:
                values |= {"error_mm": done["error"][2], "torque": done["torque"]}
                values |= {"stays": int(bool(done["stays"]))}
                values |= {"braked_into": int(done["braked_into"])}
            yield known | {"method": way} | values


def main() -> None:
    """Measure tubes, or answer what is missing and write the table."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("part", nargs="?", choices=["tubes", "table"])
    parser.add_argument("--kind", choices=["spatial", "chain"], default="spatial")
    asked = parser.parse_args()
    if asked.part == "tubes":
        measure_tubes(asked.kind)
        return
    rows = work() if asked.part is None else [json.loads(r) for r in OUT.read_text().splitlines()]
    made = pd.DataFrame(outcome_rows(rows)).astype({"caught": int})
    made.to_csv(HERE / "outcomes.csv.gz", index=False, compression={"method": "gzip", "mtime": 0})
    recompute.update(HERE)
    print((HERE / "h10.json").read_text())


if __name__ == "__main__":
    main()
