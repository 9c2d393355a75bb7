"""Page of a memory as points; pointing at a point shows its map and its catch.

All is in one file, so that it opens from anywhere: maps are small images within it, movements are
told by a few instants and drawn by the page itself.
"""

from __future__ import annotations

import base64
import io
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.colors import to_rgba
from PIL import Image

from gcm_learn import seeding
from gcm_learn.maps import CognitiveMap, build_map
from gcm_learn.plots.figures import style
from gcm_learn.plots.figures.maps import walls
from gcm_learn.plots.figures.sheet import STRATA
from gcm_learn.plots.reports.clusters import about_clusters
from gcm_learn.plots.reports.page import fill
from gcm_learn.recall import Clusters, Memory, cluster, cross_tries, passing_of, path_of
from gcm_learn.scene import entry_of, outline, pack_bodies, poses_at
from gcm_learn.situation import PLANAR, Situation
from gcm_learn.wave import MarchingParams

SHOWN = 600  # memories on a page
N = 48  # cells along a side of the maps
FRAMES = 13  # instants of a movement that are told
CORNERS = 16  # of an outline at most
UNIT = 1000  # of coordinates, per forearm length
SHADES = 200  # of arrivals in an image; two more colours are the effective cells

KEY = tuple(
    entry for entry in style.KEY if entry[1] not in ("extended obstacle", "explored by the wave")
)
COLOURS = {
    "arm": style.ARM, "obstacle": style.OBSTACLE, "target": style.TARGET, "path": style.PATH,
    "faint": style.FAINT,
}  # fmt: skip

SIDES = {"l": "left", "r": "right"}

Values = dict[str, Any]


def write_memory_page(
    memory: Memory, out: Path, *, count: int = SHOWN, found: Clusters | None = None,
    seed: int = 0, back: str = "", progress: Callable[[int], None] = lambda done: None,
) -> Path:  # fmt: skip
    """Write a page on which memories are points.

    Parameters
    ----------
    memory : Memory
    out : Path
        Folder; made when it is missing.
    count : int
        Memories that are shown, drawn by lot.
    found : Clusters, optional
        Of these memories; then it is a page about clusters.
    seed : int
    back : str
        Address of the page that links to this one.
    progress : callable
        Called with the number of points, and of situations for clusters, done since the last call.

    Returns
    -------
    Path
        The page, ``index.html``.
    """
    out.mkdir(parents=True, exist_ok=True)
    shown = np.sort(seeding.rng(seed).permutation(len(memory))[:count])
    if found is None:
        places = principal_places(memory.embeddings)[shown]
        lead = (
            f"{len(memory)} catches are remembered here, filed by the index “{memory.index.name}”; "
            f"{len(shown)} of them are shown. Neighbours are catches that it takes for alike."
        )
        told: Values = {"title": "A memory of catches", "lead": [lead], "cards": []}
    else:
        shown = np.union1d(shown, found.medoids)
        places = _flat(found.places[shown], seed)
        own = found.by == "trace"
        moves = found if own else cluster(memory, "trace", count=len(found.medoids), seed=seed)
        told = about_clusters(found, moves, cross_tries(memory, seed, progress), shown)
    points = []
    for k, spot in zip(shown.tolist(), _unit_square(places).tolist(), strict=True):
        point = _point(memory, k) | {"at": spot}
        if found is not None:
            point["words"] = {"cluster": f"cluster {found.labels[k]}"} | point["words"]
        points.append(point)
        progress(1)
    told |= {"data": {"points": points, "colours": COLOURS}, "key": KEY, "back": back}
    page = out / "index.html"
    page.write_text(fill("memory.html", told), "utf-8")
    return page


def _flat(places: np.ndarray, seed: int) -> np.ndarray:
    """Places (m, d) in a picture (m, 2), in which neighbours stay neighbours."""
    from sklearn.manifold import TSNE

    wide = min(30.0, (len(places) - 1) / 3.0)
    return np.asarray(TSNE(perplexity=wide, random_state=seed).fit_transform(places), float)


def principal_places(embeddings: np.ndarray) -> np.ndarray:
    """First two principal components (n, 2) of the embeddings' directions (n, d)."""
    lengths = np.linalg.norm(embeddings, axis=1, keepdims=True)
    rows = embeddings / np.maximum(lengths, 1e-12)
    rows = rows - rows.mean(axis=0)
    _, axes = np.linalg.eigh(rows.T @ rows)
    return np.asarray(rows @ axes[:, :-3:-1])


