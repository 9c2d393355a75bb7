"""The learned index: its memory is its own, its recall keeps the promise, its failures teach."""

import numpy as np
import pytest

from tests.recall.conftest import stacked

pytest.importorskip("torch")
pytest.importorskip("safetensors")

import torch

from gcm_learn import seeding
from gcm_learn.errors import RecallError
from gcm_learn.families.random_planar import random_planar
from gcm_learn.planners.completion import Problem
from gcm_learn.recall import EncoderConfig, Memory, RecallPlanner, index_class
from gcm_learn.recall.adaptation import DEFAULT, Adaptation, query_of, transfer
from gcm_learn.recall.encoder import Encoder
from gcm_learn.recall.features import count
from gcm_learn.recall.hand_features import CELLS, CONTEXT
from gcm_learn.recall.hand_paths import KNOTS, hand_work
from gcm_learn.recall.index import LearnedIndex
from gcm_learn.recall.networks import EncoderNet, Inputs
from gcm_learn.recall.search import Searcher
from gcm_learn.recall.trials import Offer, TrialLimits, first_valid
from tests.judging import judge
from tests.transforms import turned


def learned(seed=0, memory="trace"):
    """An index that has learned nothing."""
    torch.manual_seed(seed)
    config = EncoderConfig(dim=8, width=16, memory=memory)
    inputs = Inputs(CONTEXT, CELLS, count(KNOTS), 1345)
    return LearnedIndex(Encoder(config, EncoderNet(config, inputs).arrays()))


@pytest.fixture
def filed(memory):
    return memory.refiled(learned())


def test_it_is_registered_and_takes_training():
    assert index_class("learned") is LearnedIndex
    with pytest.raises(RecallError, match="train encoder"):
        LearnedIndex.fit([])


def test_a_memory_is_found_again_with_its_encoder_and_no_other(filed, catches, tmp_path):
    filed.save(tmp_path)
    again = Memory.load(tmp_path)
    assert again.index.key == filed.index.key
    query = filed.index.embed_query(catches[5][0])
    np.testing.assert_array_equal(again.index.embed_query(catches[5][0]), query)
    np.testing.assert_array_equal(again.recall(query, 9), filed.recall(query, 9))
    with pytest.raises(RecallError, match="filed by an index with key"):
        Memory.load(tmp_path, learned(1))
    next(tmp_path.glob("data-*/encoder.safetensors")).write_bytes(b"")
    with pytest.raises(RecallError, match=r"encoder\.safetensors"):
        Memory.load(tmp_path)


def test_a_query_knows_neither_map_nor_catch(catches, traces, memory):
    """Its embedding is that of a situation alone; only memories are embedded by maps."""
    index, situation = learned(2, "both"), catches[0][0]
    there = index.embed_query(turned(situation, 0.7))
    np.testing.assert_allclose(index.embed_query(situation), there, atol=1e-4)
    for made, alike in ((index, False), (learned(2), True)):  # the same way on another map
        one, two = (made.embed_memories([memory.situation(k)], traces[:1])[0] for k in (0, 1))
        assert np.array_equal(one, two) if alike else not np.allclose(one, two)


def test_every_catch_keeps_the_promise(filed):
    planner, caught = RecallPlanner(filed), 0
    for k in range(60):
        situation = random_planar(seeding.rng(76, k))
        plan = planner.plan(situation)
        if plan.caught:
            caught += 1
            assert judge(situation, plan) == []
    assert caught > 12


def undecided(traces, seed, how=DEFAULT):
    """Questions about random situations, and which of the traces are valid in them."""
    for k in range(200):
        problem = Problem(random_planar(seeding.rng(seed, k)), "undecided")
        if problem.early_answer() is None:
            yield query_of(problem), transfer(problem, *stacked(traces), how=how) >= 0.0


def test_a_failure_sends_what_lies_near_it_to_the_back(traces):
    """Of two equal groups of memories, the second is asked as soon as one of the first fails."""
    tested = 0
    for query, valid in undecided(traces, 77):
        if not 0 < valid.sum() < 0.8 * len(valid):
            continue
        bad, good = np.flatnonzero(~valid)[:6], np.flatnonzero(valid)[:1]
        chosen = np.concatenate([bad, good])
        places = np.repeat(np.eye(2, dtype=np.float32), (len(bad), 1), axis=0)
        tried = {}
        for penalty in (0.0, 2.0):
            scores = np.array([1.0] * len(bad) + [0.5])
            offer = Offer(chosen, scores, places, np.ones(len(chosen), bool))
            budget = TrialLimits(DEFAULT.bends, 99, 0.0, penalty)
            found, _, tried[penalty], _ = first_valid(
                query, stacked(traces), offer, DEFAULT.styles, budget, hand_work(query)
            )
            assert found == len(bad)
        assert tried[2.0] <= tried[0.0]
        assert tried[2.0] <= 4
        tested += 1
    assert tested > 20


def test_after_a_failure_the_memory_that_touches_least_is_next(traces):
    """Some are looked at before the second is checked, unless their order is to be kept."""
    unbent, tested, first = Adaptation(bends=0), 0, 0
    for query, valid in undecided(traces, 79, unbent):
        if valid.sum() < 1 or (~valid).sum() < 4:
            continue
        chosen = np.concatenate([np.flatnonzero(~valid)[:4], np.flatnonzero(valid)[:1]])
        found = {}
        for novelty in (0.0, 1e-9):
            places = np.zeros((5, 2), np.float32)
            offer = Offer(chosen, -1e-3 * np.arange(5.0), places, np.ones(5, bool))
            found[novelty] = first_valid(
                query, stacked(traces), offer, unbent.styles, TrialLimits(0, 2, novelty, 0.0),
                hand_work(query),
            )[0]  # fmt: skip
        assert found[0.0] == -1
        tested, first = tested + 1, first + (found[1e-9] == 4)
    assert tested > 20 and first > 0.5 * tested


def test_cells_find_nearly_what_exact_search_finds(rng):
    directions = rng.standard_normal((6, 16))
    rows = (rng.standard_normal((20_000, 6)) @ directions).astype(np.float32)
    queries = (rng.standard_normal((40, 6)) @ directions).astype(np.float32)
    exact, cells = Searcher(rows, "exact"), Searcher(rows, "cells")
    shares = [len(set(exact(q, 20)) & set(cells(q, 20))) / 20 for q in queries]
    assert np.mean(shares) > 0.9
    for query in queries[:5]:
        found = cells(query, 20)
        scores = rows[found] @ query
        assert len(set(found)) == 20 and (np.diff(scores) <= 1e-4).all()
