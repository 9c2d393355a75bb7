"""Behaviour cloning: demonstrations by planners, and a network that learns to do as they do."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import torch
from torch import nn

from gcm_learn.execution import (
    CAUGHT,
    ArenaSettings,
    Episodes,
    Pool,
    Steps,
    follower_of,
    plant_of,
    run_episode,
)
from gcm_learn.policies.actor import Actor
from gcm_learn.policies.directions import choices_in, choices_of, is_bounded, said
from gcm_learn.seeding import rng


@dataclass(frozen=True)
class Demonstrations:
    """Observations, and the actions of demonstrators."""

    observations: np.ndarray
    """(m, width) float32."""
    actions: np.ndarray
    """(m, 2) float32: velocities in the frame of the moment, in hand speeds; in space (m, 4): rates
    of the joints, in their greatest."""
    caught: np.ndarray
    """Which of the plans still catch when they are acted out in steps (n,)."""

    @classmethod
    def joined(cls, parts: Iterable[Demonstrations]) -> Demonstrations:
        """Join demonstrations, one after the other."""
        columns = zip(*((p.observations, p.actions, p.caught) for p in parts), strict=True)
        return cls(*map(np.concatenate, columns))


def act_out(pool: Pool, plans: Sequence[Any], settings: ArenaSettings) -> Demonstrations:
    """Follow plans step by step.

    Parameters
    ----------
    pool : Pool
    plans : sequence of Movement
        One for each situation of the pool, in its coordinates.
    settings : ArenaSettings

    Returns
    -------
    Demonstrations
        Only of episodes that end with a catch: what corners cut by steps spoil is left out.
    """
    episodes, steps = _followed(pool, plans, settings)
    caught = episodes.outcomes == CAUGHT
    good = caught[steps.arms]
    return Demonstrations(steps.told[good], steps.actions[good], caught)


def transitions(pool: Pool, plans: Sequence[Any], settings: ArenaSettings) -> Steps:
    """Return all steps of arms that follow plans, for learners with a replay buffer.

    Episodes that fail because steps cut corners are included, with their rewards.
    """
    return _followed(pool, plans, settings)[1]


def _followed(pool: Pool, plans: Sequence[Any], settings: ArenaSettings) -> tuple[Episodes, Steps]:
    """Let arms follow plans; return the episodes, and all steps joined."""
    plant, steps = plant_of(pool, len(pool), settings), list[Steps]()
    agent = follower_of(plans, pool, settings.dt)
    episodes = run_episode(agent, plant, np.arange(len(pool)), steps.append)
    return episodes, Steps(*map(np.concatenate, zip(*steps, strict=True)))


LEAST_DEVIATION = 1e-3  # numbers that hardly vary are not blown up
SPREAD = -1.5  # logarithm of the deviation of a cloned velocity that is drawn, before the tanh
Report = Callable[[dict[str, float]], Any]


@dataclass(frozen=True)
class Cloning:
    """How a clone is trained."""

    layers: tuple[int, ...] = (256, 256)
    epochs: int = 10
    batch: int = 2048
    rate: float = 1e-3
    """Of learning at the start; it falls to 0 as a cosine does."""
    decay: float = 1e-5
    """Of weights."""
    held_out: float = 0.02
    """Share of the demonstrations that only measure."""


def clone(
    demonstrations: Demonstrations,
    settings: ArenaSettings,
    how: Cloning,
    seed: int,
    report: Report | None = None,
    *,
    choices: bool = True,
) -> Actor:
    """Train a clone.

    Parameters
    ----------
    choices : bool
        Whether its actions are choices of a direction (by cross-entropy), or velocities (by
        squares), of which it learns the mean: where ways fork it is worse, but who acts by
        velocities can begin with it. In space it learns differences from the straight way.
    report : callable, optional
        Called after every epoch with its losses and, of choices, the accuracy.
    """
    told = demonstrations.observations
    shown = demonstrations.actions
    done = (choices_of if choices else said)(settings, told, shown)
    mean, deviation = told.mean(axis=0), np.maximum(told.std(axis=0), LEAST_DEVIATION)
    source = rng(seed)
    order = source.permutation(len(told))
    held = order[: max(int(how.held_out * len(told)), 1)]
    rest = order[len(held) :]
    torch.manual_seed(seed)
    bounded = is_bounded(settings)
    network = perceptron(
        told.shape[1], how.layers, choices_in(settings) if choices else done.shape[1]
    )
    optimiser = torch.optim.AdamW(network.parameters(), how.rate, weight_decay=how.decay)
    steps = how.epochs * -(-len(rest) // how.batch)
    schedule = torch.optim.lr_scheduler.CosineAnnealingLR(optimiser, steps)

    def batch_of(rows: np.ndarray) -> tuple[torch.Tensor, torch.Tensor]:
        scaled = np.clip((told[rows] - mean) / deviation, -10.0, 10.0).astype(np.float32)
        return torch.from_numpy(scaled), torch.from_numpy(done[rows])

    def loss_of(scores: torch.Tensor, wanted: torch.Tensor) -> torch.Tensor:
        if choices:
            return nn.functional.cross_entropy(scores, wanted)
        return nn.functional.mse_loss(torch.tanh(scores) if bounded else scores, wanted)

    for epoch in range(how.epochs):
        source.shuffle(rest)
        total = 0.0
        for at in range(0, len(rest), how.batch):
            inputs, wanted = batch_of(rest[at : at + how.batch])
            loss = loss_of(network(inputs), wanted)
            optimiser.zero_grad()
            loss.backward()
            optimiser.step()
            schedule.step()
            total += float(loss.detach()) * len(inputs)
        if report is not None:
            with torch.no_grad():
                inputs, wanted = batch_of(held)
                scores = network(inputs)
                row = {"epoch": epoch + 1, "loss": total / len(rest)}
                row["held_out_loss"] = float(loss_of(scores, wanted))
                if choices:
                    row["accuracy"] = float((scores.argmax(dim=1) == wanted).float().mean())
            report(row)
    return Actor(
        layers=layers_of(network), mean=mean, deviation=deviation,
        head="choice" if choices else "velocity", activation="relu",
        squash=bounded and not choices, spread=np.full(done.shape[-1], SPREAD), settings=settings,
    )  # fmt: skip


def perceptron(width: int, layers: tuple[int, ...], outputs: int) -> nn.Sequential:
    """A multilayer perceptron with rectifiers."""
    parts: list[nn.Module] = []
    for size in layers:
        parts += [nn.Linear(width, size), nn.ReLU()]
        width = size
    return nn.Sequential(*parts, nn.Linear(width, outputs))


def layers_of(network: nn.Module) -> tuple[tuple[np.ndarray, np.ndarray], ...]:
    """Weights and biases of the linear layers, in order."""
    linear = [m for m in network.modules() if isinstance(m, nn.Linear)]
    return tuple((_array(m.weight), _array(m.bias)) for m in linear)


def _array(tensor: torch.Tensor) -> np.ndarray:
    return tensor.detach().cpu().numpy().astype(np.float32)
