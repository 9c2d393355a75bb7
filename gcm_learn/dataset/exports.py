"""Catches as episodes for offline reinforcement learning.

Hugging Face `datasets` needs no export: ``load_dataset("parquet", data_files=records.files)``.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np

from gcm_learn.arms import elbow_position
from gcm_learn.dataset import Dataset, Record
from gcm_learn.dataset.kinds import RECORDS
from gcm_learn.errors import DatasetError, UnknownNameError
from gcm_learn.planners import Plan
from gcm_learn.scene import pack_bodies, poses_at
from gcm_learn.situation import Situation

if TYPE_CHECKING:
    from minari import MinariDataset

STEP = 0.02  # [s] of an episode
BODIES = 8  # that an observation has room for
PER_BODY = 7  # x, y, z, velocity x, y, bounding radius, 1 for a target and -1 for an obstacle
ARM = 7  # share of the horizon that has passed, hand x, y, elbow x, y, upper arm, hand speed
INSTANT = 1e-4  # [s] over which velocities are measured


def export_minari(
    records: Dataset, dataset_id: str, planner: str = "layered", step: float = STEP
) -> MinariDataset:
    """Write the catches of a planner as Minari episodes, in canonical coordinates.

    An observation is a vector of `ARM` + `BODIES` * `PER_BODY` numbers, targets first, the rest 0.
    An action is the hand's velocity during a step as a share of its limit. The reward is 1 at the
    catch and 0 before. The last step is as long as is left.

    Parameters
    ----------
    records : Dataset
        Those without a catch give no episode.
    dataset_id : str
        Name of the Minari dataset, e.g. ``"gcm-learn/catch-v0"``; where it goes is Minari's
        business (``MINARI_DATASETS_PATH``).
    planner : str
        Whose plans are shown.
    step : float
        Control interval [s].
    """
    if planner not in records.spec.planners:
        raise UnknownNameError.among("planner", planner, records.spec.planners)
    try:
        import minari
        from gymnasium.spaces import Box
        from minari.data_collector import EpisodeBuffer
    except ImportError:
        raise DatasetError(
            "episodes need minari and gymnasium: pip install 'gcm_learn[export]'"
        ) from None
    if not RECORDS.of(records.spec.kind).episodes:
        raise DatasetError(f"{records.folder.url}: episodes are of planar arms")
    size = ARM + BODIES * PER_BODY
    buffers = [
        EpisodeBuffer(id=k, seed=index, **_columns(observations, actions))
        for k, (index, observations, actions) in enumerate(_episodes(records, planner, step))
    ]
    if not buffers:
        raise DatasetError(f"{records.folder.url}: no catch of {planner} among these records")
    return minari.create_dataset_from_buffers(
        dataset_id,
        buffers,
        algorithm_name=planner,
        observation_space=Box(-np.inf, np.inf, (size,), np.float64),
        action_space=Box(-1.0 - 1e-6, 1.0 + 1e-6, (2,), np.float64),
        description=f"catches of the planner {planner}, data set {records.spec.name}",
        data_format="arrow",
    )


def _columns(observations: np.ndarray, actions: np.ndarray) -> dict[str, Any]:
    last = np.arange(len(actions)) == len(actions) - 1
    return {
        "observations": observations,
        "actions": actions,
        "rewards": last.astype(float),
        "terminations": last,
        "truncations": np.zeros(len(actions), dtype=bool),
        "infos": {},
    }


def _episodes(
    records: Dataset, planner: str, step: float
) -> Iterator[tuple[int, np.ndarray, np.ndarray]]:
    """Index, observations (m + 1, p) and actions (m, 2) of every catch that takes time."""
    for record in records:
        plan = record.plans[planner]
        if plan.caught and plan.trajectory is not None and plan.trajectory.duration > 0.0:
            yield (record.index, *episode_of(record, plan, step))


def episode_of(record: Record, plan: Plan, step: float) -> tuple[np.ndarray, np.ndarray]:
    """Observations (m + 1, p) and actions (m, 2) of a catch; the last step may be a short one."""
    situation, trajectory = record.situation, plan.trajectory
    if trajectory is None:
        raise DatasetError(f"item {record.index}: the plan of {plan.planner} is no catch")
    time = np.append(np.arange(0.0, trajectory.duration, step), trajectory.duration)
    if len(time) > 2 and time[-1] - time[-2] < 1e-9:
        time = np.delete(time, -2)
    hand = trajectory.hand_at(time)
    actions = np.diff(hand, axis=0) / np.diff(time)[:, None] / situation.arm.max_hand_speed
    return _observations(situation, time, hand), actions


def _observations(situation: Situation, time: np.ndarray, hand: np.ndarray) -> np.ndarray:
    arm, bodies = situation.arm, pack_bodies(situation)
    order = sorted(range(len(situation.bodies)), key=lambda b: situation.bodies[b].role != "target")
    out = np.zeros((len(time), ARM + BODIES * PER_BODY))
    out[:, 0] = time / situation.horizon
    out[:, 1:3], out[:, 3:5] = hand, elbow_position(hand, arm.upper_arm, arm.elbow)
    out[:, 5], out[:, 6] = arm.upper_arm, arm.max_hand_speed
    now, soon = np.zeros((2, len(situation.bodies), 12))
    for row, t in zip(out, time, strict=True):
        before = min(t, situation.horizon - INSTANT)  # pendulums are tabled until the horizon
        poses_at(bodies, before, now)
        poses_at(bodies, before + INSTANT, soon)
        velocity = (soon[:, :2] - now[:, :2]) / INSTANT
        poses_at(bodies, t, now)
        for place, b in enumerate(order[:BODIES]):
            body = situation.bodies[b]
            role = 1.0 if body.role == "target" else -1.0
            first = ARM + place * PER_BODY
            row[first : first + PER_BODY] = (*now[b, :3], *velocity[b], 0.0, role)
            row[first + 5] = body.shape.bounding_radius
    return out
