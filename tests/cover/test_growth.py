"""Growth: what is covered adds up, and interruptions change nothing."""

from __future__ import annotations

import json

import numpy as np
import pytest

from gcm_learn.cover import (
    FAMILIES,
    Budget,
    Cover,
    broken_of,
    grow,
    is_cover,
    load_cover,
    parametric_family,
)
from gcm_learn.errors import CoverError, FamilyError, UnknownNameError
from gcm_learn.processes import Here, crew_of


def grown(cover, cells):
    grow(cover, Budget(1.0, cells=cells), Here())
    return cover


def told(cover):
    """Return all of a cover but for its times, as plain values."""
    cells = [
        (c.low.tolist(), c.high.tolist(), c.axis, c.first, c.reason, tuple(catch_of(cover, c)))
        for c in cover.cells
    ]
    return cells, [row[:3] for row in cover.curve]


def catch_of(cover, cell):
    """Return the last place of the catch that a cell holds, or its state."""
    return cover.catches[cell.held].way[-1].tolist() if cell.held >= 0 else [cell.held]


def test_cells_fill_the_box_and_shares_add_up(cover):
    leaves = list(cover.leaves())
    assert sum(map(cover.size, leaves)) == pytest.approx(1.0)
    assert cover.share + sum(cover.missing().values()) == pytest.approx(1.0)
    assert cover.curve[-1][2] == pytest.approx(cover.share) and cover.share > 0.9
    shares = [row[2] for row in cover.curve]
    assert shares == sorted(shares)


def test_every_point_is_found_in_the_cell_that_holds_it(cover):
    rng = np.random.default_rng(0)
    for theta in rng.uniform(cover.family.low, cover.family.high, (200, 2)):
        cell = cover.find(theta.tolist())
        assert cell.axis < 0 and (cell.low <= theta).all() and (theta <= cell.high).all()
    assert cover.find((cover.family.high + 1e-6).tolist()) is None


@pytest.mark.parametrize(
    "name", [pytest.param(n, marks=pytest.mark.slow if n != "belt" else ()) for n in FAMILIES]
)
def test_interrupted_growth_goes_on_as_if_it_had_not_been(name, tmp_path):
    family = parametric_family(name).free(2)
    whole, parts = grown(Cover(family), 40), Cover(family)
    for cells in (5, 20, 40):
        grown(parts, cells).save(tmp_path)
        parts = load_cover(tmp_path)
    assert told(parts) == told(whole)
    assert whole.used


def test_saved_covers_come_back(cover, tmp_path):
    assert not is_cover(tmp_path)
    cover.save(tmp_path)
    cover.save(tmp_path)
    assert is_cover(tmp_path) and len(list(tmp_path.iterdir())) == 2
    assert told(load_cover(tmp_path)) == told(cover)


@pytest.mark.slow
def test_more_processes_find_the_same(tmp_path):
    family = parametric_family("belt").free(3)
    with crew_of(2) as crew:
        shared = Cover(family)
        grow(shared, Budget(1.0, cells=60), crew)
    assert told(shared) == told(grown(Cover(family), 60))


@pytest.mark.slow
@pytest.mark.parametrize("name", FAMILIES)
def test_many_draws_from_three_parameters_keep_every_promise(name):
    cover = Cover(parametric_family(name).free(3))
    grow(cover, Budget(0.9), Here())
    assert cover.share >= 0.9
    assert broken_of(cover, 5000, 8) == (0, 5000)


def test_cells_that_cannot_be_covered_are_closed_with_a_reason(plane, monkeypatch):
    """No smaller cells are made, so what is not proven at once is closed."""
    monkeypatch.setattr("gcm_learn.cover.growth.SMALLEST", 1.0)
    small = grown(Cover(plane.family), 10)
    assert sum(small.missing().values()) == 1.0 and "not examined" not in small.missing()


def test_damage_is_named(cover, tmp_path):
    with pytest.raises(CoverError, match=r"no cover there \(cover.json is missing\)"):
        load_cover(tmp_path)
    cover.save(tmp_path)
    path = tmp_path / "cover.json"
    about = json.loads(path.read_text())
    for changes, message in (
        ({"format": "gcm-learn/cover@9"}, "format must be"),
        ({"digest": "0"}, "has changed; make the cover anew"),
        ({"reasons": None}, "not a cover"),
        ({"data": "cells-0.npz"}, r"no cover there \(cells-0.npz is missing\)"),
        ({"curve": "abc"}, "not a cover"),
    ):
        path.write_text(json.dumps(about | changes))
        with pytest.raises(CoverError, match=message):
            load_cover(tmp_path)


def test_cells_that_were_changed_by_hand_are_refused(cover, tmp_path):
    cover.save(tmp_path)
    (data,) = tmp_path.glob("cells-*.npz")
    whole = data.read_bytes()
    with np.load(data) as stored:
        arrays = {name: stored[name] for name in stored.files}
    arrays["held"][arrays["held"] > 0] -= 1
    np.savez(data, **arrays)
    with pytest.raises(CoverError, match=f"{data.name}: is damaged, or was changed by hand"):
        load_cover(tmp_path)
    data.write_bytes(whole[: len(whole) // 2])
    with pytest.raises(CoverError, match=f"{data.name}: is damaged"):
        load_cover(tmp_path)


class Impatient:
    """Does the tasks of some calls, and is interrupted in the next."""

    def __init__(self, calls):
        self.left = calls

    def map(self, function, tasks):
        if self.left == 0:
            raise KeyboardInterrupt
        self.left -= 1
        return map(function, tasks)


def test_an_interruption_keeps_what_was_examined(tmp_path):
    cover = Cover(parametric_family("belt").free(3))
    with pytest.raises(KeyboardInterrupt):
        grow(cover, Budget(1.0), Impatient(2), keep=lambda done: done.save(tmp_path))
    kept = load_cover(tmp_path)
    assert told(kept) == told(cover) and kept.examined > 1


@pytest.mark.slow
def test_cells_are_cut_to_where_a_catch_nearly_holds(monkeypatch):
    """Their parts are examined once; without that every half on the way is."""
    few, many = [], []
    for spared, counts in ((2, few), (99, many)):
        monkeypatch.setattr("gcm_learn.cover.growth.SPARED", spared)
        cover = Cover(parametric_family("belt-space").free(3))
        grow(cover, Budget(0.1), Here())
        counts.append((cover.examined, len(cover.cells)))
    assert few[0][0] < 0.7 * many[0][0]


def test_names_and_numbers_of_parameters_are_checked():
    with pytest.raises(UnknownNameError, match="did you mean 'belt'"):
        parametric_family("bellt")
    with pytest.raises(FamilyError, match="'belt' has 1 to 5 parameters"):
        parametric_family("belt").free(6)
