"""What an encoder is asked for.

Labels say which memories hold in which situations. The binary loss asks each pair for its own odds,
which makes the order of all memories right on the whole; the listwise one asks that those that
hold outweigh the others in a softmax over the list, which makes the first places right, where
recall looks; the contrast asks the same of a situation's own memory alone, against those that do
not hold (others that do are left out: they are no less right).
"""

from __future__ import annotations

import torch
from torch import Tensor
from torch.nn import functional

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
