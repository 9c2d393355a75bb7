"""Embeddings of cognitive maps by the encoders that ship, and the nearest among them."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import chain
from pathlib import Path

import numpy as np

from gcm_learn import artifacts
from gcm_learn.arms import PLANAR, Kind
from gcm_learn.errors import RecallError
from gcm_learn.maps import CognitiveMap
from gcm_learn.recall.encoder import CONFIG, Encoder, load_encoder
from gcm_learn.recall.kinds import MEMORIES

MAPS = "encoder-map"
KEYS = "keys.npz"  # of the shipped memory, as `gcm-learn memory embed` writes them


def map_encoder(kind: Kind = PLANAR) -> Path:
    """Return the folder of the encoder of maps for a kind of arm.

    Raises
    ------
    RecallError
        One line that says how to make one.
    """
    name = MAPS + MEMORIES.of(kind).shipped.removeprefix(MEMORIES.of(PLANAR).shipped)
    folder = artifacts.model(name, CONFIG)
    if folder is None:
        own = artifacts.own("models") / name
        make = f"gcm-learn train encoder DATASET --memory map --out {own}"
        raise RecallError(artifacts.missing("models", f"encoder {name!r}", make))
    return folder


def embed(
    maps: CognitiveMap | Iterable[CognitiveMap], encoder: Encoder | None = None
) -> np.ndarray:
    """Embed cognitive maps.

    Parameters
    ----------
    maps : CognitiveMap or iterable of CognitiveMap
        One or several, of any size of cells. In space their situations are canonical, as those of
        records are.
    encoder : Encoder, optional
        An encoder of maps; by default the shipped one for the arm of the first map.

    Returns
    -------
    (dim,) or (n, dim) ndarray of float32
        Of one map, or of several.

    Examples
    --------
    >>> places = embed(record.map for record in records)   # doctest: +SKIP
    >>> nearest(embed(record.map), places)                 # doctest: +SKIP
    """
    one = isinstance(maps, CognitiveMap)
    rest = iter([maps] if isinstance(maps, CognitiveMap) else maps)
    first = next(rest, None)
    if first is None:
        raise RecallError("maps: must be at least one")
    encoder = load_encoder(map_encoder(first.chart.kind)) if encoder is None else encoder
    places = encoder.embed_maps(chain([first], rest))
    return places[0] if one else places


def nearest(place: np.ndarray, places: np.ndarray, count: int = 5) -> np.ndarray:
    """Return the rows (count,) of places (n, dim) in directions nearest to a place's (dim,)."""
    lengths = np.linalg.norm(places, axis=1) * np.linalg.norm(place)
    closeness = places @ place / np.maximum(lengths, 1e-12)
    return np.argsort(-closeness, kind="stable")[:count]
