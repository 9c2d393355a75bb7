"""Recorded tracks, their windows, and the predictors that foretell them."""

import gzip

import numpy as np
import pytest

from gcm_learn.errors import FileFormatError
from gcm_learn.outside import ball_flight, laws_of, places_of, read_tracks, windows
from gcm_learn.outside.tracks import Track
from tests.refusals import refusal

HEAD = "track,t,x,y\n"


def written(tmp_path, text, name="tracks.csv"):
    path = tmp_path / name
    path.write_text(text)
    return path


def test_rows_of_tracks_may_alternate_and_other_columns_are_ignored(tmp_path):
    text = "t,who,y,x,track\n0,anna,1,2,a\n0,ben,5,6,b\n\n0.4,anna,3,4,a\n"
    first, second = read_tracks(written(tmp_path, text), 1.0)
    assert first.times.tolist() == [0.0, 0.4] and first.velocity is None
    assert first.places.tolist() == [[2.0, 1.0, 0.0], [4.0, 3.0, 0.0]]
    assert second.places.tolist() == [[6.0, 5.0, 0.0]]


def test_folders_and_compressed_files_are_read(tmp_path):
    text = "track,t,x,y,z\na,0,1,2,3\n"
    written(tmp_path, text)
    packed = tmp_path / "more.csv.gz"
    packed.write_bytes(gzip.compress(text.encode()))
    for source in (tmp_path, packed):
        (track,) = read_tracks(source, 1.0)
        assert track.places.tolist() == [[1.0, 2.0, 3.0]]


REFUSED = [
    ("", ":1: track: is missing"),
    ("track,t,x\n", ":1: y: is missing"),
    ("track,t,x,y,x\n", ":1: x: is given twice"),
    (HEAD + "a,0,1,2\na,1,far,2\n", ':3: x: must be a number (got "far")'),
    (HEAD + "a,0,1,nan\n", ":2: y: must be finite"),
    (HEAD + "a,0,1,\n", ':2: y: must be a number (got "")'),
    (HEAD + "a,1,1,2\nb,0,1,2\na,1,1,2\n", ":4: t: 1 does not come after 1"),
    (HEAD + "a,0,1\n", ":2: has 3 cells, the first line 4"),
    (HEAD + 'a,0,1,"2\n', ":2: is no CSV"),
]


@pytest.mark.parametrize(("text", "message"), REFUSED)
def test_what_is_not_understood_is_refused_by_line_and_field(text, message, tmp_path):
    path = written(tmp_path, text)
    assert f"{path}{message}" in refusal(FileFormatError, read_tracks, path, 1.0)


def test_measured_balls_fly_until_net_or_floor(balls):
    tracks = read_tracks(balls(), 0.4)
    assert [round(float(track.times[-1]), 3) for track in tracks] == [0.4, 0.4, 0.0, 0.4]
    broken = balls(lambda states: states[1].pop("vel_z"))
    assert "[1].vel_z: is missing" in refusal(FileFormatError, read_tracks, broken, 1.0)
    assert tracks[1].velocity.tolist() == [0.4, -5.5, 1.4]  # turned by half a turn
    assert (np.diff(tracks[0].times) > 0.0).all()


def walks(count=30, samples=40):
    rng = np.random.default_rng(5)
    steps = rng.uniform(0.05, 0.1, (count, samples))
    return [Track(np.cumsum(row), rng.normal(size=(samples, 3)).cumsum(axis=0)) for row in steps]


def test_windows_are_parts_of_their_tracks():
    tracks = walks()
    found = windows(tracks, 0.5, 4, seed=2)
    assert len(found) == len(tracks)
    for track, window in zip(tracks, found, strict=True):
        now = int(np.flatnonzero((track.places == window.seen[-1]).all(axis=1))[0])
        assert now >= 3 and len(window.looks) == 4 and window.looks[-1] == 0.0
        assert window.times[0] == 0.0 and window.times[-1] == 0.5
        assert window.seen.tolist() == track.places[now - 3 : now + 1].tolist()
        inner = len(window.times) - 1
        assert window.places[:inner].tolist() == track.places[now : now + inner].tolist()
        assert track.times[now + inner] >= track.times[now] + 0.5 - 1e-9


def test_windows_begin_anywhere_and_short_tracks_have_none():
    tracks = walks()
    first, other, again = (
        [w.seen[-1].tolist() for w in windows(tracks, 0.5, 4, seed)] for seed in (0, 1, 0)
    )
    assert first == again and first != other
    longest = max(track.times[-1] - track.times[3] for track in tracks)
    assert windows(tracks, longest + 0.01, 4) == []
    assert len(windows(tracks, longest, 4)) == 1


@pytest.mark.parametrize("name", ["rest", "velocity", "acceleration", "gravity"])
def test_predictors_are_exact_where_their_law_holds(name):
    s = np.linspace(0.0, 2.0, 41)[:, None] * np.ones(3)
    pull = 3.0 * (name == "acceleration") * np.ones(3)
    pull[2] -= ball_flight.GRAVITY * (name == "gravity")
    places = 1.0 - 2.0 * (name != "rest") * s + 0.5 * pull * s * s
    (window,) = windows([Track(2.0 + s[:, 0], places)], 0.5, 6, seed=1)
    (law,) = laws_of([window], name)
    np.testing.assert_allclose(places_of(law, window.times), window.places, atol=1e-9)


def test_balls_without_spin_are_foretold(balls):
    def still(states):
        for state in states:
            state.update(w_vel_x=0.0, w_vel_y=0.0, w_vel_z=0.0)

    for change, exact in ((still, True), (lambda states: None, False)):
        found = windows(read_tracks(balls(change), 0.6), 0.6)
        laws = laws_of(found, "ball")
        offs = [
            np.linalg.norm(places_of(law, w.times) - w.places, axis=1).max()
            for law, w in zip(laws, found, strict=True)
        ]
        assert len(offs) == 3 and (max(offs) <= 2 * ball_flight.FIT) == exact
