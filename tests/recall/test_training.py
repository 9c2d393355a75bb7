"""Encoders: arrays and torch agree, files are whole, and learning goes on as if never stopped."""

import json

import numpy as np
import pytest

from tests.refusals import refusal

pytest.importorskip("torch")

import pytest
import torch

from gcm_learn import seeding
from gcm_learn.errors import EncoderError
from gcm_learn.recall import EncoderConfig
from gcm_learn.recall.features import FeatureBatch, count, hand_path_features
from gcm_learn.recall.hand_features import CELLS, CONTEXT
from gcm_learn.recall.map_features import planar_map, planar_map_features
from gcm_learn.recall.networks import binary, contrast, listwise
from gcm_learn.recall.training import CHECKPOINT, LOG, Effort, Trainer
from gcm_learn.recall.transfer_labels import ValidMemories

pytest.importorskip("torch")
pytest.importorskip("safetensors")
from gcm_learn.families.random_planar import random_planar
from gcm_learn.recall import load_encoder, save_encoder
from gcm_learn.recall.encoder import Encoder
from gcm_learn.recall.features import batched
from gcm_learn.recall.hand_features import clearance_features
from gcm_learn.recall.networks import EncoderNet, Inputs

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
        return ValidMemories(features, rows, self.valid(target, body, rows), nothing)

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


KNOTS, MAP = 24, 1345


def network(memory="both", seed=0):
    """A network with weights at random, rounded to what is stored."""
    torch.manual_seed(seed)
    net = EncoderNet(
        EncoderConfig(dim=6, width=20, memory=memory), Inputs(CONTEXT, CELLS, count(KNOTS), MAP)
    )
    rng = seeding.rng(seed)
    for tower in (part for part in net.children() if hasattr(part, "mean")):
        size = tower.mean.shape[0]
        tower.fit_scale(rng.normal(0.3, 0.7, (50, size)).astype(np.float32))
    net.load_state_dict({k: v.half().float() for k, v in net.state_dict().items()})
    return net


def some_ways(n):
    rng = seeding.rng(5)
    traces = np.cumsum(rng.uniform(0.0, 0.05, (n, KNOTS, 4)), axis=1).astype(np.float32)
    return traces, rng.uniform(0.0, 1.0, (n, 2)).astype(np.float32)


@pytest.fixture(scope="module")
def situations():
    return [random_planar(seeding.rng(92, k)) for k in range(12)]


def test_arrays_embed_as_torch_does(situations):
    net = network()
    encoder = Encoder(net.config, net.arrays())
    features = batched([clearance_features(s) for s in situations])
    with torch.no_grad():
        wanted = net.queries(features).numpy()
    found = np.array([encoder.embed_situation(s) for s in situations])
    np.testing.assert_allclose(found, wanted, atol=0.05 * np.abs(wanted).max())  # bytes of cells
    traces, goals = some_ways(len(situations))
    pictures = np.array([planar_map_features(planar_map(s)) for s in situations])
    with torch.no_grad():
        way = torch.from_numpy(hand_path_features(traces, goals))
        wanted = net.memories(way, torch.from_numpy(pictures)).numpy()
    found = encoder.embed_memories(situations, traces, goals)
    np.testing.assert_allclose(found, wanted, atol=1e-4)


def test_what_is_loaded_is_what_was_saved(tmp_path, situations):
    net = network(seed=1)
    encoder = Encoder(net.config, net.arrays())
    save_encoder(encoder, tmp_path)
    again = load_encoder(tmp_path)
    assert again.key == encoder.key and again.config == encoder.config
    query = situations[0]
    np.testing.assert_array_equal(again.embed_situation(query), encoder.embed_situation(query))
    assert Encoder(net.config, network(seed=2).arrays()).key != encoder.key


def test_other_files_are_refused_in_one_line(tmp_path):
    net = network()
    save_encoder(Encoder(net.config, net.arrays()), tmp_path)
    for name, content, complaint in (
        ("encoder.safetensors", "nothing", "damaged"),
        ("config.json", "{}", "format: is None"),
        ("config.json", None, "config.json is missing"),
    ):
        if content is None:
            (tmp_path / name).unlink()
        else:
            (tmp_path / name).write_text(content)
        assert complaint in refusal(EncoderError, load_encoder, tmp_path)


def test_maps_tell_apart_unreached_and_reached_at_once(situations):
    """A cell without arrival has the number 0, like the start, and a field that says so."""
    for situation in situations:
        picture = planar_map_features(planar_map(situation))
        assert picture.shape == (MAP,) and np.isfinite(picture).all()
        arrival, reached = picture[:320], picture[320:640]
        assert set(np.unique(reached)) <= {0.0, 1.0}
        assert (arrival[reached == 0.0] == 0.0).all()


def test_ways_depend_on_nothing_but_place_and_time():
    traces, goals = some_ways(4)
    features = hand_path_features(traces, goals)
    assert features.shape == (4, count(KNOTS)) and np.isfinite(features).all()
    full_turn = traces.copy()
    full_turn[:, :, 0] += 2.0 * np.pi
    changed = np.abs(hand_path_features(full_turn, goals) - features) > 1e-4
    assert changed[0].sum() == KNOTS + 16  # the angles themselves; sines and cosines stay


@pytest.mark.parametrize("wrong", [{"dim": 1}, {"memory": "both maps"}, {"rate": 0}, {"hard": -1}])
def test_a_wrong_configuration_is_refused(wrong):
    assert next(iter(wrong)) in refusal(EncoderError, EncoderConfig, **wrong)
