"""Item k of a dataset, from the specification and k alone, and kernels compiled beforehand."""

from __future__ import annotations

import contextlib
from collections import Counter
from collections.abc import Callable
from dataclasses import replace
from typing import Any, TypeVar

from filelock import FileLock
from llvmlite import binding

from gcm_learn import compiled
from gcm_learn.dataset.cases import Case
from gcm_learn.dataset.kinds import RECORDS
from gcm_learn.dataset.parameters import parameters_of, quantities_of, structure_of, twin_key
from gcm_learn.dataset.record import Record
from gcm_learn.dataset.spec import DatasetSpec
from gcm_learn.dataset.splits import lot_of, split_of
from gcm_learn.scene import TOP_SPEED
from gcm_learn.seeding import rng
from gcm_learn.situation import AnySituation, Frame, SpatialFrame, canonical

AUDIT = 1  # salt of the lot that decides which items the oracle labels as well
LONGEST_ERROR = 300  # characters


def make_item(spec: DatasetSpec, k: int) -> Record:
    """Make item k.  Errors are recorded, so a bad item never stops a run."""
    record = no_item(spec, k)
    values = record.values
    try:
        if not _find(spec, values):
            wanted = spec.wanted(k)
            kind = "situation" if wanted is None else f"situation of stratum {wanted}"
            values["error"] = f"no {kind} in {spec.attempts} draws"
    except Exception as error:
        values["error"] = f"{type(error).__name__}: {error}"[:LONGEST_ERROR]
    return record


def no_item(spec: DatasetSpec, k: int, error: str | None = None) -> Record:
    """Return item k without content, and the reason."""
    return Record(spec, {"index": k, "attempts": 0, "rejected": Counter(), "error": error})


def _find(spec: DatasetSpec, values: dict[str, Any]) -> bool:
    """Draw until the situation is of the wanted stratum, and add what is known of it."""
    k = values["index"]
    wanted = spec.wanted(k)
    while values["attempts"] < spec.attempts:
        source = rng(spec.seed, k, values["attempts"])
        values["attempts"] += 1
        family = spec.choose(source)
        situation, frame = canonical(family.draw(source, f"{spec.name}-{k}"))
        case = case_of(situation, spec)
        verdict = case.verdict(wanted)
        if verdict == "blocked" or (wanted is not None and verdict != wanted):
            values["rejected"][verdict] += 1
            continue
        values |= _known(spec, k, family.family, case, frame) | {"stratum": verdict}
        return True
    return False


def _known(
    spec: DatasetSpec, k: int, family: str, case: Case, frame: Frame | SpatialFrame
) -> dict[str, Any]:
    """The parts of a record of an accepted situation."""
    situation = case.situation
    # A record keeps one map: those of the plans would be most of a shard's memory.
    plans = {name: replace(case.plan(name), map=None) for name in spec.planners}
    audited = spec.label == "oracle" or lot_of(spec.seed, k, AUDIT) < spec.audit
    structure, parameters = structure_of(situation), parameters_of(situation)
    top_speed = float(case.problem.bodies.rows[:, TOP_SPEED].max())
    quantities = quantities_of(situation, top_speed)
    return {
        "family": family,
        "situation": situation,
        "frame": frame,
        "base": getattr(frame, "base", None),
        "map": case.map(),
        "plans": plans,
        "oracle": case.oracle() if audited else None,
        "structure": structure,
        "parameters": parameters,
        "twin_key": twin_key(structure, parameters),
        "quantities": quantities,
        "split": split_of(spec.split, spec.holdouts, spec.seed, k, family, quantities),
    }


def case_of(situation: AnySituation, spec: DatasetSpec) -> Case:
    """Return a situation with the answers of planners to it, for its kind of arm."""
    return RECORDS.of(situation).case(situation, spec)


DRAWS = 2  # items of each family
_WARM: set[str] = set()  # specifications that this process is ready for
Task = TypeVar("Task")
Result = TypeVar("Result")


def warm_up(spec: DatasetSpec) -> None:
    """Load, and compile where need be, all code that the items of a specification run.

    The first processes of a kind of machine compile one after another: numba's cache on disk is not
    made for many that compile at once.
    """
    folder = compiled.folder()
    try:
        folder.mkdir(parents=True, exist_ok=True)
        turn = FileLock(folder / "warming.lock")
        with turn:
            pass
    except OSError:  # nothing can be kept there, so nobody has to wait
        _run(spec)
        return
    done = folder / f"warm-{compiled.source_hash(__name__)}-{binding.get_host_cpu_name()}"
    if done.exists():
        _run(spec)
        return
    with turn:
        _run(spec)
        with contextlib.suppress(OSError):
            done.touch()


def warmed(spec: DatasetSpec, work: Callable[[Task], Result], task: Task) -> Result:
    """Do a task about a specification in a process that may be new."""
    if spec.digest not in _WARM:
        warm_up(spec)
        _WARM.add(spec.digest)
    return work(task)


def _run(spec: DatasetSpec) -> None:
    """Make a few items, and try all levels of all planners in a situation without a path."""
    small = replace(spec, strata=None, count=DRAWS * len(spec.families))
    examples = RECORDS.of(spec.kind).case.examples()
    for k in range(small.count):
        family = spec.families[k // DRAWS]
        alone = not examples and spec.audit > 0.0 and k == 0
        make_item(replace(small, families=(family,), audit=float(alone)), k)
    for situation in examples:
        case = case_of(situation, small)
        for name in ("straight", "marching", "layered", *spec.planners):
            case.plan(name)
        case.map()
        if spec.audit > 0.0 or spec.label == "oracle":
            case.oracle()
