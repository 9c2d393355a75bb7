"""The comparison itself: every method on every situation, on all cores."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import lru_cache, partial
from typing import Any

import numpy as np

from gcm_learn.arms import SIDE, elbow_of, kind_of
from gcm_learn.collision import segment_distance
from gcm_learn.evaluation.crew import Rows, rows_of
from gcm_learn.evaluation.methods import Method, Result, get_method
from gcm_learn.evaluation.suites import Entry
from gcm_learn.evaluation.table import Results
from gcm_learn.evaluation.thinking import charged
from gcm_learn.motion import PARTS, SpatialTrajectory, Trajectory, clearance, joint_turns
from gcm_learn.scene import LIMB, PART, pack, poses_at
from gcm_learn.situation import AnySituation, Situation, planar

DELAYS = (0.0, 0.02, 0.05, 0.1, 0.2)  # thinking that is charged [s]
_CHUNK = 10  # situations that a process takes at once
_POINTS = 101  # of each part of the limb, or of a way, among which an extreme one is looked for


def compare(
    names: Sequence[str],
    entries: Sequence[Entry],
    *,
    charge: int = 100,
    workers: int | None = None,
    cluster: str | None = None,
    progress: Callable[[int], object] = lambda count: None,
) -> Results:
    """Let methods answer the same situations.

    Parameters
    ----------
    names : sequence of str
        See `methods.get_method`.
    entries : sequence of Entry
    charge : int
        Situations of each stratum for which charged thinking is measured.
    workers, cluster
        See `processes.crew_of`.  Thinking takes the time that it takes there.
    progress : callable
        Told how many answers are new.

    Returns
    -------
    Results
        Ordered by method and situation.
    """
    for name in names:  # refused here rather than in a process
        check_arms(name, entries)
    marked = zip(entries, _marked(entries, charge), strict=True)
    ordered = sorted(marked, key=lambda pair: (pair[0].suite, pair[0].index))
    calls = [
        partial(_answers, name, ordered[first : first + _CHUNK])
        for name in names
        for first in range(0, len(ordered), _CHUNK)
    ]
    return Results.of(rows_of(calls, workers, cluster, progress))


def check_arms(name: str, entries: Sequence[Entry]) -> None:
    """Refuse a method that there is not, or that does not take the arms of all situations.

    Raises
    ------
    UnknownNameError, ArmKindError
    """
    method = get_method(name)
    for entry in entries:
        if not method.takes(kind_of(entry.situation)):
            planar(entry.situation, f"policy {name!r}")


def _marked(entries: Sequence[Entry], charge: int) -> list[bool]:
    """The first `charge` of each stratum."""
    seen: dict[str, int] = {}
    marks = []
    for entry in entries:
        seen[entry.stratum] = seen.get(entry.stratum, 0) + 1
        marks.append(seen[entry.stratum] <= charge)
    return marks


@lru_cache(maxsize=32)
def warmed(name: str, spatial: bool = False) -> Method:
    """A method that has answered once: what is compiled or loaded then is no thinking."""
    from gcm_learn.families import draw

    made = get_method(name)
    for k in range(3):
        made.run(draw("crossing-swarm-space" if spatial else "crossing-swarm", 3, k))
    return made


def _answers(name: str, entries: Sequence[tuple[Entry, bool]]) -> Rows:
    """A method's rows for some situations, and whether its thinking is charged there."""
    made = {kind: warmed(name, kind) for kind in {e.situation.is_spatial for e, _ in entries}}
    return [row_of(made[e.situation.is_spatial], e, charge) for e, charge in entries]


def row_of(made: Method, entry: Entry, charge: bool) -> dict[str, Any]:
    """One answer, with everything that is measured of it."""
    situation = entry.situation
    result = made.run(situation)
    row: dict[str, Any] = {
        "suite": entry.suite,
        "index": entry.index,
        "family": entry.family,
        "stratum": entry.stratum,
        "earliest": entry.earliest,
        "entrant": made.name,
        "outcome": result.outcome,
        "latency_ms": result.latency,
        **_movement(situation, result),
    }
    for delay in DELAYS:
        key = f"charged_{round(1e3 * delay)}"
        row[key] = None
        if charge:
            row[key] = result.outcome if delay == 0.0 else charged(made, situation, delay)
    row["charged_own"] = None
    if charge:
        row["charged_own"] = charged(made, situation, 1e-3 * result.latency)
    return row


