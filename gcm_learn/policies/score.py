"""How good an actor is on fixed situations."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from gcm_learn.execution import CAUGHT, COLLIDED, Pool
from gcm_learn.policies.actor import Actor
from gcm_learn.policies.situations import by_group


def score(actor: Actor, pool: Pool, groups: Sequence[str]) -> dict[str, float]:
    """Shares of catches and touches, over all situations and by group."""
    episodes = actor.play(pool, np.arange(len(pool)))
    caught, touched = episodes.outcomes == CAUGHT, episodes.outcomes == COLLIDED
    out = {"caught": float(caught.mean()), "touched": float(touched.mean())}
    out |= {f"caught {g}": v for g, v in by_group(groups, caught).items()}
    out |= {f"touched {g}": v for g, v in by_group(groups, touched).items()}
    return out
