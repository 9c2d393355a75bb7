"""Item k of a dataset, from the specification and k alone, and kernels compiled beforehand."""

from __future__ import annotations

import contextlib
import hashlib
import math
from collections import Counter
from collections.abc import Callable
from dataclasses import replace
from typing import Any, TypeVar

import numpy as np
from filelock import FileLock
from llvmlite import binding

from gcm_learn import compiled
from gcm_learn.arms import rotation_of
from gcm_learn.dataset.cases import CASES, BaseCase
from gcm_learn.dataset.kinds import RECORDS
from gcm_learn.dataset.record import Record
from gcm_learn.dataset.spec import DatasetSpec
from gcm_learn.dataset.splits import lot_of, split_of
from gcm_learn.scene import TOP_SPEED, entry_of
from gcm_learn.seeding import rng
from gcm_learn.situation import (
    AnySituation,
    Body,
    Frame,
    Motion,
    Pendulum,
    Piecewise,
    PlanarQuadratic,
    Sampled,
    SolidQuadratic,
    SpatialFrame,
    canonical,
    numbers_of,
)

DIGITS = 5  # of parameters that twins share [powers of ten of a forearm length]


def structure_of(situation: AnySituation) -> str:
    """Name a situation's structure: arm and kinds of bodies, e.g. ``arm|disc|polygon4``.

    Only situations of the same structure can be compared number by number.
    """
    return "|".join([RECORDS.of(situation).word(situation), *map(_kind, _in_order(situation))])


def parameters_of(situation: AnySituation) -> np.ndarray:
    """Return the parameters (m,) float32 of a canonical situation; the structure explains them.

    Targets come first; obstacles are sorted by kind, then by distance from the shoulder, so that
    the order in which they were listed does not matter.
    """
    arm, horizon = situation.arm, situation.horizon
    numbers = RECORDS.of(situation).numbers(arm, horizon)
    for body in _in_order(situation):
        numbers += _motion_numbers(body, horizon)
        numbers += numbers_of(body.shape)
    unit = RECORDS.of(situation).forearm(arm)
    return np.array(numbers if unit == 1.0 else [n / unit for n in numbers], dtype=np.float32)


def twin_key(structure: str, parameters: np.ndarray) -> int:
    """Key (63 bits) that situations share when their parameters agree to DIGITS digits."""
    rounded = np.round(parameters.astype(float), DIGITS) + 0.0  # no negative zeros
    digest = hashlib.blake2b(structure.encode() + rounded.tobytes(), digest_size=8).digest()
    return int.from_bytes(digest, "little") >> 1


def _in_order(situation: AnySituation) -> list[Body]:
    obstacles = sorted(situation.obstacles, key=lambda body: (_kind(body), _distance(body)))
    return [*situation.targets, *obstacles]


def _place(body: Body) -> tuple[float, ...]:
    """Return the pivot of a swing, or the place of a body at t = 0."""
    motion = body.motion
    if isinstance(motion, Pendulum):
        return motion.pivot
    if isinstance(motion, Sampled):
        return motion.positions[0]
    return motion.pieces[0].motion.position if isinstance(motion, Piecewise) else motion.position


def _distance(body: Body) -> float:
    return math.hypot(*_place(body))


def _kind(body: Body) -> str:
    shape = body.shape
    corners = len(entry_of(shape).vertices(shape)) or ""
    asked = "<" * len(body.approach) + "".join(s for s, given in _asked(body).items() if given)
    return f"{shape.kind}{corners}{_law(body.motion)}{asked}"


def _asked(body: Body) -> dict[str, tuple[float, ...]]:
    """Return the numbers of hold, place and margin [s, lengths, lengths/s], by a sign of each."""
    hold, place, margin = body.hold, body.place, body.margin
    return {
        "=": (hold.seconds, hold.relative_speed) if hold else (),
        "@": (*place.position, place.within) if place else (),
        "%": (margin.now, margin.rate) if margin else (),
    }


