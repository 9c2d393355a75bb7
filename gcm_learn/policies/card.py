"""How good a trained policy is, and its card, which says that and what it was made of."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from gcm_learn.execution import CAUGHT, COLLIDED, Pool
from gcm_learn.policies.actor import Actor, file_of
from gcm_learn.policies.plan import Share, TrainingPlan
from gcm_learn.storage import content_hash, write_whole

CARD = "card.md"


def score(actor: Actor, pool: Pool, groups: Sequence[str]) -> dict[str, float]:
    """Shares of catches and touches, over all situations and by group."""
    episodes = actor.play(pool, np.arange(len(pool)))
    caught, touched = episodes.outcomes == CAUGHT, episodes.outcomes == COLLIDED
    out = {"caught": float(caught.mean()), "touched": float(touched.mean())}
    out |= {f"caught {g}": v for g, v in _by_group(groups, caught).items()}
    out |= {f"touched {g}": v for g, v in _by_group(groups, touched).items()}
    return out


def write_card(
    folder: Path,
    plan: TrainingPlan,
    steps: int,
    scores: Mapping[str, float],
    sizes: Mapping[str, int],
) -> Path:
    """Write the card; returns its path."""
    file = file_of(plan.settings)
    digest = content_hash((folder / file).read_bytes())[:16]
    sources = "; ".join(_told(share) for share in plan.situations)
    judged = "; ".join(_told(share) for share in plan.validation)
    lines = [
        f"# {folder.name}",
        "",
        f"- made by: `gcm-learn train policy CONFIG --out {folder.name}`, configuration in "
        "`config.json`",
        f"- algorithm: {plan.algo}, actions: {plan.actions}, seed {plan.seed}",
        f"- steps: {steps} (of {plan.n_timesteps}; the best on the validation situations is kept)",
        f"- trained on: {sources}",
        f"- begun with: {plan.start or 'nothing'}",
        f"- `{file}`: sha256 {digest}...",
        "",
        f"Validation situations ({judged}), most likely actions, 95 % intervals (Wilson):",
        "",
        "| group | situations | caught | touched |",
        "|---|---|---|---|",
    ]
    total = sum(sizes.values())
    for group, n in [("all", total), *sizes.items()]:
        tail = "" if group == "all" else f" {group}"
        caught, touched = scores[f"caught{tail}"], scores[f"touched{tail}"]
        lines.append(f"| {group} | {n} | {_interval(caught, n)} | {_interval(touched, n)} |")
    lines += [
        "",
        "The validation situations chose the checkpoint, so these figures flatter a little. Known",
        "limits: exact observations of bodies, of at most four obstacles; steps of 0.02 s.",
    ]
    path = folder / CARD
    write_whole(path, "\n".join(lines) + "\n")
    return path


def _told(share: Share) -> str:
    text = [f"{share.count} of {share.source}"]
    if Path(share.source).is_dir():
        manifest = json.loads((Path(share.source) / "manifest.json").read_text("utf-8"))
        text.append(f"hash {manifest['hash'][:16]}, split {share.split}")
    if share.strata:
        text.append(f"strata {', '.join(share.strata)}")
    if share.families:
        text.append(f"families {', '.join(share.families)}")
    if share.reachable or share.caught_by:
        text.append(f"only what `{share.caught_by or 'search'}` catches")
    if share.shown_by != "search":
        text.append(f"catches of `{share.shown_by}` are shown")
    return ", ".join(text)


def _interval(share: float, n: int) -> str:
    """Share with Wilson's interval, in per cent."""
    from scipy.stats import binomtest  # takes a second to load

    low, high = binomtest(round(share * n), n).proportion_ci(method="wilson")
    return f"{share:.1%} ({low:.1%} to {high:.1%})"


def _by_group(groups: Sequence[str], values: np.ndarray) -> dict[str, float]:
    """Means of values (n,) by group."""
    names = np.array(groups)
    return {str(g): float(np.mean(values[names == g])) for g in sorted(set(groups))}
