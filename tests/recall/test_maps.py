"""Maps as keys: their features, their embeddings, and the planner that recalls by them."""

from dataclasses import replace

import numpy as np
import pytest

pytest.importorskip("torch")
pytest.importorskip("safetensors")
pytest.importorskip("pyarrow")

from gcm_learn import artifacts, build_map, dataset, families, recall, seeding, solve
from gcm_learn.cli import main
from gcm_learn.errors import EncoderError, RecallError
from gcm_learn.families.random_planar import random_planar
from gcm_learn.planners import get_planner
from gcm_learn.recall.embedding import KEYS
from gcm_learn.recall.map_features import planar_map, planar_map_features
from gcm_learn.recall.training import Effort, Trainer
from gcm_learn.wave import MarchingParams, WaveParams
from tests.recall.test_planners import turned
from tests.recall.test_training import CONFIG, MAP, MEMORIES, Toy, network


def encoder_of(memory, seed=0):
    """An encoder with weights at random."""
    net = network(memory, seed)
    return recall.Encoder(net.config, net.arrays())


@pytest.fixture
def models(memory, tmp_path, monkeypatch):
    """A folder of models with a small memory and an encoder of maps."""
    memory.forget(np.arange(30, len(memory)))
    memory.save(tmp_path / "recall")
    recall.save_encoder(encoder_of("map"), tmp_path / "encoder-map")
    monkeypatch.setattr(artifacts, "folders", lambda kind: [tmp_path])
    recall.planners._memory.cache_clear()
    yield tmp_path
    recall.planners._memory.cache_clear()


def test_features_depend_on_neither_frame_nor_side_nor_size_of_cells():
    away = []
    for k in range(12):
        situation, params = random_planar(seeding.rng(92, k)), MarchingParams(n=80, margin=0.0)
        other = turned(situation, 0.7)
        maps = *(build_map(s, params, wait=True) for s in (situation, other)), planar_map(situation)
        mine, *others = map(planar_map_features, maps)
        assert mine.shape == (MAP,) and np.isfinite(mine).all()
        away.append([np.mean(np.abs(mine - yours) > 0.1) for yours in others])
    assert (np.median(away, axis=0) < (0.04, 0.08)).all()


def test_stored_maps_find_themselves_in_whatever_way_they_were_made():
    situations = [families.draw("crossing-swarm", 7, k) for k in range(12)]
    encoder = encoder_of("map")
    places = recall.embed((planar_map(s) for s in situations), encoder)
    assert places.shape == (12, 6) and places.dtype == np.float32
    for k, situation in enumerate(situations):
        place = recall.embed(planar_map(situation), encoder)
        np.testing.assert_allclose(place, places[k], atol=1e-5)
        found = recall.nearest(place, places, 3)
        assert found[0] == k and len(set(found.tolist())) == 3
    drawn = recall.embed(build_map(situations[0], WaveParams(n=80)), encoder)
    assert drawn.shape == (6,)


def test_other_maps_and_encoders_are_refused_in_one_line(models):
    with pytest.raises(RecallError, match="maps: must be at least one"):
        recall.embed([])
    with pytest.raises(EncoderError, match="by their paths, not by maps"):
        recall.embed(
            planar_map(random_planar(seeding.rng(1))), recall.load_encoder("models/encoder")
        )


@pytest.mark.slow  # compiles a march for chains
def test_maps_of_other_arms_are_refused_in_one_line(models):
    space = families.draw("conveyor-chain", 1, 0)
    coarse = build_map(space, MarchingParams(n=16, margin=0.0))
    with pytest.raises(EncoderError, match="of planar arms, the map of chains"):
        recall.embed(coarse, recall.load_encoder(recall.map_encoder()))
    with pytest.raises(RecallError, match="gcm-learn train encoder DATASET --memory map"):
        recall.embed(coarse)


def test_the_maps_of_a_dataset_are_embedded_as_it_holds_them(small_folder, models, capsys):
    out = models / "maps.npz"
    given = ["memory", "embed", small_folder, "--split", "all", "--encoder", "encoder-map"]
    assert main([*given, "--out", str(out)]) == 0
    records = [record for record in dataset.open(small_folder) if record.map is not None]
    assert f"{len(records)} embeddings of 6 numbers" in capsys.readouterr().out
    with np.load(out) as file:
        np.testing.assert_allclose(
            file["embeddings"], recall.embed(r.map for r in records), atol=1e-6
        )
        assert file["index"].tolist() == [r.index for r in records]
        assert file["families"].tolist() == [r.family for r in records]


def test_memories_are_recalled_by_their_maps(models, catches):
    recalling = get_planner("recall-map").planner
    assert recalling.memory.index.key == recall.load_encoder(models / "encoder-map").key
    kept = recall.shipped_memory("recall")
    wanted = recall.embed(
        map(planar_map, kept.situations()), recall.load_encoder(models / "encoder-map")
    )
    np.testing.assert_allclose(recalling.memory.embeddings, wanted, atol=1e-5)
    plans = [solve(situation, "recall-map") for situation, _ in catches[:8]]
    assert sum(plan.caught for plan in plans) > 4
    assert {plan.planner for plan in plans} == {"recall-map"}
    assert recall.with_memory("recall-map", kept).memory.index.key == recalling.memory.index.key


def test_stored_keys_are_taken_if_they_are_of_this_memory_and_encoder(models, monkeypatch):
    source, keys = str(models / "recall"), models / "encoder-map" / KEYS
    assert main(["memory", "embed", source, "--encoder", "encoder-map", "--out", str(keys)]) == 0
    wanted = recall.shipped_memory("recall-map").embeddings
    monkeypatch.setattr(
        recall.LearnedIndex, "embed_memories", lambda *given: pytest.fail("made anew")
    )
    np.testing.assert_array_equal(recall.shipped_memory("recall-map").embeddings, wanted)
    monkeypatch.undo()
    monkeypatch.setattr(artifacts, "folders", lambda kind: [models])
    recall.save_encoder(encoder_of("map", 1), models / "encoder-map")
    assert not np.allclose(recall.shipped_memory("recall-map").embeddings, wanted)


def test_maps_learn_the_places_of_paths(tmp_path):
    toy = Toy()
    teacher = Trainer(CONFIG, toy, tmp_path / "paths", Effort(turns=2)).run()
    toy.map_features = np.zeros((MEMORIES, 4), np.float32)
    toy.map_features[:, 1] = toy.place
    pupil = Trainer(replace(CONFIG, memory="map"), toy, tmp_path / "maps", Effort(turns=2), teacher)
    wanted = teacher.embed_paths(toy.path_features)
    found = pupil.encoder._memory["map"](toy.map_features)
    assert np.square(found - wanted).mean() < 0.1 * wanted.var(axis=0).mean()