def _movement(situation: AnySituation, result: Result) -> dict[str, Any]:
    """Numbers of the hand's path; lengths in forearms."""
    names = ("end", "length", "clearance", "peak_hand", "peak_shoulder", "peak_elbow", "part")
    out: dict[str, Any] = dict.fromkeys(names)
    path = result.trajectory
    if path is None:
        return out
    if isinstance(path, SpatialTrajectory):
        return out | _movement_in_space(path, result.clearance)
    situation = planar(situation, "a path of the plane")
    arm = situation.arm
    spans = np.maximum(np.diff(path.time), 1e-12)
    out |= {"end": path.duration, "length": path.length, "clearance": result.clearance}
    if result.clearance is None and result.outcome == "caught":
        out["clearance"], _ = clearance(situation, path)
    if len(spans):
        steps = np.sqrt((np.diff(path.hand, axis=0) ** 2).sum(axis=1))
        turns = joint_turns(path.hand, arm.upper_arm, SIDE[arm.elbow], PARTS) / spans[:, None]
        out["peak_hand"] = float((steps / spans).max())
        out["peak_shoulder"], out["peak_elbow"] = (float(v) for v in turns.max(axis=0))
    if result.outcome == "touched":
        out["part"] = collided_part(situation, path)
    return out


def _movement_in_space(path: SpatialTrajectory, clearance: float | None) -> dict[str, Any]:
    """The same; joints 1 and 2 are the shoulder's, 3 and 4 the elbow's."""
    unit = float(np.linalg.norm(path.arm.forearm))
    time = np.linspace(0.0, path.duration, _POINTS)
    span = max(path.duration / (_POINTS - 1), 1e-12)
    speeds = np.linalg.norm(np.diff(path.hand_at(time), axis=0), axis=1) / span
    rates = np.abs(np.diff(path.joints_at(time), axis=0)).max(axis=0) / span
    return {
        "end": path.duration,
        "length": path.length / unit,
        "clearance": None if clearance is None else clearance / unit,
        "peak_hand": float(speeds.max()) / unit,
        "peak_shoulder": float(rates[:2].max()),
        "peak_elbow": float(rates[2:].max()),
    }


def collided_part(situation: Situation, path: Trajectory) -> str:
    """Which part of the limb is nearer to an obstacle at the end of a path."""
    elbow, hand, distance = _at_end(situation, path)
    return "forearm" if distance(elbow, hand) <= distance(np.zeros(2), elbow) else "upper arm"


def collision_point(situation: Situation, path: Trajectory) -> np.ndarray:
    """The point (2,) of the limb that is nearest to an obstacle at the end of a path."""
    elbow, hand, distance = _at_end(situation, path)
    shares = np.linspace(0.0, 1.0, _POINTS)[:, None]
    points = np.concatenate([shares * elbow, elbow + shares * (hand - elbow)])
    return np.asarray(min(points, key=lambda point: distance(point, point)))


def _at_end(
    situation: Situation, path: Trajectory
) -> tuple[np.ndarray, np.ndarray, Callable[[np.ndarray, np.ndarray], float]]:
    """Elbow (2,) and hand (2,) at the end of a path, and how far segments are from obstacles."""
    (bodies, limb, _), hand = pack(situation), path.hand[-1]
    poses = np.zeros((len(situation.bodies), 12))
    poses_at(bodies, path.duration, poses)
    obstacles = np.flatnonzero(bodies.rows[:, PART] == LIMB)

    def distance(start: np.ndarray, end: np.ndarray) -> float:
        near = (segment_distance(bodies, poses, b, *start, *end) for b in obstacles)
        return float(min(near, default=np.inf))

    return np.array(elbow_of(hand[0], hand[1], limb.rho, limb.side)), hand, distance
