"""Texts about clusters for a page: common traits, and success in each other's situations."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from typing import Any

import numpy as np

from gcm_learn.plots.figures.sheet import STRATA
from gcm_learn.recall import Clusters, CrossTries, Memory

NAMES = {"map": "maps", "trace": "movements", "raw": "raw parameters"}
APART = 0.5  # mean silhouette from which clusters count as apart (Kaufman and Rousseeuw, 1990)
TURN, REACH, DETOUR = 0.35, 0.15, 1.15  # [rad], share of the ring, straight ways
HUB = 0.1  # added to shares of the ring for lengths
EXCESS = 0.15  # by which a shared trait is more frequent than among all


def about_clusters(
    found: Clusters, moves: Clusters, tries: CrossTries, shown: np.ndarray
) -> dict[str, Any]:
    """Return the texts and numbers of a page about clusters.

    Its points are the catches `shown` (m,), medoids among them; `moves` are clusters of movements.
    """
    memory, name = found.memory, NAMES[found.by]
    labels = {
        f"cluster of {name}": found.labels, "cluster of movements": moves.labels,
        "family": np.array(memory.families), "stratum": np.array(memory.strata),
        "nothing": np.zeros(len(memory)),
    }  # fmt: skip
    shares = {what: tries.shares(own) for what, own in labels.items()}
    own, moved = (shares[f"cluster of {which}"][0] for which in (name, NAMES["trace"]))
    apart = "they stand apart" if found.silhouette > APART else "they are cuts through a continuum"
    kind = (
        f"K-means, mean silhouette {found.silhouette:.2f} (0: no clusters, 1: far apart), so "
        f"{apart}. {len(shown)} catches are shown, alike ones close together."
    )
    return {
        "title": f"{len(memory):,} catches in {len(found.medoids)} clusters of their {name}",
        "lead": [kind, verdict(name, own, moved, shares["nothing"][0])],
        "cards": [_card(found, tries, shown, k) for k in range(len(found.medoids))],
        "rows": [(what, _percent(share)) for what, share in shares.items()],
        "asked": len(tries.asked),
    }


def verdict(name: str, own: float, moves: float, chance: float) -> str:
    """Return whether clusters tell where a catch can be used, beside clusters of movements."""
    text = (
        f"A catch, adapted, catches in {own:.0%} of the situations of its cluster, and in "
        f"{chance:.0%} of all."
    )
    if name == NAMES["trace"] or not moves > chance:
        return text
    part = (own - chance) / (moves - chance)
    judged = "cluster by movement, too" if part >= 0.5 else "do not cluster by movement"
    return (
        f"{text} Clusters of the movements themselves reach {moves:.0%}. So {name} {judged}: "
        f"they give {part:.0%} of that gain."
    )


def _percent(shares: np.ndarray) -> str:
    """Return a share and its 95 % interval as text; a dash if the share is unknown."""
    if not np.isfinite(shares[0]):
        return "–"
    low, high = np.nanpercentile(100 * shares[1:], [2.5, 97.5])
    return f"{shares[0]:.0%} ({low:.0f}–{high:.0f})"


def _card(found: Clusters, tries: CrossTries, shown: np.ndarray, k: int) -> dict[str, Any]:
    """Return the page's entry of cluster k + 1: name, size, point of the medoid, and texts."""
    memory, mine = found.memory, found.labels == k + 1
    own, chance = (
        _percent(tries.shares(labels, mine[tries.asked]))
        for labels in (found.labels, np.zeros(len(mine)))
    )
    shares = [(name, has[mine].mean(), has.mean()) for name, has in traits(memory).items()]
    kept = [row for row in shares if row[1] >= max(0.5, row[2] + EXCESS)]
    kept.sort(key=lambda row: row[2] - row[1])
    shared = ", ".join(f"{name} ({a:.0%}, of all {b:.0%})" for name, a, b in kept[:3])
    strata = (STRATA.get(s, "").partition(": ")[2] for s in np.array(memory.strata)[mine])
    lines = {
        "They share": shared or "no trait that others lack",
        "Families": _most(np.array(memory.families)[mine]),
        "Strata": _most(strata),
        "Catch in each other's situations": f"{own}; all catches: {chance}",
    }
    point = int(np.searchsorted(shown, found.medoids[k]))
    return {"name": f"Cluster {k + 1}", "size": mine.sum(), "point": point, "lines": lines}


def _most(words: Iterable[str]) -> str:
    """Return the most frequent words with their shares."""
    counts = Counter(map(str, words))
    common = counts.most_common(3)
    return ", ".join(f"{word or 'unknown'} {n / counts.total():.0%}" for word, n in common)


def traits(memory: Memory) -> dict[str, np.ndarray]:
    """Return, by the name of a trait, which catches (n,) of a planar memory have the trait."""
    angle, ring, time, earliest = np.moveaxis(memory.knots.astype(float), 2, 0)
    hand = (HUB + ring)[..., None] * np.stack([np.cos(angle), np.sin(angle)], axis=2)
    way = np.linalg.norm(np.diff(hand, axis=1), axis=2).sum(axis=1)
    straight = way < DETOUR * np.linalg.norm(hand[:, -1] - hand[:, 0], axis=1)
    turn, out, end = angle[:, -1] - angle[:, 0], ring[:, -1] - ring[:, 0], time[:, -1]
    early, late = np.quantile(end, [1 / 3, 2 / 3])
    return {
        "waits": (earliest > 0.0).any(axis=1), "straight": straight, "makes a detour": ~straight,
        "to the left": turn > TURN, "to the right": turn < -TURN,
        "outwards": out > REACH, "inwards": out < -REACH,
        "early": end < early, "late": end > late,
    }  # fmt: skip
