"""Margins by split conformal prediction: coverage, scaling, and what has no part in them."""

import json
from math import ceil

import numpy as np
import pytest
from scipy.stats import betabinom

from gcm_learn.cli import main
from gcm_learn.errors import FieldError, UnknownNameError
from gcm_learn.evaluation import calibrate
from gcm_learn.evaluation.calibration import quantile, split
from gcm_learn.outside import Window
from gcm_learn.situation import Margin
from tests.refusals import refusal

TIMES = np.linspace(0.0, 0.5, 11)


def drawn(count, seed, *, length=1.0, time=1.0):
    """Return windows of bodies that should rest, and go astray by very unequal amounts."""
    rng = np.random.default_rng(seed)
    sizes = rng.standard_t(2.0, (count, 1, 3)) * np.ones((1, len(TIMES), 1))
    places = length * (sizes * TIMES[None, :, None] + 0.05 * rng.normal(size=sizes.shape))
    looks, seen = np.zeros(1), np.zeros((1, 3))
    return [Window(looks, seen, time * TIMES, rows) for rows in places]


@pytest.mark.parametrize("cover", [0.8, 0.95])
def test_held_out_tracks_stay_within_as_often_as_they_should(cover):
    """Held-out counts of exchangeable tracks follow a beta-binomial law, whatever the errors."""
    runs, count = 80, 100
    found = [calibrate(drawn(count, seed), "rest", cover, seed) for seed in range(runs)]
    n, m = found[0].calibrated, found[0].held_out
    rank = ceil((n + 1) * cover)
    law = betabinom(m, rank, n + 1 - rank)
    within = np.array([one.within for one in found])
    off = (within.mean() - law.mean()) / (law.std() / np.sqrt(runs))
    assert abs(off) < 3.3 and law.mean() >= m * cover
    assert np.mean(within < law.ppf(0.025)) < 0.08 and np.mean(within > law.ppf(0.975)) < 0.08


def test_a_quantile_covers_one_more_of_the_same():
    """Each of n + 1 scores is within the quantile of the others as often as its rank says."""
    scores = np.random.default_rng(3).normal(size=40)
    for cover in (0.5, 0.9, 0.95, 0.975):
        held = [scores[k] <= quantile(np.delete(scores, k), cover) for k in range(40)]
        assert np.sum(held) == ceil(40 * cover)
    assert quantile(scores[:39], 0.98) == np.inf


def test_margins_have_the_units_of_tracks():
    one = calibrate(drawn(200, 1), "rest")
    long = calibrate(drawn(200, 1, length=3.0), "rest")
    slow = calibrate(drawn(200, 1, time=4.0), "rest")
    assert one.margin.now > 0.0 and one.margin.rate > 0.0
    assert long.margin.now == pytest.approx(3.0 * one.margin.now)
    assert long.margin.rate == pytest.approx(3.0 * one.margin.rate)
    assert slow.margin.now == pytest.approx(one.margin.now)
    assert slow.margin.rate == pytest.approx(one.margin.rate / 4.0)
    assert one.within == long.within == slow.within


@pytest.mark.parametrize(("power", "shape"), [(0.0, 1.0), (1.0, 0.0)])
def test_the_shape_is_that_of_the_errors(power, shape):
    """Errors that are the same at all times make a constant margin, even ones grow from 0."""
    sizes = np.random.default_rng(7).uniform(0.5, 1.5, 100)
    rows = [size * (TIMES**power)[:, None] * np.array([0.0, 0.6, 0.8]) for size in sizes]
    done = calibrate([Window(np.zeros(1), np.zeros((1, 3)), TIMES, row) for row in rows], "rest")
    assert done.shape == shape
    assert (done.margin.rate == 0.0) == (shape == 1.0)
    assert (done.margin.now == 0.0) == (shape == 0.0)


def test_held_out_tracks_have_no_part_in_the_margin():
    found = drawn(200, 4)
    done, far = calibrate(found, "rest", seed=5), list(found)
    for k in split(len(found), 5)[2]:
        far[k] = far[k]._replace(places=far[k].places + 100.0)
    again = calibrate(far, "rest", seed=5)
    assert again.margin == done.margin and again.within == 0


REFUSED = [
    (UnknownNameError, 200, "psychic", "predictor: 'psychic' is not one of rest"),
    (FieldError, 40, "rest", "tracks: 40 are too few for a cover of 0.95 (16 make the margin)"),
    (FieldError, 0, "rest", "tracks: 0 are too few"),
    (FieldError, 200, "acceleration", "looks: predictor 'acceleration' needs 3 (got 1)"),
]


@pytest.mark.parametrize(("error", "count", "name", "message"), REFUSED)
def test_what_cannot_be_calibrated_is_refused(error, count, name, message):
    assert message in refusal(error, calibrate, drawn(count, 0), name)


@pytest.fixture
def walkers(tmp_path):
    """Return a file of people who walk on and turn a little."""
    rng, rows = np.random.default_rng(11), ["track,t,x,y"]
    for k in range(120):
        turn = np.cumsum(rng.normal(0.0, 0.1, 12))
        x, y = np.cumsum(0.5 * np.cos(turn)), np.cumsum(0.5 * np.sin(turn))
        rows += [f"{k},{0.4 * i},{x[i]},{y[i]}" for i in range(12)]
    path = tmp_path / "walkers.csv"
    path.write_text("\n".join([*rows, "short,0,0,0"]) + "\n")
    return path


def test_the_command_says_margin_and_coverage(walkers, tmp_path, capsys):
    out = tmp_path / "margin.json"
    words = ["calibrate", str(walkers), "--predictor", "velocity", "--cover", "0.9"]
    assert main([*words, "--horizon", "1s", "--looks", "3", "--out", str(out)]) == 0
    said, told = capsys.readouterr().out, json.loads(out.read_text())
    assert Margin(**told["margin"]).rate > 0.0
    assert (told["chosen"], told["calibrated"], told["held_out"], told["too_short"]) == (
        12,
        48,
        60,
        1,
    )
    share, low, high = told["covered"]
    assert low < share == told["within"] / 60 < high
    assert (
        f"held out: {told['within']} of 60 tracks stay within" in said and "of 90 % asked" in said
    )


WRONG = [
    (["--predictor", "velocity", "--horizon", "60s"], "tracks: 0 are too few"),
    (["--predictor", "velocity", "--cover", "1"], "1: must be above 0 and at most 0.999"),
    (["--predictor", "physic"], "predictor: 'physic' is not one of rest"),
    (["--predictor", "rest", "--out", "walkers.csv"], "is the file of TRACKS, too"),
]


@pytest.mark.parametrize(("words", "message"), WRONG)
def test_the_command_refuses_in_one_line(words, message, walkers, capsys, monkeypatch):
    monkeypatch.chdir(walkers.parent)
    assert main(["calibrate", "walkers.csv", *words]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert message in line
