"""Memories made of datasets, on the command line too."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

pytest.importorskip("pyarrow")

from gcm_learn import dataset
from gcm_learn.cli import main
from gcm_learn.errors import RecallError
from gcm_learn.recall import Memory, RecallPlanner, growth
from gcm_learn.recall.growth import remember
from tests.dataset.conftest import SMALL, make_here


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A dataset of 20 records."""
    place = str(tmp_path_factory.mktemp("small"))
    make_here(replace(SMALL, count=20), place)
    return place


def test_all_catches_are_remembered_and_recalled(folder):
    records = dataset.open(folder)
    memory = remember(records)
    best = [
        min(
            (p for p in record.plans.values() if p.caught), key=lambda p: p.catch_time, default=None
        )
        for record in records
    ]
    caught = [(record, plan) for record, plan in zip(records, best, strict=True) if plan]
    assert 0 < len(memory) == len(caught)
    np.testing.assert_allclose(
        memory.knots[:, -1, 2], [plan.catch_time for _, plan in caught], rtol=1e-6
    )
    for k, (record, _) in enumerate(caught):
        assert memory[k].situation == record.situation
        assert (memory[k].family, memory[k].stratum) == (record.family, record.stratum)
    assert RecallPlanner(memory).plan(caught[0][0].situation).caught


def test_a_part_and_another_planner(folder):
    records = dataset.open(folder)
    assert len(remember(records, most=5, seed=2)) <= 5
    one = remember(records, "random", "marching")
    assert len(one) == sum(record.plans["marching"].caught for record in records)
    with pytest.raises(RecallError, match="'gcm' has no plans in the dataset"):
        remember(records, planner="gcm")


def test_on_the_command_line(folder, tmp_path, capsys):
    out = tmp_path / "memory"
    assert main(["remember", folder, "--out", str(out), "--split", "all", "--index", "raw"]) == 0
    said = capsys.readouterr().out
    memory = Memory.load(out)
    assert f"{len(memory)} memories of 20 records" in said and memory.index.key in said
    again = tmp_path / "again"
    assert main(["remember", folder, "--out", str(again), "--split", "all"]) == 0
    assert np.array_equal(Memory.load(again).embeddings, memory.embeddings)


def test_a_cluster_makes_the_same_memory(folder, scheduler, tmp_path, monkeypatch):
    monkeypatch.setattr(growth, "CHUNK", 6)
    for index in ("raw", "models/encoder"):
        given = ["remember", folder, "--split", "all", "--index", index, "--out"]
        files = []
        for name, more in (("here", []), ("there", ["--cluster", scheduler])):
            assert main([*given, str(tmp_path / name), *more]) == 0
            (data,) = (tmp_path / name).glob("data-*")
            files.append({path.name: path.read_bytes() for path in data.iterdir()})
            files[-1]["words"] = json.loads((tmp_path / name / "manifest.json").read_text())[
                "words"
            ]
        assert files[0] == files[1] and len(files[0]) > 6


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        (["--index", "best"], "index: 'best' is not one of raw, change, random, pca, learned"),
        (["--most", "0"], "--most 0: must be at least 1"),
        (["--seed", "-1"], "--seed -1: must not be negative"),
        (["--planner", "gmc"], "planner: 'gmc' has no plans"),
        (["--split", "tset"], "--split: 'tset' is not one of"),
        (["--split", "nowhere"], "all"),
    ],
)
def test_bad_arguments_are_refused_in_one_line(folder, tmp_path, capsys, arguments, complaint):
    assert main(["remember", folder, "--out", str(tmp_path / "memory"), *arguments]) == 2
    said = capsys.readouterr().err
    assert complaint in said and said.count("\n") == 1
    assert not (tmp_path / "memory").exists()
