"""Planar situations unlike those of the families, where a straight line fails; for suites.py.

python -m experiments 05_recall/standin FOLDER --seed N [--count 300]

Other arms (upper arms of 0.55 to 1.6 forearms, thick ones, slow and fast hands), two to six bodies
of all shapes and sizes anywhere, half of which rest. Kept is what `layered` catches and `straight`
does not: as W what `marching` catches, else as Q. Families of the rows are classes of arms.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path

from gcm_learn import get_planner, seeding
from gcm_learn.families.family import ArmRanges
from gcm_learn.families.random_planar import RandomPlanar
from gcm_learn.situation import situation_to_json
from gcm_learn.storage import write_whole

ARM = ArmRanges(
    upper_arm=(0.55, 1.6), thickness=(0.0, 0.03, 0.06), hand_speed=(1.5, 5.0), horizon=(0.7, 2.0)
)
FAMILY = RandomPlanar(
    arm=ARM,
    obstacles=(2, 6),
    still=0.5,
    radius=(0.05, 0.4),
    half_length=(0.1, 0.8),
    corners=(0.08, 0.45),
)
TRAINED = (0.8, 1.15)  # upper arms [forearms]


def main() -> None:
    """Draw, sort, write W.jsonl and Q.jsonl."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--seed", type=int, required=True)
    parser.add_argument("--count", type=int, default=300)
    given = parser.parse_args()
    straight, marching, layered = map(get_planner, ("straight", "marching", "layered"))
    rows: dict[str, list[str]] = {"W": [], "Q": []}
    index = 0
    while sum(map(len, rows.values())) < given.count:
        situation = FAMILY.draw(seeding.rng(given.seed, index), f"stand-in-{index:05d}")
        index += 1
        if straight.plan(situation).caught or not layered.plan(situation).caught:
            continue
        stratum = "W" if marching.plan(situation).caught else "Q"
        arm = situation.arm.upper_arm
        side = "short" if arm < TRAINED[0] else "long" if arm > TRAINED[1] else "as trained"
        row = {"family": side, "situation": situation_to_json(situation)}
        rows[stratum].append(json.dumps(row) + "\n")
    given.folder.mkdir(parents=True, exist_ok=True)
    for stratum, lines in rows.items():
        write_whole(given.folder / f"{stratum}.jsonl", "".join(lines))
    print(f"{index} draws", {name: len(lines) for name, lines in rows.items()})


if __name__ == "__main__":
    main()
