"""The towers while they learn, in torch, and their losses; `encoder` uses them.

Labels say which memories are valid in which situations. The binary loss takes each pair by itself,
which makes the order of all memories right on the whole. The listwise one wants valid memories to
outweigh the others in a softmax over the list. That makes the first places right, which recall
checks. The contrast wants the same of a situation's own memory alone, against invalid ones. Other
valid ones are left out: they are as right.
"""

from __future__ import annotations

from collections.abc import Mapping
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import torch
from torch import Tensor, nn
from torch.nn import functional

from gcm_learn.errors import EncoderError
from gcm_learn.recall.encoder import LAYERS, Encoder, EncoderConfig
from gcm_learn.recall.features import STEPS, FeatureBatch

_NEVER = -1e4
IMITATED, TOGETHER = 400, 256  # steps in which maps learn the places of paths, memories of each


class TowerNet(nn.Module):
    """A perceptron with inputs on a common scale, see `encoder.Tower`."""

    def __init__(self, inputs: int, width: int, dim: int) -> None:
        super().__init__()
        sizes = [inputs] + [width] * (LAYERS - 1) + [dim]
        self.register_buffer("mean", torch.zeros(inputs))
        self.register_buffer("spread", torch.ones(inputs))
        self.layers = nn.ModuleList(nn.Linear(a, b) for a, b in pairwise(sizes))

    def fit_scale(self, sample: np.ndarray) -> None:
        """Take the scale of the inputs from a sample (n, inputs) of them.

        Inputs that hardly vary are not blown up. Numbers are rounded to what is stored of them.
        """
        for buffer, value in (
            (self.mean, sample.mean(axis=0)),
            (self.spread, np.maximum(sample.std(axis=0), 0.1)),
        ):
            buffer.copy_(torch.from_numpy(value.astype(np.float16).astype(np.float32)))

    def forward(self, inputs: Tensor) -> Tensor:
        """Outputs (n, dim) of inputs (n, inputs)."""
        values = (inputs - self.mean) / self.spread
        for layer in self.layers[:-1]:
            values = torch.relu(layer(values))
        return self.layers[-1](values)


class Inputs(NamedTuple):
    """Numbers of input features; for chains they depend on the joints. Maps are optional."""

    context: int
    cells: int
    path: int
    map: int = 0


class EncoderNet(nn.Module):
    """All towers, and a bias for the odds that a memory is valid in a situation."""

    def __init__(self, config: EncoderConfig, inputs: Inputs) -> None:
        super().__init__()
        self.situation = TowerNet(inputs.context, config.width, config.dim)
        self.body = TowerNet(inputs.context + inputs.cells, config.width, config.dim)
        if config.uses_traces:
            self.trace = TowerNet(inputs.path, config.width, config.dim)
        if config.uses_maps:
            self.map = TowerNet(inputs.map, config.width, config.dim)
        self.hope = nn.Linear(config.dim, 1)  # the bias, by its name in checkpoints
        self.config = config

    def take_over(self, encoder: Encoder) -> None:
        """Start from the weights of an encoder of the same size, for the towers that both have."""
        own = self.state_dict()
        known = {name: encoder.arrays[name] for name in own if name in encoder.arrays}
        arrays = {name: torch.from_numpy(a).float() for name, a in known.items()}
        try:
            self.load_state_dict(own | arrays)
        except RuntimeError:
            raise EncoderError(
                f"start: encoder {encoder.key} has {encoder.dim} numbers, {encoder.config.width} "
                f"units and knows {_known(arrays)} numbers of a situation; expected "
                f"{self.config.dim}, {self.config.width} and {_known(own)}"
            ) from None

    def queries(self, features: FeatureBatch) -> Tensor:
        """Return the embeddings (n, dim) of situations from their features."""
        context, whose = torch.from_numpy(features.context), torch.from_numpy(features.whose)
        out = self.situation(context)
        if len(whose):
            cells = torch.from_numpy(features.cells).to(torch.float32) / STEPS
            out = out.index_add(0, whose, self.body(torch.cat([context[whose], cells], dim=1)))
        return out

    def memories(self, path: Tensor | None, map_: Tensor | None) -> Tensor:
        """Embeddings (m, dim) of memories by their paths and maps."""
        parts = []
        if self.config.uses_traces:
            parts.append(self.trace(path))
        if self.config.uses_maps:
            parts.append(self.map(map_))
        return sum(parts[1:], start=parts[0])

    def arrays(self) -> dict[str, np.ndarray]:
        """Return weights by name in half precision, without the layer that only learning needs."""
        state = self.state_dict()
        wanted = {name: value for name, value in state.items() if not name.startswith("hope.")}
        return {name: value.numpy().astype(np.float16) for name, value in wanted.items()}


def _known(weights: Mapping[str, Tensor]) -> int:
    """Numbers of a situation and an obstacle that weights take."""
    return int(weights["body.mean"].numel())


def binary(scores: Tensor, bias: Tensor, valid: Tensor) -> Tensor:
    """Mean cross-entropy of single pairs.

    Parameters
    ----------
    scores, valid : (n, m) tensor
        Inner products, and whether the memory is valid.
    bias : (n, 1) tensor
        Added to the logits of a situation: how easy it is does not change the order.
    """
    return functional.binary_cross_entropy_with_logits(scores + bias, valid.to(scores.dtype))


def listwise(scores: Tensor, valid: Tensor) -> Tensor:
    """Mean of -log of the softmax's weight on memories that are valid, over situations with any."""
    some = valid.any(dim=1)
    if not bool(some.any()):
        return scores.sum() * 0.0
    scores, valid = scores[some], valid[some]
    good = torch.logsumexp(scores.masked_fill(~valid, _NEVER), dim=1)
    return (torch.logsumexp(scores, dim=1) - good).mean()


def contrast(scores: Tensor, valid: Tensor, own: Tensor) -> Tensor:
    """Return the mean contrastive loss of own memories against invalid memories.

    Parameters
    ----------
    own : (n,) tensor of int64
        Column of a situation's own memory, -1 for those without.
    """
    some = own >= 0
    if not bool(some.any()):
        return scores.sum() * 0.0
    scores, valid, own = scores[some], valid[some], own[some, None]
    mine = scores.gather(1, own)
    others = torch.logsumexp(scores.masked_fill(valid, _NEVER), dim=1, keepdim=True)
    return (torch.logaddexp(mine, others) - mine).mean()


def imitate(
    tower: TowerNet,
    inputs: np.ndarray,
    wanted: np.ndarray,
    config: EncoderConfig,
    rng: np.random.Generator,
) -> None:
    """Let a tower learn the embeddings (n, dim) that are wanted of inputs (n, m)."""
    given, places = torch.from_numpy(inputs), torch.from_numpy(wanted)
    optimiser = torch.optim.AdamW(tower.parameters(), config.rate, weight_decay=config.decay)
    schedule = torch.optim.lr_scheduler.CosineAnnealingLR(optimiser, IMITATED)
    for _ in range(IMITATED):
        rows = torch.from_numpy(rng.integers(len(wanted), size=TOGETHER))
        loss = functional.mse_loss(tower(given[rows]), places[rows])
        optimiser.zero_grad(set_to_none=True)
        loss.backward()
        optimiser.step()
        schedule.step()
