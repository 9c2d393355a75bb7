"""A life's situations, drawn and planned for once: families arriving one after the other."""

from __future__ import annotations

import pickle
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np

from gcm_learn import get_planner
from gcm_learn.dataset import DatasetSpec
from gcm_learn.families import draw
from gcm_learn.planners import Plan
from gcm_learn.situation import Situation

PART = 1000  # situations in a file


class Met(NamedTuple):
    """A situation and what the teacher makes of it."""

    family: str
    situation: Situation
    plan: Plan


@dataclass(frozen=True)
class Teacher:
    """Answers what it was asked before; nothing is planned twice."""

    plans: dict[str, Plan]
    name: str = "layered"

    def plan(self, situation: Situation) -> Plan:
        """The plan of a situation, by its name."""
        return self.plans[situation.name]


def phases(spec: DatasetSpec, count: int) -> list[tuple[str, int]]:
    """Families in the order of the specification, and how many of each, by their shares."""
    ends = np.cumsum([family.share for family in spec.families])
    ends = np.round(count * ends / ends[-1]).astype(int)
    names = [family.family for family in spec.families]
    return list(zip(names, np.diff(ends, prepend=0).tolist(), strict=True))


def life(spec: DatasetSpec, count: int) -> list[tuple[str, int]]:
    """Family and index of every situation of a life, in order."""
    families = [family for family, some in phases(spec, count) for _ in range(some)]
    return [(family, k) for k, family in enumerate(families)]


def planned(folder: Path, seed: int, which: list[tuple[str, int]]) -> list[Met]:
    """Situations of families, drawn by a seed, with the plans of `layered`; kept in files."""
    folder.mkdir(parents=True, exist_ok=True)
    out: list[Met] = []
    for first in range(0, len(which), PART):
        file = folder / f"{first:06d}.pkl"
        if not file.exists():
            part = [_met(family, seed, k) for family, k in which[first : first + PART]]
            new = file.with_suffix(".new")
            new.write_bytes(pickle.dumps(part))
            new.rename(file)
            print(file, sum(met.plan.caught for met in part), flush=True)
        out += pickle.loads(file.read_bytes())
    return out


def _met(family: str, seed: int, k: int) -> Met:
    situation = draw(family, seed, k)
    return Met(family, situation, get_planner("layered").plan(situation))
