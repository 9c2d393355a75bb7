"""Behaviour cloning: a network learns which choice the demonstrations make, or how they move."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import torch
from torch import nn

from gcm_learn.execution import ArenaSettings
from gcm_learn.policies.actor import Actor
from gcm_learn.policies.demonstrations import Demonstrations
from gcm_learn.policies.directions import choices_in, choices_of, is_bounded, said
from gcm_learn.seeding import rng

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
