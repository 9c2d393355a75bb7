"""Films: a GIF that plays, is small and shows the movement."""

from __future__ import annotations

import itertools

import numpy as np
from PIL import Image

from gcm_learn.plots import animate
from gcm_learn.plots.figures.film import FRAMES, HOLD_TIME


def frames_of(path):
    with Image.open(path) as film:
        frames, times = [], []
        for k in range(film.n_frames):
            film.seek(k)
            frames.append(np.asarray(film.convert("RGB"), dtype=int))
            times.append(film.info["duration"])
    return frames, times


def test_film_moves_stops_and_loops(planar_case, tmp_path):
    situation, plan = planar_case
    path = tmp_path / "film"  # the name need not end in .gif
    animate(situation, plan, path, frames=8)
    frames, times = frames_of(path)
    assert len(frames) == 8 and FRAMES <= 60
    assert times[-1] == HOLD_TIME > times[0]
    changes = [np.abs(b - a).max() for a, b in itertools.pairwise(frames)]
    assert min(changes) > 50
    assert path.stat().st_size < 400_000


def test_film_keeps_a_white_ground(planar_case, tmp_path):
    situation, plan = planar_case
    animate(situation, plan, tmp_path / "film.gif", frames=3)
    frames, _ = frames_of(tmp_path / "film.gif")
    for frame in frames:
        np.testing.assert_array_equal(frame[0, 0], 255)


def test_film_leaves_no_trace_of_earlier_frames(planar_case, tmp_path):
    """The last frame of a long film equals the last frame of a short one."""
    situation, plan = planar_case
    lasts = []
    for count in (2, 7):
        animate(situation, plan, tmp_path / "film.gif", frames=count)
        lasts.append(frames_of(tmp_path / "film.gif")[0][-1])
    different = (np.abs(lasts[0] - lasts[1]).max(axis=-1) > 60).mean()
    assert different < 1e-3
