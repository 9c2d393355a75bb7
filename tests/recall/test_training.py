"""An encoder learns a task that is easy to know, and goes on as if it had not been stopped."""

from __future__ import annotations

import json

import numpy as np
import pytest

pytest.importorskip("torch")

import torch

from gcm_learn import seeding
from gcm_learn.errors import EncoderError
from gcm_learn.recall import EncoderConfig
from gcm_learn.recall.features import FeatureBatch, count
from gcm_learn.recall.hand_features import CELLS, CONTEXT
from gcm_learn.recall.networks import binary, contrast, listwise
from gcm_learn.recall.training import CHECKPOINT, LOG, Effort, Trainer
from gcm_learn.recall.transfer_labels import Labels

MEMORIES, SITUATIONS = 120, 96


class Toy:
    """A memory is a place on a line; it is valid where it lies near the target, and no body does.

    Whether a body is in the way is told by one of its cells, places by one number each.
    """

    def __init__(self, seed=0):
        self.seed = seed
        self.place = seeding.rng(seed).uniform(-1.0, 1.0, MEMORIES)
        self.path_features = np.zeros((MEMORIES, count(24)), np.float32)
        self.path_features[:, 3] = self.place
        self.map_features = None
        self.situation_counts = CONTEXT, CELLS
        self.asked = 0

    def situations(self, rng):
        target = rng.uniform(-1.0, 1.0, SITUATIONS)
        body = rng.uniform(-1.0, 1.0, SITUATIONS)
        context = np.zeros((SITUATIONS, CONTEXT), np.float32)
        context[:, 0] = target
        cells = np.zeros((SITUATIONS, CELLS), np.uint8)
        cells[np.arange(SITUATIONS), (10.0 * (body + 1.0)).astype(int)] = 255
        return target, body, FeatureBatch(context, cells, np.arange(SITUATIONS))

    def valid(self, target, body, rows):
        place = self.place[rows]
        near = np.abs(place - target[:, None]) < 0.4
        return near & (np.abs(place - np.floor(10.0 * body[:, None]) / 10.0) > 0.15)

    def labels(self, index, best):
        rng = seeding.rng(self.seed, 1, index)
        target, body, features = self.situations(rng)
        rows = rng.permutation(MEMORIES)[:60]
        if best is not None:
            self.asked += 1
            rows = best(features, 30)
        nothing = np.full(SITUATIONS, -1)
        return Labels(features, rows, self.valid(target, body, rows), nothing)

    def validate(self, best):
        target, body, features = self.situations(seeding.rng(self.seed, 2))
        return {"first": float(self.valid(target, body, best(features, 1)).mean())}


CONFIG = EncoderConfig(dim=8, width=32, steps=25, rate=5e-3)


def test_it_learns_what_is_valid(tmp_path):
    toy = Toy()
    trainer = Trainer(CONFIG, toy, tmp_path, Effort(turns=24))
    before = trainer.validate()["first"]
    trainer.run()
    after = trainer.validate()["first"]
    assert before < 0.6 and after > 0.9
    assert toy.asked > 3  # about what it thought best
    lines = [json.loads(line) for line in (tmp_path / LOG).read_text().splitlines()]
    assert lines[-1]["first"] == pytest.approx(after, abs=1e-4)
    assert lines[-2]["binary"] < 0.5 * lines[0]["binary"]


def test_a_run_that_was_stopped_ends_the_same(tmp_path):
    whole = Trainer(CONFIG, Toy(), tmp_path / "whole", Effort(turns=6)).run()
    first = Trainer(CONFIG, Toy(), tmp_path / "parts", Effort(turns=6))

    def stop(share):
        if first.turn == 3:
            first.save()
        if first.turn == 4:  # beyond the checkpoint
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        first.run(stop)
    second = Trainer(CONFIG, Toy(), tmp_path / "parts", Effort(turns=6))
    assert second.turn == 3
    assert second.run().key == whole.key
    turns = [json.loads(line)["turn"] for line in (tmp_path / "parts" / LOG).open()]
    assert turns == [1, 2, 3, 4, 5, 6, 6]
    third = Trainer(CONFIG, Toy(), tmp_path / "parts", Effort(turns=6))
    assert third.encoder.key == whole.key


def test_a_checkpoint_of_another_configuration_is_refused(tmp_path):
    Trainer(CONFIG, Toy(), tmp_path, Effort(turns=1)).save()
    assert (tmp_path / CHECKPOINT).exists()
    other = EncoderConfig(dim=4, width=32)
    with pytest.raises(EncoderError, match="another configuration"):
        Trainer(other, Toy(), tmp_path, Effort(turns=1))


def test_losses_ask_for_what_they_say():
    valid = torch.tensor([[True, False, False], [False, False, True], [False, False, False]])
    right = torch.where(valid, 9.0, -9.0)
    bias = torch.zeros(3, 1)
    for loss in (lambda s: binary(s, bias, valid), lambda s: listwise(s, valid)):
        assert float(loss(right)) < 1e-3 < 1.0 < float(loss(-right))
    # Own memories are compared with what is not valid, never with others that do.
    both = torch.tensor([[True, True, False]])
    own = torch.tensor([0])
    worse = torch.tensor([[0.0, 5.0, -9.0]])
    assert float(contrast(worse, both, own)) < 1e-3
    assert float(contrast(-worse, both, own)) > 5.0
    nobody = torch.tensor([-1, -1, -1])
    assert float(contrast(right, valid, nobody)) == 0.0
