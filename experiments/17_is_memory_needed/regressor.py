"""A regressor in place of a memory: from what a situation looks like to twenty paths.

It learns from the very labels of an encoder: of the memories that are valid in a situation each
pulls the nearest of the paths towards it, the others hardly (multiple choice learning: Guzman-
Rivera, Batra and Kohli, NIPS 2012; relaxed as by Rupprecht et al., ICCV 2017). A second output says
which of them will be the nearest.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import torch
from answers import CHECKS, Answer, Ask
from torch import Tensor, nn
from torch.nn import functional

from experiments.common.questions import Question
from gcm_learn import seeding
from gcm_learn.planners import Problem
from gcm_learn.recall import Adaptation, EncoderConfig, Labels
from gcm_learn.recall.adaptation import HandTries
from gcm_learn.recall.features import STEPS, FeatureBatch, batched
from gcm_learn.recall.hand_features import clearance_features
from gcm_learn.recall.hand_paths import EARLIEST, KNOTS, TIME
from gcm_learn.recall.networks import EncoderNet, Inputs
from gcm_learn.recall.planners import _first_plan, _offer
from gcm_learn.recall.trials import Budget

WIDTH = 256
SHOWN = 8  # valid memories of a situation that are looked at in a step
OTHERS = 0.05  # weight of the paths that are not the nearest
RATE, DECAY = 1.5e-3, 0.02  # as of encoders
WAITS = 0.5  # a knot waits if it is told to be there no earlier than this share of its time


class Paths(nn.Module):
    """The towers of an encoder, then twenty paths and how likely each is."""

    def __init__(self, mean: np.ndarray, spread: np.ndarray, features: FeatureBatch) -> None:
        super().__init__()
        self.numbers = len(mean)
        sizes = Inputs(features.context.shape[1], features.cells.shape[1], 1)
        self.look = EncoderNet(EncoderConfig(dim=WIDTH), sizes)
        self.middle = nn.Linear(WIDTH, WIDTH)
        self.paths = nn.Linear(WIDTH, CHECKS * self.numbers)
        self.choice = nn.Linear(WIDTH, CHECKS)
        self.register_buffer("mean", torch.from_numpy(mean))
        self.register_buffer("spread", torch.from_numpy(spread))

    def forward(self, features: FeatureBatch) -> tuple[Tensor, Tensor]:
        """Scaled paths (n, CHECKS, numbers), scores (n, CHECKS)."""
        inner = torch.relu(self.middle(torch.relu(self.look.queries(features))))
        return self.paths(inner).view(-1, CHECKS, self.numbers), self.choice(inner)


def told(knots: np.ndarray, goals: np.ndarray) -> np.ndarray:
    """Memories as numbers (n, m) float32."""
    return np.hstack([knots.reshape(len(knots), -1), goals]).astype(np.float32)


def regressor(lessons: Path, paths: np.ndarray, seed: int, steps: int) -> Paths:
    """Train it on the lessons of a folder."""
    batches = [Labels.load(file) for file in sorted(lessons.glob("lesson-*.npz"))]
    mean, spread = paths.mean(axis=0), np.maximum(paths.std(axis=0), 0.05)
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(seed)
        net = Paths(mean, spread, batches[0].features)
    context, cells = batches[0].features.context, batches[0].features.cells
    whose = batches[0].features.whose
    net.look.situation.fit_scale(context)
    net.look.body.fit_scale(np.hstack([context[whose], cells.astype(np.float32) / STEPS]))
    scaled = torch.from_numpy((paths - mean) / spread)
    optimiser: Any = torch.optim.AdamW(net.parameters(), RATE, weight_decay=DECAY)
    schedule = torch.optim.lr_scheduler.CosineAnnealingLR(optimiser, steps)
    for step in range(steps):
        rng = seeding.rng(seed, 5, step)
        batch = batches[int(rng.integers(len(batches)))]
        rows, which = shown(batch, rng)
        made, scores = net(batch.features)
        away = ((made[which][:, None] - scaled[rows][:, :, None]) ** 2).mean(dim=3)
        least, nearest = away.min(dim=2)
        loss = least.mean() + OTHERS * away.mean()
        odds = functional.log_softmax(scores[which], dim=1)
        loss = loss - 0.1 * odds.gather(1, nearest).mean()
        optimiser.zero_grad(set_to_none=True)
        loss.backward()
        torch.nn.utils.clip_grad_norm_(net.parameters(), 1.0)
        optimiser.step()
        schedule.step()
    return net.eval()


def shown(batch: Labels, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Valid memories (n, SHOWN) of the situations (n,) that have any; few are shown repeatedly."""
    each = np.broadcast_to(batch.rows, batch.valid.shape)
    which = np.flatnonzero(batch.valid.any(axis=1))
    lots = np.where(batch.valid[which], rng.random((len(which), batch.valid.shape[1])), 2.0)
    order = np.argsort(lots, axis=1)[:, :SHOWN]
    count = np.minimum(batch.valid[which].sum(axis=1), SHOWN)
    order = np.take_along_axis(order, np.arange(SHOWN)[None] % count[:, None], axis=1)
    return np.take_along_axis(each[which], order, axis=1), which


@torch.no_grad()
def proposed(net: Paths, problem: Problem) -> tuple[np.ndarray, np.ndarray]:
    """Knots (CHECKS, KNOTS, 4) and goals (CHECKS, 2), the likeliest first."""
    seen = batched([clearance_features(problem.situation, problem.scene)])
    made, scores = net(seen)
    numbers = (made[0] * net.spread + net.mean)[torch.argsort(-scores[0])].numpy()
    knots = numbers[:, :-2].reshape(CHECKS, KNOTS, 4)
    time = np.maximum.accumulate(np.maximum(knots[:, :, TIME], 0.0), axis=1)
    waits = knots[:, :, EARLIEST] > WAITS * np.maximum(time, 1e-3)
    knots[:, :, TIME] = time
    knots[:, :, EARLIEST] = np.where(waits, np.minimum(knots[:, :, EARLIEST], time), 0.0)
    return np.ascontiguousarray(knots), np.ascontiguousarray(numbers[:, -2:])


def by_regressor(net: Paths) -> Ask:
    """Return its paths, adapted, changed and checked like memories."""

    def ask(question: Question, checks: int) -> Answer:
        problem = Problem(question.situation, "regressor")
        answer = problem.early_answer()
        if answer is not None:
            return Answer(answer, 0)
        how = Adaptation()
        paths = proposed(net, problem)
        offer = _offer(np.arange(checks), paths[0])
        budget = Budget(how.bends, checks, 0.0, 0.0)
        plan, _, tried = _first_plan(problem, HandTries(problem, how), paths, offer, budget)
        return Answer(plan, tried)

    return ask