def _law(motion: Motion) -> str:
    """Return the sign of a law of motion: its kind, and the number of pieces or samples."""
    if isinstance(motion, Pendulum):
        return "~"
    if isinstance(motion, Piecewise):
        return f"^{len(motion.pieces)}"
    if isinstance(motion, Sampled):
        return f"*{len(motion.times)}{'' if motion.orientations is None else 'o'}"
    return ""


def _motion_numbers(body: Body, horizon: float) -> list[float]:
    """Return the numbers of a body's motion and approach, and of its hold, place and margin."""
    motion, radius = body.motion, body.shape.bounding_radius
    numbers: list[float] = []
    if isinstance(motion, Pendulum):
        numbers = _swing_numbers(motion, horizon)
    elif isinstance(motion, Sampled):
        numbers = [horizon * t for t in motion.times]
        numbers += [x for place in motion.positions for x in place]
        for turn in () if entry_of(body.shape).is_ball else motion.orientations or ():
            numbers += (radius * _seen(body, turn)).tolist()
    elif isinstance(motion, Piecewise):
        for start, piece in motion.pieces:
            numbers += [horizon * start, *_flight_numbers(body, piece, horizon)]
    else:
        numbers = _flight_numbers(body, motion, horizon)
    for approach in body.approach:
        numbers += [radius * x for x in (*approach.axis, approach.within)]
    return numbers + [x for asked in _asked(body).values() for x in asked]


def _swing_numbers(motion: Pendulum, horizon: float) -> list[float]:
    """Return the numbers of a swing."""
    swing = [motion.angle, motion.rate * horizon, motion.damping * horizon]
    fall = 0.5 * motion.gravity * horizon**2
    lengths = [motion.length, motion.hang_distance, fall]
    turns = [motion.length * s for s in swing]
    return [*motion.pivot, *motion.axis, *motion.down, *lengths, *turns]


def _flight_numbers(
    body: Body, motion: PlanarQuadratic | SolidQuadratic, horizon: float
) -> list[float]:
    """Return the numbers of one quadratic law of a body."""
    radius = body.shape.bounding_radius
    numbers = [*motion.position, *(v * horizon for v in motion.velocity)]
    numbers += [0.5 * a * horizon**2 for a in motion.acceleration]
    if entry_of(body.shape).is_ball:
        return numbers  # no turn can be seen
    if isinstance(motion, PlanarQuadratic):
        c, s = math.cos(motion.angle), math.sin(motion.angle)
        return [*numbers, radius * c, radius * s, radius * motion.spin * horizon]
    turn = (radius * s * horizon for s in motion.spin)
    return [*numbers, *(radius * _seen(body, motion.orientation)).tolist(), *turn]


def _seen(body: Body, orientation: tuple[float, ...]) -> np.ndarray:
    """Return the axes that show a body's orientation: z (3,) of a round body, else x and z (6,)."""
    axes = rotation_of(orientation)
    seen: np.ndarray = axes[:, 2] if entry_of(body.shape).is_round else axes[:, ::2].ravel()
    return seen


def quantities_of(situation: AnySituation, top_speed: float) -> dict[str, float]:
    """Return the numbers that range splits compare; lengths in forearms.

    Parameters
    ----------
    situation : Situation
    top_speed : float
        Largest speed of any body within the horizon [lengths / s].
    """
    obstacles, kind = situation.obstacles, RECORDS.of(situation)
    unit, (upper_arm, hand_speed) = kind.forearm(situation.arm), kind.sizes(situation)
    return {
        "upper_arm": upper_arm / unit,
        "max_hand_speed": hand_speed / unit,
        "horizon": situation.horizon,
        "obstacles": float(len(obstacles)),
        "top_speed": top_speed / hand_speed,
        "largest": max((body.shape.bounding_radius for body in obstacles), default=0.0) / unit,
    }


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
    """Draw until a situation has the wanted stratum; fill in `values`, return True if found."""
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
    spec: DatasetSpec, k: int, family: str, case: BaseCase, frame: Frame | SpatialFrame
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


def case_of(situation: AnySituation, spec: DatasetSpec) -> BaseCase:
    """Return the case of a situation, of the class for its kind of arm."""
    return CASES.of(situation)(situation, spec)


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
    examples = CASES.of(spec.kind).examples()
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
