"""The towers while they learn, in torch, and what they are asked for; `encoder` uses them.

Labels say which memories are valid in which situations. The binary loss asks each pair for its own
odds, which makes the order of all memories right on the whole; the listwise one asks that valid
ones outweigh the others in a softmax over the list, which makes the first places right, where
recall looks; the contrast asks the same of a situation's own memory alone, against those that are
not valid (others that are valid are left out: they are no less right).
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import torch
from torch import Tensor, nn
from torch.nn import functional

from gcm_learn.errors import EncoderError
from gcm_learn.recall.clearance_features import CELLS, CONTEXT, STEPS, Looks
from gcm_learn.recall.encoder import LAYERS, Encoder, EncoderConfig
from gcm_learn.recall.memory_features import COUNT


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


class EncoderNet(nn.Module):
    """All towers, and how sure a situation lets one be that anything holds in it."""

    def __init__(self, config: EncoderConfig, way_count: int) -> None:
        super().__init__()
        self.situation = TowerNet(CONTEXT, config.width, config.dim)
        self.body = TowerNet(CONTEXT + CELLS, config.width, config.dim)
        if config.uses_traces:
            self.trace = TowerNet(way_count, config.width, config.dim)
        if config.uses_maps:
            self.map = TowerNet(COUNT, config.width, config.dim)
        self.hope = nn.Linear(config.dim, 1)
        self.config = config

    def take_over(self, encoder: Encoder) -> None:
        """Start from the weights of an encoder of the same size."""
        arrays = {name: torch.from_numpy(a).float() for name, a in encoder.arrays.items()}
        try:
            self.load_state_dict(self.state_dict() | arrays)
        except RuntimeError:
            raise EncoderError(
                f"start: encoder {encoder.key} has {encoder.dim} numbers, {encoder.config.width} "
                f"units and embeds by {encoder.config.memory}; expected {self.config.dim}, "
                f"{self.config.width} and {self.config.memory}"
            ) from None

    def queries(self, looks: Looks) -> Tensor:
        """Embeddings (n, dim) of situations by what they look like."""
        context, whose = torch.from_numpy(looks.context), torch.from_numpy(looks.whose)
        out = self.situation(context)
        if len(whose):
            cells = torch.from_numpy(looks.cells).to(torch.float32) / STEPS
            out = out.index_add(0, whose, self.body(torch.cat([context[whose], cells], dim=1)))
        return out

    def memories(self, way: Tensor | None, picture: Tensor | None) -> Tensor:
        """Embeddings (m, dim) of memories by their ways and pictures."""
        parts = []
        if self.config.uses_traces:
            parts.append(self.trace(way))
        if self.config.uses_maps:
            parts.append(self.map(picture))
        return sum(parts[1:], start=parts[0])

    def arrays(self) -> dict[str, np.ndarray]:
        """Weights by name as half-precision numbers, without what only learning needs."""
        state = self.state_dict()
        wanted = {name: value for name, value in state.items() if not name.startswith("hope.")}
        return {name: value.numpy().astype(np.float16) for name, value in wanted.items()}


_NEVER = -1e4


def binary(scores: Tensor, hope: Tensor, holds: Tensor) -> Tensor:
    """Mean cross-entropy of single pairs.

    Parameters
    ----------
    scores, holds : (n, m) tensor
        Inner products, and whether the memory holds.
    hope : (n, 1) tensor
        Added to the logits of a situation: how easy it is does not change the order.
    """
    return functional.binary_cross_entropy_with_logits(scores + hope, holds.to(scores.dtype))


def listwise(scores: Tensor, holds: Tensor) -> Tensor:
    """Mean of -log of the softmax's weight on memories that hold, over situations with any."""
    some = holds.any(dim=1)
    if not bool(some.any()):
        return scores.sum() * 0.0
    scores, holds = scores[some], holds[some]
    good = torch.logsumexp(scores.masked_fill(~holds, _NEVER), dim=1)
    return (torch.logsumexp(scores, dim=1) - good).mean()


def contrast(scores: Tensor, holds: Tensor, own: Tensor) -> Tensor:
    """The same for own memories only.

    Parameters
    ----------
    own : (n,) tensor of int64
        Column of a situation's own memory, -1 for those without.
    """
    some = own >= 0
    if not bool(some.any()):
        return scores.sum() * 0.0
    scores, holds, own = scores[some], holds[some], own[some, None]
    mine = scores.gather(1, own)
    others = torch.logsumexp(scores.masked_fill(holds, _NEVER), dim=1, keepdim=True)
    return (torch.logaddexp(mine, others) - mine).mean()
