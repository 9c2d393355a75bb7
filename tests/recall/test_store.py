"""The store: exact search, round trips, and folders that are whole whatever happens."""

import importlib.util
import re

import numpy as np
import pytest

from gcm_learn.errors import MissingExtraError, RecallError
from gcm_learn.recall import Memory, RandomIndex, RawIndex, files
from gcm_learn.recall.index import PcaIndex
from gcm_learn.recall.search import Searcher, top
from gcm_learn.situation.canonical import canonical
from tests.recall.conftest import memory_by
from tests.refusals import refusal
from tests.transforms import mirrored, turned


def same(a, b):
    """Whether two memories hold the same."""
    arrays = ("embeddings", "knots", "goals")
    rows = [[m[k].situation for k in range(0, len(m), 37)] for m in (a, b)]
    words = [[(m[k].family, m[k].stratum) for k in range(len(m))] for m in (a, b)]
    return (
        (len(a), a.index.key, rows[0], words[0]) == (len(b), b.index.key, rows[1], words[1])
        and all(np.array_equal(getattr(a, name), getattr(b, name)) for name in arrays)
    )  # fmt: skip


def test_the_best_scores_are_those_of_a_full_sort(rng):
    for size, k in ((1, 1), (5, 9), (1000, 20), (1000, 1)):
        scores = rng.integers(0, 50, size).astype(np.float32)  # with ties
        assert np.array_equal(top(scores, k), np.argsort(-scores, kind="stable")[:k])


def test_recall_is_brute_force_and_raw_neighbours_are_the_nearest(memory, catches):
    for k, (situation, _) in list(enumerate(catches))[::17]:
        query = memory.index.embed_query(mirrored(turned(situation, 1.0)))
        order = np.argsort(-(memory.embeddings.astype(float) @ query), kind="stable")
        assert set(memory.recall(query, 20)) == set(order[:20])
        assert memory.recall(query, 1)[0] == k
        away = np.linalg.norm(memory.embeddings[:, :-1] - query[:-1], axis=1)
        assert np.array_equal(memory.recall(query, 5), np.argsort(away, kind="stable")[:5])


@pytest.mark.skipif(importlib.util.find_spec("faiss") is None, reason="needs the extra `index`")
def test_faiss_finds_what_exact_search_finds(rng):
    rows = rng.standard_normal((5000, 24)).astype(np.float32)
    exact, faiss = Searcher(rows, "exact"), Searcher(rows, "faiss")
    for query in rng.standard_normal((20, 24)).astype(np.float32):
        assert np.array_equal(exact(query, 10), faiss(query, 10))


def test_faiss_is_asked_for_by_name(monkeypatch):
    monkeypatch.setattr("gcm_learn.recall.search.has_faiss", lambda: False)
    with pytest.raises(MissingExtraError, match=r"pip install 'gcm_learn\[index\]'"):
        Searcher(np.zeros((3, 2), np.float32), "faiss")
    assert list(Searcher(np.eye(3, dtype=np.float32))(np.array([0.0, 1.0, 0.5]), 2)) == [1, 2]


@pytest.mark.parametrize("kind", [RawIndex, RandomIndex, PcaIndex])
def test_save_and_load(memory, catches, kind, tmp_path):
    memory = memory.refiled(kind.fit([s for s, _ in catches[:60]], 3))
    memory.save(tmp_path / "memory")
    for mmap in (True, False):
        loaded = Memory.load(tmp_path / "memory", mmap=mmap)
        assert same(loaded, memory)
        query = loaded.index.embed_query(catches[5][0])
        assert np.array_equal(query, memory.index.embed_query(catches[5][0]))
        assert query.shape == (loaded.index.dim,)


