"""The figure and the prototypes."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

from gcm_learn.dataset import Record
from gcm_learn.plots import draw_targets, draw_waits, plot_map, style

PALETTE = plt.get_cmap("tab20").colors
SPACES = {"memories": "#0b6e4f", "situations": "#2b6cb0", "raw": "#c1666b", "maps": "#d4a017"}
COLUMNS = 4


def write_figure(
    file: Path,
    rows: Sequence[Mapping],
    labels: Mapping[str, np.ndarray],
    picture: np.ndarray,
    clusters: np.ndarray,
) -> None:
    """Above the memory by t-SNE in several colours, below agreement and transfer."""
    figure = plt.figure(figsize=(13.0, 8.6), layout="constrained")
    above, below = figure.subfigures(2, 1, height_ratios=(1.25, 1.0))
    panels = above.subplots(1, 4)
    coloured = {"cluster (16-means)": clusters, **{f"by {k}": v for k, v in labels.items()}}
    for ax, (name, values) in zip(panels, coloured.items(), strict=True):
        common = [word for word, _ in Counter(values.tolist()).most_common()]
        for k, word in enumerate(common):
            mine = picture[values == word]
            told = word if name.startswith("by") else None
            ax.scatter(*mine.T, s=1.5, color=PALETTE[k % 20], lw=0, label=told)
        ax.set(title=name, xticks=[], yticks=[])
        if name.startswith("by"):
            ax.legend(markerscale=6, fontsize=7, ncol=3, frameon=False, loc="upper center",
                      bbox_to_anchor=(0.5, 0.0), handletextpad=0.0, columnspacing=0.5)  # fmt: skip
    left, right = below.subplots(1, 2, width_ratios=(1.5, 1.0))
    _draw_agreement(left, rows, list(labels))
    _draw_transfer(right, rows)
    figure.savefig(file, dpi=120)
    plt.close(figure)


def _draw_agreement(ax: plt.Axes, rows: Sequence[Mapping], labels: list[str]) -> None:
    shown = [row for row in rows if row["by"] != "HDBSCAN" and not row["space"].endswith("catch")]
    width = 0.8 / len(shown)
    for k, row in enumerate(shown):
        name = row["space"].split(",")[0]
        values = np.array([row[label] for label in labels])
        at = np.arange(len(labels)) + (k - 0.5 * (len(shown) - 1)) * width
        pale = "," in row["space"]
        ax.bar(at, values[:, 0], 0.9 * width, color=SPACES[name], alpha=0.45 if pale else 1.0,
               yerr=values[:, 2] - values[:, 0], error_kw={"lw": 0.8},
               label=row["space"])  # fmt: skip
    ax.set_xticks(range(len(labels)), labels)
    ax.set(title="agreement of 16-means with labels", ylabel="adjusted mutual information")
    ax.legend(fontsize=7, ncol=2)
    ax.spines[["top", "right"]].set_visible(False)


def _draw_transfer(ax: plt.Axes, rows: Sequence[Mapping]) -> None:
    shown = [row for row in rows if row["by"] != "HDBSCAN"]
    for k, row in enumerate(reversed(shown)):
        name = row["space"].split(",")[0]
        _, _, ratio, low, high = row["transfer"]
        ax.plot([low, high], [k, k], color=SPACES[name])
        ax.plot(ratio, k, "o", color=SPACES[name])
    ax.axvline(1.0, color="k", lw=0.8, ls=":")
    ax.set_yticks(range(len(shown)), [row["space"] for row in reversed(shown)], fontsize=8)
    ax.set(title="transfer within clusters over across", xlabel="ratio (1: clusters mean nothing)")
    ax.spines[["top", "right"]].set_visible(False)


def medoids(places: np.ndarray, clusters: np.ndarray) -> list[int]:
    """Of each cluster, largest first, the member that is nearest to all others."""
    out = []
    for name, _ in Counter(clusters.tolist()).most_common():
        mine = np.flatnonzero(clusters == name)
        rows = places[mine]
        apart = ((rows[:, None, :] - rows[None, :400, :]) ** 2).sum(-1) ** 0.5
        out.append(int(mine[apart.sum(axis=1).argmin()]))
    return out


def write_prototypes(
    file: Path,
    places: np.ndarray,
    clusters: np.ndarray,
    records: Sequence[Record],
    labels: Mapping[str, np.ndarray],
) -> None:
    """The medoids of the clusters as maps, with their catches."""
    chosen = medoids(places, clusters)
    lines = -(-len(chosen) // COLUMNS)
    figure = style.new_figure(3.1 * COLUMNS, 3.5 * lines)
    panels = figure.subplots(lines, COLUMNS, squeeze=False).ravel()
    for ax in panels:
        ax.axis("off")
    for ax, k in zip(panels, chosen, strict=False):
        ax.axis("on")
        record, mine = records[k], clusters == clusters[k]
        plans = [p for p in record.plans.values() if p.caught]
        plan = min(plans, key=lambda p: p.catch_time or 0.0)
        plot_map(record.map, ax, plan.trajectory.hand)
        draw_targets(ax, record.situation, plan.catch_time)
        draw_waits(ax, plan.trajectory, labels=False)
        told = [Counter(labels[name][mine].tolist()).most_common(1)[0] for name in labels]
        shares = [f"{word} {100 * n / mine.sum():.0f} %" for word, n in told]
        text = f"{shares[0]}, {shares[1]}, sides {shares[2]}"
        style.title(ax, f"{mine.sum()} catches\n{text}")
        ax.title.set_fontsize(8.5)
    figure.savefig(file, dpi=90)
