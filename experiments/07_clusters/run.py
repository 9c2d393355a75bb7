"""Does experience fall into clusters, and into which? Writes table.md and pictures.

python -m experiments 07_clusters DATASET [ENCODER]

DATASET is a folder of `gcm-learn generate`, ENCODER one of `gcm-learn train encoder` (the shipped
one by default). The page out/index.html shows the memory as points.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
from pictures import write_figure, write_prototypes
from sklearn.cluster import HDBSCAN
from sklearn.decomposition import PCA
from sklearn.manifold import TSNE
from sklearn.metrics import adjusted_mutual_info_score, adjusted_rand_score

from experiments.clusters import (
    REST,
    TRIED,
    Experience,
    K,
    Tries,
    directions,
    k_means,
    shared,
    shares,
    stability,
    transfers,
    tries,
)
from gcm_learn import dataset, seeding
from gcm_learn.evaluation import Table
from gcm_learn.recall import (
    Encoder,
    LearnedIndex,
    Memory,
    PcaIndex,
    Scale,
    Waypoints,
    load_encoder,
    map_picture,
    passing,
    raw_features,
    ring_share,
    waypoints_of,
)

HERE = Path(__file__).resolve().parent
LEAST, FEW = 40, 8  # members of a cluster of HDBSCAN; principal components that it is asked in
DRAWS = 40  # of a bootstrap
LETTERS = 2  # obstacles passed that a class tells; more are summed up


def experience(records: dataset.Dataset, most: int) -> Experience:
    """The earliest catches of the first training records."""
    kept, traces, families, strata, sides, hand, end = [], [], [], [], [], [], []
    for record in records.where(split="train"):
        plans = [plan for plan in record.plans.values() if plan.caught]
        if plans:
            best = min(plans, key=lambda plan: plan.catch_time or 0.0)
            trace, arm = waypoints_of(record.situation, best), record.situation.arm
            kept.append(record)
            traces.append(trace)
            families.append(record.family.replace("-planar", "-solid").removesuffix("-solid"))
            strata.append(record.stratum)
            sides.append(short(passing(record.situation, best.trajectory).sides))
            share = float(ring_share(arm, arm.hand[0]))
            hand.append((share, share**2, share**3, arm.upper_arm))
            angle, ring = trace.goal
            end.append((share, ring, np.cos(angle), np.sin(angle), angle, trace.catch_time))
        if len(kept) == most:
            break
    labels = {"family": families, "stratum": strata, "sides": sides}
    x = np.array(end)
    products = [x[:, i] * x[:, j] for i in range(x.shape[1]) for j in range(i + 1)]
    return Experience(
        kept,
        np.array([t.knots for t in traces], np.float32),
        np.array([t.goal for t in traces], np.float32),
        {name: np.array(values) for name, values in labels.items()},
        np.array(hand),
        np.column_stack([x, *products, np.array(hand)]),
    )


def short(sides: str) -> str:
    """Letters of the first obstacles passed; a plus for more, a dash for none."""
    return (sides[:LETTERS] + "+" * (len(sides) > LETTERS)) or "–"


def spaces(some: Experience, encoder: Encoder) -> dict[str, np.ndarray]:
    """Return the places of the catches (n, d), by the features they are placed by."""
    situations = [record.situation for record in some.records]
    queries = np.array([encoder.embed_situation(s) for s in situations])
    memories = encoder.embed_memories(situations, some.traces, some.goals)
    raw = np.array([raw_features(s) for s in situations])
    maps = np.array([map_picture(s) for s in situations])
    return {
        "memories": directions(memories),
        "situations": directions(queries),
        "raw": Scale.of(raw)(raw),
        "maps": PCA(PcaIndex.most, random_state=0).fit_transform(maps),
    }


def without(rows: np.ndarray, known: np.ndarray) -> np.ndarray:
    """Return the residuals of rows (n, d) after a linear fit by some numbers (n, m)."""
    inputs = np.column_stack([np.ones(len(rows)), (known - known.mean(0)) / (known.std(0) + 1e-9)])
    weights, *_ = np.linalg.lstsq(inputs, rows, rcond=None)
    return rows - inputs @ weights


def hdbscan(rows: np.ndarray) -> np.ndarray:
    """Clusters (n,), REST for what lies in none; densities are estimated in few dimensions."""
    few = PCA(FEW, random_state=0).fit_transform(rows)
    return np.asarray(HDBSCAN(min_cluster_size=LEAST, min_samples=5, copy=True).fit_predict(few))


def agreement(clusters: np.ndarray, labels: np.ndarray) -> tuple[float, float, float]:
    """Adjusted mutual information and its bootstrap interval."""
    rng, n = seeding.rng(7, len(labels)), len(labels)
    value = adjusted_mutual_info_score(labels, clusters)
    draws = []
    for _ in range(DRAWS):  # halves without replacement: doubles would agree with themselves
        half = rng.permutation(n)[: n // 2]
        draws.append(adjusted_mutual_info_score(labels[half], clusters[half]))
    spread = np.std(draws)  # halves without replacement vary as wholes with it do
    return value, value - 1.96 * spread, value + 1.96 * spread


def stability_of_densities(rows: np.ndarray, repeats: int = 3) -> float:
    """Mean adjusted Rand index of HDBSCAN on samples of 80 %, where both have a point."""
    n, fits = len(rows), []
    for k in range(repeats):
        sample = np.sort(seeding.rng(9, k).permutation(n)[: int(0.8 * n)])
        whole = np.full(n, -9)
        whole[sample] = hdbscan(rows[sample])
        fits.append(whole)
    pairs = [(a, b) for k, a in enumerate(fits) for b in fits[:k]]
    values = []
    for a, b in pairs:
        both = (a != -9) & (b != -9)
        values.append(adjusted_rand_score(a[both], b[both]))
    return float(np.mean(values))


def rows_of(some: Experience, found: Tries, places: dict[str, np.ndarray]) -> tuple[list, dict]:
    """Rows of the table and the clusters by space."""
    rows, clusters = [], {}
    left = {"": None, ", less the hand": some.hand, ", less hand and catch": some.end}
    for name, whole in places.items():
        for words, known in left.items():
            x = whole if known is None else without(whole, known)
            fit = k_means(x, 0)
            groups = fit.labels_.astype(int)
            clusters[name + words] = groups
            cells = {label: agreement(groups, v) for label, v in some.labels.items()}
            rand, mutual = stability(x)
            row = {
                "space": name + words, "by": f"{K}-means", "clusters": K, "rest": 0.0, **cells,
                "rand": rand, "mutual": mutual, "transfer": transfers(found, groups),
            }  # fmt: skip
            rows.append(row)
            print(row, flush=True)
            if known is some.end:
                continue
            dense = hdbscan(x)
            clusters[name + words + " (HDBSCAN)"] = dense
            cells = {label: agreement(dense, v) for label, v in some.labels.items()}
            row = {
                "space": name + words, "by": "HDBSCAN", "clusters": int(dense.max()) + 1,
                "rest": float((dense == REST).mean()), **cells,
                "rand": stability_of_densities(x), "mutual": None,
                "transfer": transfers(found, dense),
            }  # fmt: skip
            rows.append(row)
            print(row, flush=True)
    return rows, clusters


def write_table(file: Path, rows: list, some: Experience, found: Tries, key: str) -> None:
    """The table as text."""
    head = ["space", "by", "clusters (left over)", *(f"AMI {name}" for name in some.labels),
            "stable: Rand", "transfers within", "across", "ratio"]  # fmt: skip
    lines = []
    for row in rows:
        cells = [f"{v:.2f} ({a:.2f}–{b:.2f})" for v, a, b in (row[x] for x in some.labels)]
        some_left = f" ({100 * row['rest']:.0f} %)" if row["by"] == "HDBSCAN" else ""
        which = [row["space"], row["by"], f"{row['clusters']}{some_left}"]
        lines.append([*which, *cells, f"{row['rand']:.2f}", *shares(row["transfer"])])
    counts = {k: dict(zip(*(x.tolist() for x in np.unique(v, return_counts=True)), strict=True))
              for k, v in some.labels.items()}  # fmt: skip
    note = (
        f"{len(some.records)} catches, encoder `{key}`; transfer: {len(found.asked)} situations of "
        f"W and Q, {TRIED} random memories each, bent and verified by the quick verdict. AMI: "
        "adjusted mutual information, 0 is chance; 95 % intervals. Sides: "
        + ", ".join(f"{k} {v}" for k, v in counts["sides"].items())
        + "."
    )
    parts = [str(Table(head, lines)), shared("memories", some, found), note]
    file.write_text("\n\n".join(parts) + "\n", encoding="utf-8")


def main() -> None:
    """Cluster, compare, write."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("dataset")
    parser.add_argument("encoder", nargs="?", default=str(HERE.parents[1] / "models" / "encoder"))
    parser.add_argument("--memories", type=int, default=6000)
    parser.add_argument("--points", type=int, default=1000, help="memories on the page")
    given = parser.parse_args()
    encoder = load_encoder(given.encoder)
    some = experience(dataset.open(given.dataset), given.memories)
    found, places = tries(some), spaces(some, encoder)
    rows, clusters = rows_of(some, found, places)
    write_table(HERE / "table.md", rows, some, found, encoder.key)
    picture = TSNE(init="pca", perplexity=40, random_state=0).fit_transform(places["memories"])
    write_figure(HERE / "figure.png", rows, some.labels, picture, clusters["memories"])
    write_prototypes(HERE / "prototypes.png", places["memories"], clusters["memories"],
                     some.records, some.labels)  # fmt: skip
    write_page(some, encoder, picture, clusters, given.points)


def write_page(
    some: Experience, encoder: Encoder, picture: np.ndarray, clusters: dict, count: int
) -> None:
    """The page with the memory as points."""
    from gcm_learn.plots import write_memory_page

    memory = Memory(LearnedIndex(encoder))
    memory.add([r.situation for r in some.records],
               [Waypoints(t, g) for t, g in zip(some.traces, some.goals, strict=True)],
               [r.family for r in some.records], [r.stratum for r in some.records])  # fmt: skip
    groups = {
        "cluster": [f"cluster {c}" for c in clusters["memories"]],
        "cluster of the situation": [f"cluster {c}" for c in clusters["situations"]],
    }
    write_memory_page(memory, HERE / "out", count=count, places=picture, groups=groups,
                      title="A memory of catches, by t-SNE of its embeddings")  # fmt: skip


if __name__ == "__main__":
    main()