def test_what_was_loaded_can_grow_and_forget(memory, catches, traces, tmp_path):
    memory.save(tmp_path)
    loaded = Memory.load(tmp_path)
    loaded.add([catches[0][0]], [traces[0]], ["again"], ["L"])
    assert len(loaded) == len(memory) + 1
    assert loaded[-1].family == "again" and loaded[-1].situation == memory[0].situation
    loaded.forget(np.array([len(memory)]))
    loaded.save(tmp_path)  # over the files it was read from
    assert same(Memory.load(tmp_path), memory)


def test_forgetting(memory):
    first, last = memory[1], memory[-1]
    memory.forget(np.array([0]))
    assert memory[0].situation == first.situation
    memory.forget(np.arange(1, len(memory) - 1))
    assert memory.situations() == [first.situation, last.situation]
    memory.forget(np.ones(2, dtype=bool))
    assert len(memory) == 0


def test_what_is_not_a_memory_is_said_in_one_line(memory, catches, tmp_path):
    missing = "no memory there (manifest.json is missing)"
    assert missing in refusal(RecallError, Memory.load, tmp_path)
    memory.save(tmp_path)
    said = refusal(RecallError, Memory.load, tmp_path, RawIndex.fit([s for s, _ in catches[:20]]))
    assert f"filed by an index with key {memory.index.key}" in said
    assert len(Memory.load(tmp_path, memory.index)) == len(memory)
    traces = next(tmp_path.glob("data-*/traces.npy"))
    traces.write_bytes(traces.read_bytes()[:-5])
    said = refusal(RecallError, Memory.load, tmp_path)
    assert re.search(r"traces.npy has \d+ bytes, expected \d+", said)
    (tmp_path / "manifest.json").write_text("[]")
    assert "not a memory's manifest" in refusal(RecallError, Memory.load, tmp_path)


@pytest.mark.parametrize("at", ["np.save", "to_disk", "write_whole"])
def test_an_interrupted_save_leaves_the_old_memory(memory, at, tmp_path, monkeypatch):
    memory.save(tmp_path)
    changed = memory.refiled(memory.index)
    changed.forget(np.arange(100))

    def stop(*args, **options):
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr(files.np if at == "np.save" else files, at.removeprefix("np."), stop)
        with pytest.raises(KeyboardInterrupt):
            changed.save(tmp_path)
    assert same(Memory.load(tmp_path), memory)
    assert len(list(tmp_path.glob("data-*"))) == 1
    (tmp_path / "data-killed").mkdir()  # what a killed process leaves behind
    changed.save(tmp_path)
    assert same(Memory.load(tmp_path), changed)
    assert len(list(tmp_path.glob("data-*"))) == 1


@pytest.mark.parametrize("kind", [RawIndex, RandomIndex, PcaIndex])
def test_queries_do_not_depend_on_how_a_situation_lies(catches, kind):
    index = kind.fit([s for s, _ in catches[:60]], 1)
    for situation, _ in catches[60:70]:
        here = index.embed_query(canonical(situation)[0])
        for other in (situation, turned(situation, 1.1), mirrored(situation)):
            np.testing.assert_allclose(index.embed_query(other), here, atol=2e-3)


@pytest.mark.slow
@pytest.mark.parametrize("search", ["exact", "auto"])
def test_a_million_entries(memory, search, tmp_path):
    """Filing them would take a while, so the columns are filled by hand."""
    index, count = RandomIndex(), 1_000_000
    embeddings = np.zeros((count, index.dim), np.float32)
    embeddings[:, 0] = np.arange(count)
    knots = np.broadcast_to(memory.knots[:1], (count, *memory.knots.shape[1:]))
    goals = np.broadcast_to(memory.goals[:1], (count, 2))
    many = memory_by(index, embeddings, knots, goals, search)
    many.save(tmp_path)
    loaded = Memory.load(tmp_path, many.index, search=search)
    query = np.eye(1, many.index.dim, dtype=np.float32)[0]
    assert list(loaded.recall(query, 3)) == [count - 1, count - 2, count - 3]
    loaded.forget(np.arange(10, count))
    assert len(loaded) == 10
