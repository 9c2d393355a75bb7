"""The book of what was met: an even sample, true notes, and what others cover is forgotten."""

from __future__ import annotations

import numpy as np
import pytest

from gcm_learn import families, seeding
from gcm_learn.arms import SPATIAL
from gcm_learn.families.random_planar import random_planar
from gcm_learn.planners import get_planner
from gcm_learn.planners.layered_front import layered
from gcm_learn.recall import Adaptation, Memory, RawIndex, book, grow
from gcm_learn.recall.book import WORKS, Book
from gcm_learn.recall.kinds import MEMORIES
from gcm_learn.wave import MarchingParams

NAMES = ("gate", "behind-mover", "falling")


def noted(rows):
    """A book with nothing but notes."""
    out = Book(3)
    out.works = np.full((len(rows), WORKS), -1, np.int32)
    for row, memories in zip(out.works, rows, strict=True):
        row[: len(memories)] = memories
    return out


def greedy(rows, size, uses, count):
    """The same choice as plainly as it can be said."""
    left = set(range(size))
    for _ in range(count):
        sets = [set(row) & left for row in rows]
        left.remove(
            min(
                left,
                key=lambda k: (
                    sum(row == {k} for row in sets),
                    sum(k in row for row in sets),
                    uses[k],
                    k,
                ),
            )
        )
    return sorted(set(range(size)) - left)


def test_what_goes_leaves_the_fewest_situations_without_a_memory(rng):
    for size, pages in ((1, 3), (5, 0), (12, 40), (30, 25)):
        rows = [
            rng.choice(size, min(size, rng.integers(0, 4)), replace=False).tolist()
            for _ in range(pages)
        ]
        uses = rng.integers(0, 3, size)
        for count in {1, size // 2, size}:
            found = noted(rows).superfluous(count, uses)
            assert found.tolist() == greedy(rows, size, uses, count)


def test_of_two_that_cover_each_other_only_one_goes():
    rows = [[0, 1]] * 5 + [[2], [3], [3]]
    assert noted(rows).superfluous(2, np.zeros(4)).tolist() == [0, 2]  # then 1 is needed by five


def test_pages_are_an_even_sample_of_what_was_met(monkeypatch):
    monkeypatch.setattr(book, "PAGES", 400)
    pages = Book(3)
    kept: dict[int, int] = {}
    situation, none = random_planar(seeding.rng(1, 0)), np.zeros(0, np.int32)
    for k in range(4000):
        page = pages.offered()
        if page is not None:
            pages.write(page, situation, np.zeros(3, np.float32), none)
            kept[page] = k
    assert pages.met == 4000 and len(pages) == len(kept) == 400
    counts = np.histogram(list(kept.values()), 4, (0, 4000))[0]
    assert np.all(np.abs(counts - 100) < 45)  # five standard deviations


@pytest.fixture(scope="module")
def lived():
    """A memory that has forgotten much, how it grew, and what it met."""
    situations = [families.draw(NAMES[k % 3], 79, k) for k in range(240)]
    memory = Memory(RawIndex.fit(situations))
    steps = grow(memory, situations, layered(MarchingParams(n=40)), most=12)
    return memory, steps, situations


def test_what_is_noted_is_true(lived):
    memory, steps, _ = lived
    assert len(memory) == 12 and sum(s.caught and not s.recalled for s in steps) > 24
    assert len(memory.book) == memory.book.met > 100
    assert memory.book.works.max() < 12
    several = 0
    for page, row in enumerate(memory.book.works):
        known = row[row >= 0].astype(np.int64)
        assert len(set(known)) == len(known)
        problem = MEMORIES.of(memory.kind).problem(memory.book.situation(page), "test")
        tries = MEMORIES.of(memory.kind).tries(problem, Adaptation())
        assert np.all(tries.catch_times(memory.knots, memory.goals, known) >= 0.0)
        several += len(known) > 1
    assert several > 20


def same(one, other):
    """Whether two memories and their books are equal."""
    mine, theirs = one.book.arrays(), other.book.arrays()
    return (
        one.situations() == other.situations()
        and np.array_equal(one.uses, other.uses)
        and all(np.array_equal(mine[name], theirs[name]) for name in mine)
    )


@pytest.mark.parametrize("forget", ["covered", "least used", "oldest"])
def test_a_memory_that_was_saved_grows_on_as_if_nothing_had_been(lived, tmp_path, forget):
    _, _, situations = lived
    some, planner = situations[:120], layered(MarchingParams(n=40))
    whole = Memory(RawIndex.fit(situations))
    steps = grow(whole, some, planner, most=8, forget=forget)
    first = Memory(whole.index)
    before = grow(first, some[:70], planner, most=8, forget=forget)
    first.save(tmp_path)
    second = Memory.load(tmp_path)
    after = grow(second, some[70:], planner, most=8, forget=forget)
    assert [s.recalled for s in before + after] == [s.recalled for s in steps]
    assert same(second, whole)


@pytest.mark.slow
def test_in_space_a_memory_forgets_what_others_cover_and_grows_on(tmp_path):
    names = ("window-space", "late-target-space", "pendulum-space")
    situations = [families.draw(names[k % 3], 172, k) for k in range(36)]
    planner = get_planner("layered")
    memory = Memory(RawIndex.fit(situations), kind=SPATIAL)
    steps = grow(memory, situations[:24], planner, most=3)
    assert len(memory) == 3 < sum(s.caught and not s.recalled for s in steps)
    assert 0 < len(memory.book) == memory.book.met
    memory.save(tmp_path)
    loaded = Memory.load(tmp_path)
    grow(memory, situations[24:], planner, most=3)
    grow(loaded, situations[24:], planner, most=3)
    assert same(memory, loaded)


def test_another_index_asks_the_book_by_its_own_queries(lived):
    memory, _, situations = lived
    other = RawIndex.fit(situations[:50])
    refiled = memory.refiled(other)
    assert np.array_equal(refiled.book.works, memory.book.works)
    query = other.embed_query(memory.book.situation(7))
    assert np.array_equal(refiled.book.queries[7], query)
    assert not np.array_equal(refiled.book.queries[7], memory.book.queries[7])
