"""Arrays and torch agree; what is stored is what was learned; another's files are refused."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("torch")
pytest.importorskip("safetensors")

import torch

from gcm_learn import seeding
from gcm_learn.errors import EncoderError
from gcm_learn.families.random_planar import random_planar
from gcm_learn.recall import EncoderConfig, load_encoder, save_encoder
from gcm_learn.recall.encoder import Encoder
from gcm_learn.recall.features import batched, count, hand_path_features, planar_map_features
from gcm_learn.recall.hand_features import CELLS, CONTEXT, clearance_features
from gcm_learn.recall.networks import EncoderNet, Inputs

KNOTS, MAP = 24, 965


def network(memory="both", seed=0):
    """A network with weights at random, rounded to what is stored."""
    torch.manual_seed(seed)
    net = EncoderNet(
        EncoderConfig(dim=6, width=20, memory=memory), Inputs(CONTEXT, CELLS, count(KNOTS), MAP)
    )
    rng = seeding.rng(seed)
    for tower in (net.situation, net.body, net.trace, net.map):
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
    pictures = np.array([planar_map_features(s) for s in situations])
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


@pytest.mark.parametrize(
    ("name", "content", "complaint"),
    [
        ("config.json", None, "config.json is missing"),
        ("config.json", "{}", "format: is None"),
        ("encoder.safetensors", "nothing", "damaged"),
    ],
)
def test_other_files_are_refused_in_one_line(tmp_path, name, content, complaint):
    net = network()
    save_encoder(Encoder(net.config, net.arrays()), tmp_path)
    if content is None:
        (tmp_path / name).unlink()
    else:
        (tmp_path / name).write_text(content)
    with pytest.raises(EncoderError, match=complaint) as caught:
        load_encoder(tmp_path)
    assert "\n" not in str(caught.value)


def test_maps_tell_apart_unreached_and_reached_at_once(situations):
    """A cell without arrival has the number 0, like the start, and a field that says so."""
    for situation in situations:
        picture = planar_map_features(situation)
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


def test_a_wrong_configuration_is_refused():
    for wrong in ({"dim": 1}, {"memory": "both maps"}, {"rate": 0.0}, {"hard": -1.0}):
        with pytest.raises(EncoderError, match=next(iter(wrong))):
            EncoderConfig(**wrong)
