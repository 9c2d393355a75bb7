"""Plans in physics: h10.json, computed from outcomes."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from gcm_learn.evaluation import wilson

JUDGED = ("known", "heavy")
WAYS = tuple(f"{condition} {tube}" for condition in JUDGED for tube in ("without", "with"))
"""Known or heavier masses; plans without or with a tube."""
NO_PLAN = "no plan"
SATURATED = 0.999  # of a motor's torque


def results(folder: Path) -> dict[str, str]:
    """Return the text of h10.json."""
    return {"h10.json": json.dumps(table(pd.read_csv(folder / "outcomes.csv.gz")), indent=1) + "\n"}


def table(found: pd.DataFrame) -> dict[str, Any]:
    """Return results of the plans, condition by condition."""
    free = found[found["method"] == "kinematic"]
    kinematic = set(free["situation"][free["caught"] == 1])
    made: dict[str, Any] = {"situations": len(free), "kinematic": len(kinematic), "conditions": {}}
    for way in WAYS:
        planned = found[(found["method"] == way) & (found["status"] != NO_PLAN)]
        kept = len(kinematic & set(planned["situation"])) / len(kinematic)
        made["conditions"][way] = summed(planned) | {"keeps_of_kinematic": kept}
    return made


def summed(planned: pd.DataFrame) -> dict[str, Any]:
    """Return shares and errors of situations with a plan."""
    caught = planned[planned["caught"] == 1]
    share = wilson(len(caught), len(planned))
    return {
        "plans": len(planned),
        "caught": len(caught),
        "caught_interval": [share.low, share.high],
        "collided": int(np.sum(planned["status"] == "collided")),
        "stays": int(np.nansum(caught["stays"])),
        "brakes_into": int(np.nansum(planned["braked_into"])),
        "saturated": int(np.sum(planned["torque"] > SATURATED)),
        "error_at_the_end_mm": {
            body: errors(planned["error_mm"][planned["body"] == body].to_numpy())
            for body in sorted(set(planned["body"]))
        },
    }


def errors(ends: np.ndarray) -> dict[str, float]:
    """Return median, 95 % quantile and maximum of errors [mm]."""
    found = np.median(ends), np.quantile(ends, 0.95), ends.max()
    return dict(zip(("median", "95 %", "most"), map(float, found), strict=True))
