"""Catches of datasets as Minari episodes in the arena, for offline reinforcement learning."""

from __future__ import annotations

import dataclasses
import warnings
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from gcm_learn import execution
from gcm_learn.errors import DatasetError, UnknownNameError
from gcm_learn.motion import start_clearance
from gcm_learn.registration import NAMESPACE
from gcm_learn.scene import pack

if TYPE_CHECKING:
    from minari import MinariDataset
    from minari.data_collector import EpisodeBuffer

    from gcm_learn.dataset import Dataset, Record

PART = 500
"""Records that are acted out at once."""


def export_minari(
    records: Dataset,
    dataset_id: str,
    planner: str | None = None,
    settings: execution.ArenaSettings | Mapping[str, Any] | None = None,
    *,
    author: str | None = None,
    author_email: str | None = None,
    code_permalink: str | None = None,
) -> MinariDataset:
    """Write the catches of a planner as Minari episodes of the arena.

    Catches are acted out step by step in `CatchArm-v0`, or in `CatchArm3D-v0` for spatial arms, so
    observations, actions and rewards fit the environment. A catch that the corners cut by
    steps spoil is left out. `recover_environment` of the Minari dataset makes the environment.

    Parameters
    ----------
    records : Dataset
        Records without a catch give no episode.
    dataset_id : str
        Name of the Minari dataset, e.g. ``"gcm-learn/catch-v0"``; Minari decides on the place
        (``MINARI_DATASETS_PATH``).
    planner : str, optional
        Planner of the catches; by default the one whose catches are those by waiting.
    settings : ArenaSettings or mapping, optional
        Settings of the arena.
    author, author_email, code_permalink : str, optional
        Metadata of the Minari dataset.

    Returns
    -------
    MinariDataset
        The seed of an episode is the index of its record.

    Raises
    ------
    DatasetError
        If a library is missing, or no catch is left.
    """
    planner = planner or records.spec.persistent
    if planner not in records.spec.planners:
        raise UnknownNameError.among("planner", planner, records.spec.planners)
    try:
        import gymnasium
        import minari
    except ImportError:
        raise DatasetError(
            "episodes need minari and gymnasium: pip install 'gcm_learn[export]'"
        ) from None
    arena = _arena_for(records)
    chosen = execution.settings_of(arena.settings, settings)
    buffers = list(_episodes(records, planner, chosen))
    if not buffers:
        raise DatasetError(f"{records.folder.url}: no catch of {planner} among these records")
    kwargs = {"settings": dataclasses.asdict(chosen)}
    spec = gymnasium.spec(f"{NAMESPACE}/{arena.name}")
    with warnings.catch_warnings():  # Minari warns of every field that is left out
        warnings.simplefilter("ignore", UserWarning)
        return minari.create_dataset_from_buffers(
            dataset_id,
            buffers,
            env=dataclasses.replace(spec, kwargs=kwargs),
            algorithm_name=planner,
            author=author,
            author_email=author_email,
            code_permalink=code_permalink,
            description=f"catches of the planner {planner}, dataset {records.spec.name}",
            data_format="arrow",
        )


def _arena_for(records: Dataset) -> execution.Arena:
    """Return the arena in which catches of a dataset's arms can be acted out."""
    kind = records.spec.kind
    for arena in execution.ARENAS.values():
        if arena.followed and arena.kind is kind:
            return arena
    raise DatasetError(f"{records.folder.url}: no arena takes {kind.plural}")


def _episodes(
    records: Dataset, planner: str, settings: execution.ArenaSettings
) -> Iterator[EpisodeBuffer]:
    """Act out the catches of records and give an episode for each that catches again."""
    for first in range(0, len(records), PART):
        part = [records[k] for k in range(first, min(first + PART, len(records)))]
        able = [record for record in part if _can_act(record, planner, settings)]
        if able:
            yield from _acted_out(able, planner, settings)


def _can_act(record: Record, planner: str, settings: execution.ArenaSettings) -> bool:
    """Return whether a record has a catch that takes time, from a start that the arena takes."""
    plan, situation = record.plans[planner], record.situation
    if not plan.caught or plan.trajectory is None or plan.trajectory.duration <= 0.0:
        return False
    begins = execution.arena_of(settings).begins(situation, settings.dt)
    return begins and start_clearance(pack(situation)) > 0.0


class _InBox:
    """Agent with the actions of another agent, scaled into the action space and rounded."""

    def __init__(self, agent: execution.Agent) -> None:
        self._agent = agent

    def act(self, moment: execution.Moment) -> np.ndarray:
        """Actions (n, k), numbers of single precision from -1 to 1."""
        actions = self._agent.act(moment)
        largest = np.abs(actions).max(axis=1, keepdims=True)
        return (actions / np.maximum(largest, 1.0)).astype(np.float32).astype(float)


def _acted_out(
    records: list[Record], planner: str, settings: execution.ArenaSettings
) -> Iterator[EpisodeBuffer]:
    from minari.data_collector import EpisodeBuffer

    pool, steps = (
        execution.pool_for(settings, [record.situation for record in records]),
        list[execution.Steps](),
    )
    plans = [record.plans[planner].trajectory for record in records]
    agent = _InBox(execution.follower_of(plans, pool, settings.dt))
    execution.run_episode(
        agent, execution.plant_of(pool, len(pool), settings), np.arange(len(pool)), steps.append
    )
    moves = execution.Steps(*map(np.concatenate, zip(*steps, strict=True)))
    for arm, record in enumerate(records):
        mine = np.flatnonzero(moves.arms == arm)
        if moves.outcomes[mine[-1]] != execution.CAUGHT:
            continue
        yield EpisodeBuffer(
            id=None,
            seed=record.index,
            observations=np.concatenate([moves.told[mine], moves.following[mine[-1:]]]),
            actions=moves.actions[mine],
            rewards=moves.rewards[mine].astype(float),
            terminations=mine == mine[-1],
            truncations=np.zeros(len(mine), bool),
            infos={},
        )
