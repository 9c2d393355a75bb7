"""Labels tell the truth, keep held-out situations out, and make a model on the command line."""

import json
import re
from dataclasses import replace
from functools import partial

import numpy as np
import pytest

pytest.importorskip("torch")
pytest.importorskip("safetensors")
pytest.importorskip("pyarrow")

from gcm_learn import dataset, recall
from gcm_learn.cli import main
from gcm_learn.processes import crew_of
from gcm_learn.recall.hand_features import clearance_features
from gcm_learn.recall.index import LearnedIndex
from gcm_learn.recall.transfer_labels import Sizes, TransferLabels


@pytest.fixture
def small(monkeypatch):
    """Labels of few situations, for the command line as well."""
    labels = partial(TransferLabels, sizes=Sizes(40, 10, 4, 2))
    monkeypatch.setattr(recall, "TransferLabels", labels, raising=False)
    return labels


def test_labels_are_what_comes_of_trying(small_folder, small):
    source = small(dataset.open(small_folder), 3)
    batch = source.labels(0, None)
    own = source._order[:40]
    again = small(dataset.open(small_folder), 3).labels(0, None)
    np.testing.assert_array_equal(batch.valid, again.valid)  # a function of seed and number
    for i, k in enumerate(own[:5].tolist()):
        situation = source.situations[k]
        np.testing.assert_array_equal(
            batch.features.context[i], clearance_features(situation).context
        )
        times = recall.transfer(situation, source.knots, source.goals, batch.rows)
        np.testing.assert_array_equal(batch.valid[i], times >= 0.0)
        if batch.own[i] >= 0:
            assert batch.rows[batch.own[i]] == k
    assert len(batch.valid) > len(own)  # drawn ones, and some with one obstacle alone


def test_labels_about_the_best_ask_about_these_and_never_about_ones_own(small_folder, small):
    source = small(dataset.open(small_folder), 3)
    everything = np.arange(len(source.knots))
    batch = source.labels(
        0, lambda features, k: np.tile(everything[:k], (len(features.context), 1))
    )
    assert batch.rows.shape == (len(batch.valid), 6)
    for i, k in enumerate(source._order[:40].tolist()):
        assert k not in batch.rows[i]
        assert set(batch.rows[i, :4]) <= set(range(5))
    assert (batch.own == -1).all()


def test_no_label_is_about_what_is_held_out(small_folder, small, monkeypatch):
    labels = small(dataset.open(small_folder), 4)
    seen = []
    monkeypatch.setattr(
        TransferLabels, "_is_held_out", lambda self, family, problem: seen.append(family) or True
    )
    source = labels._drawn(0, np.random.default_rng(0))
    unasked = replace(labels.kind, straight=None)  # never asked of what is held out
    monkeypatch.setattr(labels, "kind", unasked)
    monkeypatch.setattr(labels, "spec", _Stops(labels.spec, 25))
    with pytest.raises(LookupError):
        next(source)
    assert seen


class _Stops:
    """A specification that is drawn from so often and no more."""

    def __init__(self, spec, count):
        self.spec, self.count = spec, count

    def choose(self, rng):
        self.count -= 1
        if self.count < 0:
            raise LookupError
        return self.spec.choose(rng)


@pytest.mark.slow
def test_a_cluster_makes_the_same_encoder(small_folder, small, scheduler, tmp_path, monkeypatch):
    """By its labels of all kinds: the first about any memories, later ones about the best."""
    monkeypatch.setattr(recall.transfer_labels, "READ", 7)
    monkeypatch.setattr(recall.transfer_labels, "TRIED", 9)
    options = ["--turns", "8", "--dim", "4", "--memory", "both"]
    given = ["train", "encoder", small_folder, *options, "--out"]
    for name, more in (("here", []), ("there", ["--cluster", scheduler])):
        assert main([*given, str(tmp_path / name), *more]) == 0
    for file in ("encoder.safetensors", "log.jsonl"):
        here, there = ((tmp_path / name / file).read_text("latin-1") for name in ("here", "there"))
        seconds = re.compile('"seconds": [0-9.]+')
        assert seconds.sub("", here) == seconds.sub("", there)
    kinds = [line for line in here.splitlines() if "binary" in line]
    assert len(kinds) == 8


@pytest.mark.slow
def test_a_training_that_a_cluster_left_goes_on_here(small_folder, small, scheduler, tmp_path):
    """Labels are kept with the checkpoint, whoever made them."""
    config, effort = recall.EncoderConfig(dim=4), recall.Effort(turns=4)
    records = dataset.open(small_folder)
    with crew_of(cluster=scheduler) as crew:
        first = recall.Trainer(config, small(records, crew=crew), tmp_path / "two", effort)

        def stop(share):
            if first.turn == 2:
                first.save()
                raise KeyboardInterrupt

        with pytest.raises(KeyboardInterrupt):
            first.run(stop)
    second = recall.Trainer(config, small(records), tmp_path / "two", effort)
    whole = recall.Trainer(config, small(records), tmp_path / "one", effort)
    assert second.turn == 2 and second.run().key == whole.run().key


def test_a_model_on_the_command_line(small_folder, small, tmp_path, capsys):
    out = tmp_path / "model"
    train = ["train", "encoder", small_folder, "--out", str(out)]
    assert main([*train, "--turns", "2", "--dim", "4"]) == 0
    encoder = recall.load_encoder(out)
    assert f"key {encoder.key}" in capsys.readouterr().out
    about = json.loads((out / "metrics.json").read_text())
    assert about["key"] == encoder.key and about["lessons"] == 2
    card = (out / "card.md").read_text()
    assert "train encoder" in card and about["dataset"]["hash"] in card
    assert not (out / "work.tmp").exists()
    memory = tmp_path / "memory"
    assert main(["memory", "make", small_folder, "--out", str(memory), "--index", str(out)]) == 0
    assert recall.Memory.load(memory).index.key == LearnedIndex(encoder).key
    assert main([*train, "--turns", "0"]) == 2
    assert "--turns 0" in capsys.readouterr().err
