"""Encoders of equal experience: each sees the catches that its memory holds, and nothing else."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from gcm_learn import get_planner, seeding
from gcm_learn.dataset import Dataset
from gcm_learn.recall import (
    Adaptation,
    Best,
    Effort,
    Encoder,
    EncoderConfig,
    Labels,
    Trainer,
    TransferLabels,
    save_encoder,
    waypoints_of,
)
from gcm_learn.recall.transfer_labels import DEPTH, EASY
from gcm_learn.situation import Pendulum, Situation

AVERAGE = 0.99  # of the weights over the steps: the package's average is for long runs
PLAIN = Adaptation(bends=0)
"""Adaptation for labels: with changes of shape, labels take fifteen times as long."""
EPOCHS = 200  # orders in which situations come again: more than are ever used up
PICK = 17  # purpose of random numbers
MOST = 11_000  # of the first records: catches that are drawn at most
FIRST = 15_000  # records that there were before more were made for 30,000 catches


def experience(records: Dataset, count: int, seed: int) -> Dataset:
    """`count` catches of the training records, drawn by a seed; fewer are among more.

    U are left out, so every record is a memory.
    """
    rows = np.flatnonzero((records.column("split") == "train") & (records.column("stratum") != "U"))
    if count > len(rows):
        raise SystemExit(f"{count} catches are asked for, there are {len(rows)}")
    return records[np.sort(rows[seeding.rng(seed, PICK).permutation(len(rows))[:count]])]


def drawn_from(records: Dataset, count: int) -> Dataset:
    """The records that so many catches are drawn from: the first ones, if they have enough."""
    if count > MOST:
        return records
    return records[np.flatnonzero(records.column("index") < FIRST)]


def with_validation(some: Dataset, records: Dataset) -> Dataset:
    """The same records and those for validation, which no lesson is about."""
    mine = np.isin(records.column("index"), some.column("index"))
    return records[np.flatnonzero(mine | (records.column("split") == "validation"))]


class Strict(TransferLabels):
    """Labels about the situations of the records alone: once all are used up they come again.

    `TransferLabels` goes on with others of the same specification. These are experience, too.
    """

    def __init__(self, records: Dataset, seed: int) -> None:
        super().__init__(records, seed)
        self._again()

    def _again(self) -> None:
        again = (seeding.rng(self.seed, PICK, epoch) for epoch in range(EPOCHS))
        self._order = np.concatenate([lots.permutation(self._order) for lots in again])

    def _valid(self, problems: list[Any], rows: np.ndarray) -> np.ndarray:
        rows = np.ascontiguousarray(rows, np.int64)
        tries = zip(problems, rows, strict=True)
        how = [(self.kind.tries(problem, PLAIN), r) for problem, r in tries]
        return np.array([t.catch_times(self.knots, self.goals, r) >= 0.0 for t, r in how])


class Prototypes(Strict):
    """The same situations, but few paths are tried in them: no situation has one of its own.

    Parameters
    ----------
    records, seed
        As for `Strict`.
    kept : (m,) ndarray of int
        Which catches of the records are the prototypes.
    """

    def __init__(self, records: Dataset, seed: int, kept: np.ndarray) -> None:
        super().__init__(records, seed)
        self.knots, self.goals = self.knots[kept], self.goals[kept]
        self.path_features = self.kind.path_features(self.knots, self.goals)

    def labels(self, index: int, best: Best | None) -> Labels:
        """Every prototype, or the best by what is known, on the next situations."""
        rng = seeding.rng(self.seed, PICK, EPOCHS, index)
        size = self.sizes.others
        mine = self._order[index * size : (index + 1) * size]
        problems = [self.kind.problem(self.situations[k], "labels") for k in mine.tolist()]
        problems += self._alone(problems, rng)
        seen, nobody = self._seen(problems), np.full(len(problems), -1)
        if best is None:
            rows = rng.permutation(len(self.knots))[: self.sizes.any]
            each = np.broadcast_to(rows, (len(problems), len(rows)))
        else:
            each = rows = self.sizes.hard(best(seen, DEPTH), rng)
        return Labels(seen, rows, self._valid(problems, each), nobody)


class Still(Strict):
    """A world in which nothing moves: the situations of the records with all bodies at rest.

    Parameters
    ----------
    records, seed
        As for `Strict`; records whose situation cannot be caught at rest are passed over.
    count : int
        Catches that are taken.
    """

    def __init__(self, records: Dataset, seed: int, count: int) -> None:
        super().__init__(records, seed)
        straight, layered = get_planner("straight"), get_planner("layered")
        kept, paths, hard = [], [], []
        for situation in self.situations:
            still = at_rest(situation)
            if still is None:
                continue
            easy = straight.plan(still)
            plan = easy if easy.caught else layered.plan(still)
            if plan.caught:
                kept.append(still)
                paths.append(waypoints_of(still, plan))
                hard.append(not easy.caught)
            if len(kept) == count:
                break
        self.situations = kept
        self.knots = np.array([path.knots for path in paths])
        self.goals = np.array([path.goal for path in paths])
        self.path_features = self.kind.path_features(self.knots, self.goals)
        lots = seeding.rng(seed, PICK, EPOCHS)
        taken = np.array(hard) | (lots.random(len(kept)) < EASY)
        self._order = np.flatnonzero(taken)
        self._again()


def at_rest(situation: Situation) -> Situation | None:
    """Obstacles as they are at t = 0 for good, the target where `layered` catches it.

    Return None if nothing is caught or something swings.
    """
    plan = get_planner("layered").plan(situation)
    if plan.catch_time is None or any(isinstance(b.motion, Pendulum) for b in situation.bodies):
        return None
    bodies = tuple(
        replace(body, motion=_resting(body.motion, plan.catch_time * (body.role == "target")))
        for body in situation.bodies
    )
    return replace(situation, bodies=bodies)


def _resting(motion: Any, t: float) -> Any:
    """A law of motion that stays where the given one is at t [s]; bodies keep their first angle."""
    laws = zip(motion.position, motion.velocity, motion.acceleration, strict=True)
    place = tuple(p + v * t + 0.5 * a * t * t for p, v, a in laws)
    none = (0.0,) * len(place)
    spin = 0.0 if isinstance(motion.spin, float) else none
    return replace(motion, position=place, velocity=none, acceleration=none, spin=spin)


def trained(data: TransferLabels, seed: int, folder: Path, turns: int, work: Path) -> Encoder:
    """An encoder, trained for some turns; its lessons stay in `work`."""
    config = EncoderConfig(seed=seed, arm=data.spec.kind.name)
    trainer = Trainer(config, data, work, Effort(turns=turns), average=AVERAGE)
    trainer.run()
    save_encoder(trainer.encoder, folder)
    scores = " ".join(f"{k}: {v:.3f}" for k, v in trainer.validate().items())
    told = f"{len(data.knots)} memories, {trainer.step} steps, {trainer.elapsed:.0f} s, {scores}"
    (folder / "told.txt").write_text(told + "\n", "utf-8")
    print(folder.name, told, flush=True)
    return trainer.encoder


def medoids(places: np.ndarray, count: int, seed: int) -> np.ndarray:
    """Of rows (n, d) the ones that are nearest to the centres of k-means."""
    from sklearn.cluster import KMeans

    scaled = (places - places.mean(axis=0)) / np.maximum(places.std(axis=0), 0.1)
    found: Any = KMeans(count, n_init=1, random_state=seed).fit(scaled)
    return np.unique(found.transform(scaled).argmin(axis=0))
