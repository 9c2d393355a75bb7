"""Item k of a dataset, from nothing but the specification and k."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field, replace

from gcm_learn.dataset.case import Case, OracleLabel
from gcm_learn.dataset.parameters import parameters_of, quantities_of, structure_of, twin_key
from gcm_learn.dataset.spec import DatasetSpec
from gcm_learn.dataset.splits import lot_of, split_of
from gcm_learn.maps import CognitiveMap
from gcm_learn.planners import Plan
from gcm_learn.scene.bodies import TOP_SPEED
from gcm_learn.seeding import rng
from gcm_learn.situation import Situation
from gcm_learn.situation.canonical import Frame, canonical

AUDIT = 1  # salt of the lot that decides which items the oracle labels as well
LONGEST_ERROR = 300  # characters


@dataclass(frozen=True)
class Found:
    """An accepted situation, in canonical form, and what is known of it."""

    family: str
    situation: Situation
    frame: Frame
    stratum: str
    map: CognitiveMap | None
    plans: dict[str, Plan]
    oracle: OracleLabel | None
    structure: str
    parameters: object
    """(m,) float32 ndarray: see `parameters`."""
    twin_key: int
    quantities: dict[str, float]
    split: str


@dataclass
class Item:
    """What came of index k."""

    index: int
    found: Found | None = None
    """None if making it failed."""
    attempts: int = 0
    """Situations drawn."""
    rejected: Counter[str] = field(default_factory=Counter)
    """How many of them were not wanted, by stratum; also "blocked" (the limb touches an obstacle at
    t = 0) and "other" (not the wanted stratum, and not looked into any further)."""
    error: str | None = None
    """What went wrong."""


def make_item(spec: DatasetSpec, k: int) -> Item:
    """Make item k.  Whatever goes wrong is recorded: one bad item never stops a run."""
    item = Item(k)
    try:
        item.found = _find(spec, item)
        if item.found is None:
            wanted = spec.wanted(k)
            kind = "situation" if wanted is None else f"situation of stratum {wanted}"
            item.error = f"no {kind} in {spec.attempts} draws"
    except Exception as error:
        item.error = f"{type(error).__name__}: {error}"[:LONGEST_ERROR]
    return item


def _find(spec: DatasetSpec, item: Item) -> Found | None:
    """Draw until the situation is of the wanted stratum."""
    wanted = spec.wanted(item.index)
    while item.attempts < spec.attempts:
        source = rng(spec.seed, item.index, item.attempts)
        item.attempts += 1
        family = spec.choose(source)
        drawn = family.draw(source, f"{spec.name}-{item.index}")
        situation, frame = canonical(drawn)
        case = Case(situation, spec)
        verdict = case.verdict(wanted)
        if verdict == "blocked" or (wanted is not None and verdict != wanted):
            item.rejected[verdict] += 1
            continue
        return _found(spec, item.index, family.family, frame, case, verdict)
    return None


def _found(spec: DatasetSpec, k: int, family: str, frame: Frame, case: Case, stratum: str) -> Found:
    situation = case.situation
    # A record keeps one map: those of the plans would be most of a shard's memory.
    plans = {name: replace(case.plan(name), map=None) for name in spec.planners}
    audited = spec.label == "oracle" or lot_of(spec.seed, k, AUDIT) < spec.audit
    structure, parameters = structure_of(situation), parameters_of(situation)
    top_speed = float(case.problem.bodies.rows[:, TOP_SPEED].max())
    quantities = quantities_of(situation, top_speed)
    return Found(
        family=family,
        situation=situation,
        frame=frame,
        stratum=stratum,
        map=case.map(),
        plans=plans,
        oracle=case.oracle() if audited else None,
        structure=structure,
        parameters=parameters,
        twin_key=twin_key(structure, parameters),
        quantities=quantities,
        split=split_of(spec.split, spec.holdouts, spec.seed, k, family, quantities),
    )
