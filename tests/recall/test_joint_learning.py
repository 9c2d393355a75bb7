"""What encoders are told of spatial arms, and that they learn from it on the command line."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np
import pytest

pytest.importorskip("torch")
pytest.importorskip("safetensors")
pytest.importorskip("pyarrow")

from gcm_learn import dataset, families, recall
from gcm_learn.arms import SPATIAL
from gcm_learn.cli import main
from gcm_learn.dataset import DatasetSpec, FamilyShare, Split
from gcm_learn.errors import EncoderError
from gcm_learn.recall import EncoderConfig, Memory, Sizes, TransferLabels, load_encoder
from gcm_learn.recall.features import TOUCH
from gcm_learn.recall.joint_features import CELLS, CONTEXT, FREE, posture_features
from gcm_learn.recall.kinds import MEMORIES
from gcm_learn.recall.path_features import JOINT_COUNT, joint_path_features
from gcm_learn.situation import Body, SolidQuadratic, Sphere, canonical
from tests.recall.test_joint_recall import mirrored

MOVEMENTS = MEMORIES.of(SPATIAL)
NAMES = ("window-space", "late-target-space")
SPEC = DatasetSpec(
    "space",
    11,
    36,
    tuple(FamilyShare(name) for name in NAMES),
    ("straight", "layered"),
    map="none",
    shard_size=12,
    split=Split(validation=0.2, test=0.1),
)


def ball(place, radius=0.05):
    """A ball at rest."""
    still = SolidQuadratic(tuple(float(v) for v in place), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    return Body("obstacle", f"ball at {place[0]:.2f}", Sphere(radius), still)


@pytest.mark.parametrize("k", range(6))
def test_a_mirrored_situation_looks_the_same(k):
    situation = canonical(families.draw(NAMES[k % 2], 31, k))[0]
    mine, other = posture_features(situation), posture_features(mirrored(situation))
    assert mine.context.shape == (CONTEXT,) and mine.cells.shape[1] == CELLS
    assert np.allclose(mine.context, other.context, atol=1e-5)
    assert np.allclose(mine.cells, other.cells, atol=1e-5)


def test_each_obstacle_is_seen_alone_and_those_far_away_are_not():
    situation = canonical(families.draw(NAMES[0], 32, 1))[0]
    reach = situation.arm.reach
    near = ball((0.5 * reach, 0.1, 0.3 * reach), 0.05 * reach)
    far = ball(((2.0 + FREE) * reach, 0.0, 0.0), 0.05 * reach)
    alone = posture_features(replace(situation, bodies=(*situation.targets, near))).cells
    both = posture_features(replace(situation, bodies=(*situation.targets, far, near))).cells
    assert len(alone) == 1 and np.array_equal(alone, both)
    assert 0.0 < alone.max() <= TOUCH and (alone == 0.0).any()
    more = posture_features(replace(situation, bodies=(*situation.bodies, near))).cells
    assert np.array_equal(more[-1], alone[0])


def test_paths_are_told_apart_by_ends_ways_and_waits():
    rng = np.random.default_rng(3)
    knots = rng.uniform(0.1, 1.0, (1, *MOVEMENTS.knots)).astype(np.float32).repeat(4, axis=0)
    goals = rng.uniform(-1.0, 1.0, (1, MOVEMENTS.goal)).astype(np.float32).repeat(4, axis=0)
    knots[1, 5, 5] += 0.5
    knots[2, 6, 2] += 0.5
    goals[3, 0] += 0.1
    told = joint_path_features(knots, goals)
    assert told.shape == (4, JOINT_COUNT) and np.isfinite(told).all()
    assert len(np.unique(told, axis=0)) == 4
    still = np.zeros((1, *MOVEMENTS.knots), np.float32)
    assert np.isfinite(joint_path_features(still, goals[:1])).all()
    assert joint_path_features(knots[:0], goals[:0]).shape == (0, JOINT_COUNT)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A dataset of a few records."""
    place = tmp_path_factory.mktemp("space")
    dataset.generate(SPEC, place, workers=1)
    return place


@pytest.fixture
def small(monkeypatch):
    """Labels of few situations, for the command line as well."""
    labels = partial(TransferLabels, sizes=Sizes(24, 10, 4, 2))
    monkeypatch.setattr(recall, "TransferLabels", labels, raising=False)
    return labels


def test_labels_are_what_comes_of_trying(folder, small):
    source = small(dataset.open(folder), 3)
    batch = source.labels(0, None)
    assert batch.valid.any() and not batch.valid.all()
    again = small(dataset.open(folder), 3).labels(0, None)
    assert np.array_equal(batch.valid, again.valid)
    own = batch.own >= 0
    assert batch.valid[own, batch.own[own]].mean() > 0.6  # most are valid where they come from


def test_train_and_remember_on_the_command_line(folder, small, tmp_path, capsys):
    model, memory = tmp_path / "encoder", tmp_path / "recall-space"
    words = ["--turns", "2", "--dim", "8", "--seed", "5"]
    assert main(["train-encoder", str(folder), "--out", str(model), *words]) == 0
    assert "spatial" in (model / "card.md").read_text("utf-8")
    encoder = load_encoder(model)
    assert encoder.kind == SPATIAL and encoder.dim == 8
    assert main(["remember", str(folder), "--out", str(memory), "--index", str(model)]) == 0
    loaded = Memory.load(memory)
    assert loaded.kind == SPATIAL and loaded.index.key == encoder.key and len(loaded) > 5
    situation = families.draw(NAMES[0], 33, 0)
    query = loaded.index.embed_query(situation)
    seen = posture_features(situation)
    assert np.array_equal(query, encoder.embed_features(seen)) and query.shape == (8,)
    capsys.readouterr()


def test_memories_in_space_have_no_maps():
    with pytest.raises(EncoderError, match="'map' needs maps, which are of the plane"):
        EncoderConfig(memory="map", arm="spatial")
    with pytest.raises(EncoderError, match="arm: must be one of planar, spatial"):
        EncoderConfig(arm="other")
