"""Recorded tracks: where a body was, and when; windows of them, from which predictors foretell."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np

from gcm_learn import seeding
from gcm_learn.errors import FileFormatError
from gcm_learn.outside.ball_flight import flights
from gcm_learn.outside.converted import Converted
from gcm_learn.outside.nodes import Node, json_nodes, texts
from gcm_learn.outside.table_tennis import FIELDS, above_floor, balls_of, facing, meets_net

COLUMNS = ("track", "t", "x", "y", "z")
HAIR = 1e-9  # of a horizon, against rounding


class Track(NamedTuple):
    """Times (n,) [s] and places (n, 3) of a body; in a plane z is 0.

    Its velocity (3,) may be measured at the first sample; then no samples before are needed.
    """

    times: np.ndarray
    places: np.ndarray
    velocity: np.ndarray | None = None


class Window(NamedTuple):
    """Part of a track: seen places at looks (k,) [s] up to 0, later places at times (m,) from 0."""

    looks: np.ndarray
    seen: np.ndarray
    times: np.ndarray
    places: np.ndarray
    velocity: np.ndarray | None = None


def read_tracks(source: str | Path, until: float) -> list[Track]:
    """Read CSV with the columns track, t, x, y and maybe z, or states of table-tennis balls.

    States, in ``.json``, fly up to a time [s] by `ball_flight`; on the floor they end, and those
    that meet the net have one sample.

    Raises
    ------
    FileFormatError
        In one line: the file, the line and the field.
    """
    path = Path(source)
    if path.name.lower().endswith((".json", ".json.gz")):
        return list(_of_states(json_nodes([path], r".+"), until))
    tables = texts(path, r".+\.csv")
    return [track for name, text in tables for track in _of_csv(name, text)]


def _of_states(nodes: Iterator[Node], until: float) -> Iterator[Track]:
    """Yield a track for each measured ball; all fly along -y."""
    result = Converted()
    balls = balls_of(nodes, result)
    if result.left_out:
        raise result.left_out[0]
    states = facing(np.array(list(balls.values())).reshape(-1, len(FIELDS)))
    for state, flown in zip(states, flights(states, until), strict=True):
        parts = [] if meets_net(flown) else above_floor(flown)
        times = np.concatenate([[0.0], *(part.times[1:] for part in parts)])
        places = np.concatenate([state[None, :3], *(part.places[1:] for part in parts)])
        yield Track(times, places, state[3:6])


def _of_csv(name: str, text: str) -> list[Track]:
    """Return the tracks of a table, in order of appearance."""
    found: dict[str, list[list[float]]] = {}
    for line, row in _rows(name, text):
        cells = {column: Node(f"{name}:{line}", column, cell) for column, cell in row.items()}
        values = [cells[c].number() if c in cells else 0.0 for c in COLUMNS[1:]]
        track = found.setdefault(row["track"], [])
        if track and values[0] <= track[-1][0]:
            raise cells["t"].error(f"{values[0]:g} does not come after {track[-1][0]:g}")
        track.append(values)
    tables = map(np.array, found.values())
    return [Track(table[:, 0], table[:, 1:]) for table in tables]


def _rows(name: str, text: str) -> Iterator[tuple[int, dict[str, str]]]:
    """Yield number and cells of the lines of a table."""
    table = csv.reader(io.StringIO(text, newline=""), strict=True)
    try:
        head = [cell.strip() for cell in next(table, [])]
        for column in COLUMNS:
            if head.count(column) > 1 or (column != "z" and column not in head):
                reason = "is given twice" if column in head else "is missing"
                raise FileFormatError(f"{name}:1: {column}: {reason}")
        for row in filter(None, table):
            if len(row) != len(head):
                reason = f"has {len(row)} cells, the first line {len(head)}"
                raise FileFormatError(f"{name}:{table.line_num}: {reason}")
            yield table.line_num, dict(zip(head, row, strict=True))
    except csv.Error as error:
        raise FileFormatError(f"{name}:{table.line_num}: is no CSV ({error})") from None


def windows(tracks: list[Track], horizon: float, looks: int = 10, seed: int = 0) -> list[Window]:
    """Return one window of each track that is long enough, so that windows can be exchanged.

    A predictor sees `looks` samples up to a random one; of tracks with a measured velocity the
    first alone.
    """
    found = (_window(track, horizon, looks, seed, k) for k, track in enumerate(tracks))
    return [window for window in found if window is not None]


def _window(track: Track, horizon: float, looks: int, seed: int, k: int) -> Window | None:
    times, first = track.times, looks - 1 if track.velocity is None else 0
    starts = np.flatnonzero(times[-1] - times >= horizon * (1.0 - HAIR))[first:]
    if not starts.size:
        return None
    now = int(seeding.rng(seed, 1, k).choice(starts)) if track.velocity is None else 0
    after = times[now:] - times[now]
    ahead = np.append(after[after < horizon * (1.0 - HAIR)], horizon)
    places = np.stack([np.interp(ahead, after, track.places[now:, i]) for i in range(3)], axis=1)
    seen = slice(now - first, now + 1)
    return Window(times[seen] - times[now], track.places[seen], ahead, places, track.velocity)