def _unit_square(places: np.ndarray) -> np.ndarray:
    """Places (n, 2) from 0 to UNIT, whole numbers; outliers stay at the rim."""
    low, high = np.percentile(places, [0.5, 99.5], axis=0)
    share = (places - low) / np.maximum(high - low, 1e-12)
    return np.rint(UNIT * np.clip(share, 0.0, 1.0)).astype(int)


def _point(memory: Memory, k: int) -> Values:
    """Return the texts and numbers of memory k."""
    entry = memory[k]
    situation, waypoints = entry.situation, entry.waypoints
    sides = [SIDES[letter] for letter in passing_of(situation, waypoints).sides]
    words = {
        "stratum": STRATA.get(entry.stratum or "", "unknown"),
        "family": entry.family or "unknown",
        "sides of the hand on which obstacles are passed": ", ".join(sides) or "none",
    }
    return {"words": words, "map": _picture(situation)} | _movement(
        situation, *path_of(waypoints, situation.arm)
    )


def _movement(situation: Situation, time: np.ndarray, hand: np.ndarray) -> Values:
    """Return arm, trajectory and bodies until its end; lengths in 1/UNIT, times in ms."""
    end = float(time[-1])
    keep = np.unique(np.linspace(0, len(time) - 1, 48).round().astype(int))
    return {
        "arm": round(UNIT * situation.arm.upper_arm),
        "end": round(1e3 * end),
        "time": np.rint(1e3 * time[keep]).astype(int).tolist(),
        "hand": _whole(hand[keep]),
        "bodies": _bodies(situation, np.linspace(0.0, end, FRAMES)),
    }


def _bodies(situation: Situation, times: np.ndarray) -> list[Values]:
    """Return bodies at times [s]: planar bodies as shape and poses, solids as outlines of cuts."""
    packed, frames = pack_bodies(situation), []
    for t in times:
        poses = np.zeros((len(situation.bodies), 12))
        poses[:, [3, 7, 11]] = 1.0
        poses_at(packed, float(t), poses)
        frames.append(poses)
    all_poses, out = np.array(frames), []
    for b, body in enumerate(situation.bodies):
        told: Values = {"target": body.role == "target"}
        if isinstance(body.shape, PLANAR):
            turn = np.unwrap(np.arctan2(all_poses[:, b, 6], all_poses[:, b, 3]))
            told["at"] = _whole(all_poses[:, b, :2])
            if entry_of(body.shape).is_ball:
                told["radius"] = round(UNIT * body.shape.bounding_radius)
            else:
                told["shape"] = _whole(np.asarray(entry_of(body.shape).vertices(body.shape)))
                told["turn"] = np.rint(UNIT * turn).astype(int).tolist()
        else:
            cuts = [outline(situation, b, float(t)) for t in times]
            told["cuts"] = [[] if cut is None else _whole(_fewer(cut)) for cut in cuts]
        out.append(told)
    return out


def _fewer(corners: np.ndarray) -> np.ndarray:
    return corners[:: -(-len(corners) // CORNERS)]


def _whole(points: np.ndarray) -> list[int]:
    """Return points (n, 2) as one flat list of whole numbers, in 1/UNIT."""
    return [int(v) for v in np.rint(UNIT * np.asarray(points, dtype=float)).ravel()]


def _map_of(situation: Situation) -> CognitiveMap:
    """A coarse map; without the margin where a hand close to an obstacle could not start."""
    made = build_map(situation, MarchingParams(n=N))
    if made.arrival.count() > 1:
        return made
    return build_map(situation, MarchingParams(n=N, margin=0.0))


def _picture(situation: Situation) -> str:
    """The map of a situation as a small image, text that stands for a file."""
    made = _map_of(situation)
    tau = made.arrival_tau
    latest = float(tau.max()) if tau.count() else 1.0
    cells = np.rint((SHADES - 1) * tau.filled(0.0) / max(latest, 1e-9)).astype(np.uint8) + 1
    cells[np.ma.getmaskarray(tau)] = 0
    cells[walls(made)], cells[made.effective_target] = SHADES + 1, SHADES + 2
    image = Image.fromarray(cells[::-1], "P")
    image.putpalette(_palette())
    stream = io.BytesIO()
    image.save(stream, "PNG", optimize=True, transparency=0)
    return base64.b64encode(stream.getvalue()).decode("ascii")


def _palette() -> list[int]:
    shades = style.MAP_COLOURS(np.linspace(0.0, 1.0, SHADES))[:, :3]
    cells = [to_rgba(colour)[:3] for colour in (style.EFFECTIVE, style.TARGET)]
    colours = np.vstack([[(1.0, 1.0, 1.0)], shades, cells])
    return [int(v) for v in np.rint(255 * colours).ravel()]
