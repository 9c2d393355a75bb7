"""An order of stored catches that is learned for seeds: which of them make trees meet."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from planting import meet_alone
from sources import seeds_of

from gcm_learn.dataset import Dataset
from gcm_learn.planners.joints.trees import new_trees
from gcm_learn.planners.joints.ways import new_way
from gcm_learn.recall import EncoderConfig, Sizes, TransferLabels, save_encoder
from gcm_learn.recall.training import Effort, Trainer

LESSON = Sizes(256, 80)
ROOM = 64  # nodes of a tree with one seed
DIM = 48  # as of the shipped encoder


class SeedLabels(TransferLabels):
    """Labels that say whether a memory, as a seed, makes trees of the start meet."""

    def _valid(self, problems: list[Any], rows: np.ndarray) -> np.ndarray:
        return np.array([self._meet(p, self.knots[r]) for p, r in zip(problems, rows, strict=True)])

    def _meet(self, problem: Any, knots: np.ndarray) -> np.ndarray:
        study = problem.study
        trees, way = new_trees(study, ROOM, 1, problem.accelerates), new_way(study.goal.size)
        end = problem.situation.horizon
        found: np.ndarray = meet_alone(study, trees, seeds_of(problem, knots), True, end, way)
        return found


def train(records: Dataset, folder: Path, seed: int, turns: int) -> None:
    """Train an encoder on the catches of records, as seeds."""
    labels = SeedLabels(records, seed, sizes=LESSON)
    config = EncoderConfig(dim=DIM, seed=seed, arm=records.spec.kind.name)
    trainer = Trainer(config, labels, folder / "work.tmp", Effort(turns=turns))
    trainer.run()
    print({name: round(score, 3) for name, score in trainer.validate().items()})
    save_encoder(trainer.encoder, folder)
