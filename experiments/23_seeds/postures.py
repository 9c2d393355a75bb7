"""A learned model of postures that catch: from a situation's features to seeds, without memories.

The seed that is nearest to a catch is pulled towards it, the others hardly. This
multiple choice learning is that of Guzman-Rivera, Batra and Kohli (NIPS 2012), relaxed as by
Rupprecht et al. (ICCV 2017). A second output says which of them will be the nearest.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import torch
from planting import Seeds, plant
from sources import GATES
from torch import Tensor, nn
from torch.nn import functional

from gcm_learn import seeding
from gcm_learn.arms import CHAIN
from gcm_learn.recall import MEMORIES, EncoderConfig, Memory
from gcm_learn.recall.features import STEPS, FeatureBatch, Features, batched
from gcm_learn.recall.headings import heading_of
from gcm_learn.recall.networks import EncoderNet, Inputs

SAID = 20  # seeds of a situation
DIM = 128
OTHERS = 0.05  # weight of the seeds that are not the nearest
CHOICE = 0.1  # weight of which will be the nearest
RATE, DECAY = 5e-4, 0.1
BATCH = 256
EVERY = 25  # steps between two looks at what is held out


class PostureNet(nn.Module):
    """The towers of an encoder, then seeds and how likely each is the nearest."""

    def __init__(self, context: int, cells: int, numbers: int) -> None:
        super().__init__()
        self.look = EncoderNet(EncoderConfig(dim=DIM), Inputs(context, cells, 1))
        self.seeds = nn.Linear(DIM, SAID * numbers)
        self.choice = nn.Linear(DIM, SAID)
        self.register_buffer("mean", torch.zeros(numbers))
        self.register_buffer("spread", torch.ones(numbers))

    def forward(self, features: FeatureBatch) -> tuple[Tensor, Tensor]:
        """Scaled seeds (n, SAID, numbers), scores (n, SAID)."""
        inner = torch.relu(self.look.queries(features))
        return self.seeds(inner).view(len(inner), SAID, -1), self.choice(inner)


def numbers_of(knots: np.ndarray) -> np.ndarray:
    """Return what is to be said of movements (n, knots, joints + 2): numbers (n, m) float32."""
    some = knots[:, np.array(GATES), :-1]  # the joints, then the time
    return some.reshape(len(knots), -1).astype(np.float32)


def trained(memory: Memory, seed: int, steps: int) -> PostureNet:
    """Learn the catches of a memory; one of ten decides which step is kept."""
    kind = MEMORIES.of(CHAIN)
    seen = [kind.features(situation) for situation in memory.situations()]
    wanted = numbers_of(memory.knots)
    lots = seeding.rng(seed, 23).permutation(len(seen))
    held, used = lots[: len(lots) // 10], lots[len(lots) // 10 :]
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(seed)
        net = PostureNet(seen[0].context.size, seen[0].cells.shape[1], wanted.shape[1])
    net.mean.copy_(torch.from_numpy(wanted.mean(axis=0)))
    net.spread.copy_(torch.from_numpy(np.maximum(wanted.std(axis=0), 0.05)))
    whole = batched([seen[k] for k in used])
    net.look.situation.fit_scale(whole.context)
    cells = whole.cells.astype(np.float32) / STEPS
    net.look.body.fit_scale(np.hstack([whole.context[whole.whose], cells]))
    optimiser: Any = torch.optim.AdamW(net.parameters(), RATE, weight_decay=DECAY)
    schedule = torch.optim.lr_scheduler.CosineAnnealingLR(optimiser, steps)
    best, kept = np.inf, net.state_dict()
    for step in range(steps):
        rows = used[seeding.rng(seed, 24, step).permutation(len(used))[:BATCH]]
        loss = loss_of(net, seen, wanted, rows)
        optimiser.zero_grad(set_to_none=True)
        loss.backward()
        torch.nn.utils.clip_grad_norm_(net.parameters(), 1.0)
        optimiser.step()
        schedule.step()
        if (step + 1) % EVERY == 0:
            with torch.no_grad():
                found = float(loss_of(net, seen, wanted, held))
            if found < best:
                best, kept = found, {k: v.clone() for k, v in net.state_dict().items()}
                print(f"step {step + 1}: {float(loss.detach()):.3f}, held out {found:.3f}")
    net.load_state_dict(kept)
    return net.eval()


def loss_of(net: PostureNet, seen: list[Features], wanted: np.ndarray, rows: np.ndarray) -> Tensor:
    """Loss of the situations `rows`."""
    made, scores = net(batched([seen[k] for k in rows]))
    scaled = (torch.from_numpy(wanted[rows]) - net.mean) / net.spread
    away = ((made - scaled[:, None]) ** 2).mean(dim=2)
    least, nearest = away.min(dim=1)
    chosen = functional.cross_entropy(scores, nearest)
    loss: Tensor = least.mean() + OTHERS * away.mean() + CHOICE * chosen
    return loss


@dataclass(frozen=True)
class Said:
    """Seeds of the model, the likeliest first."""

    net: PostureNet
    count: int
    """Seeds at most."""
    gates: bool
    """True if postures on the way are planted, too."""

    @torch.no_grad()
    def __call__(self, problem: Any, trees: Any, end: float, way: Any) -> bool:
        """Plant them."""
        seen = MEMORIES.of(CHAIN).features(problem.situation, problem.scene)
        made, scores = self.net(batched([seen]))
        order = torch.argsort(-scores[0])[: self.count]
        said = (made[0, order] * self.net.spread + self.net.mean).numpy().astype(float)
        states = said.reshape(len(said), len(GATES), -1)
        limb = problem.study.scene.limb
        joints = states[:, :, :-1] + heading_of(limb, problem.scene).shift
        joints = np.ascontiguousarray(np.clip(joints, limb.low, limb.high))
        seeds = Seeds(joints, np.ascontiguousarray(np.maximum(states[:, :, -1], 0.0)))
        return bool(plant(problem.study, trees, seeds, self.gates, end, way))


def save(net: PostureNet, file: Path) -> None:
    """Write the weights."""
    file.parent.mkdir(parents=True, exist_ok=True)
    torch.save(net.state_dict(), file)


def load(file: Path) -> PostureNet:
    """Read the weights of `save`."""
    state = torch.load(file, weights_only=True)
    context = state["look.situation.mean"].numel()
    cells = state["look.body.mean"].numel() - context
    net = PostureNet(context, cells, state["mean"].numel())
    net.load_state_dict(state)
    return net.eval()
