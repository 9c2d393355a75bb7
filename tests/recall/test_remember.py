"""Memories made of datasets, on the command line too."""

import json
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("pyarrow")

from gcm_learn import dataset
from gcm_learn.cli import main
from gcm_learn.errors import RecallError
from gcm_learn.recall import LearnedIndex, Memory, RecallPlanner, growth
from gcm_learn.recall.growth import remember

ROOT = Path(__file__).parents[2]


def test_all_catches_are_remembered_and_recalled(small_folder):
    records = dataset.open(small_folder)
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


def test_a_part_and_another_planner(small_folder):
    records = dataset.open(small_folder)
    assert len(remember(records, most=5, seed=2)) <= 5
    one = remember(records, "random", "marching")
    assert len(one) == sum(record.plans["marching"].caught for record in records)
    with pytest.raises(RecallError, match="'gcm' has no plans in the dataset"):
        remember(records, planner="gcm")


@pytest.mark.slow
def test_a_dataset_of_an_arm_file_makes_a_memory_of_this_arm(tmp_path, capsys):
    model = json.loads((ROOT / "gcm_learn" / "arms" / "models" / "ur5.json").read_text())
    arm, memory, scenes = (tmp_path / name for name in ("mine.json", "memory", "scenes.jsonl"))
    arm.write_text(json.dumps(model | {"name": "mine"}))
    (tmp_path / "spec.toml").write_text(
        'format = "gcm-learn/dataset-spec@1"\nname = "own"\nseed = 1\ncount = 12\nmap = "none"\n'
        'planners = ["search"]\narm = "mine.json"\n[[families]]\nfamily = "throw-chain"\n'
    )
    data = str(tmp_path / "data")
    assert main(["generate", str(tmp_path / "spec.toml"), "--out", data, "--workers", "1"]) == 0
    arm.unlink()  # its text is part of the dataset
    assert dataset.open(data)[0].situation.arm.model.name == "mine"
    assert main(["memory", "make", data, "--out", str(memory), "--split", "all"]) == 0
    arm.write_text(json.dumps(model | {"name": "mine"}))
    draw = ["draw", "throw-chain", "--arm", str(arm), "--count", "3", "--out", str(scenes)]
    assert main(draw) == 0
    capsys.readouterr()
    for planner in ("recall", "hybrid"):
        assert main(["solve", str(scenes), "--planner", planner, "--memory", str(memory)]) == 0
        answers = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
        assert [one["planner"] for one in answers] == [planner] * 3
    assert any(one["status"] == "caught" for one in answers)


def test_on_the_command_line(small_folder, tmp_path, capsys):
    out = tmp_path / "memory"
    made = ["memory", "make", small_folder, "--split", "all", "--out"]
    assert main([*made, str(out), "--index", "raw"]) == 0
    said = capsys.readouterr().out
    memory = Memory.load(out)
    assert f"{len(memory)} memories of 50 records" in said and memory.index.key in said
    again = tmp_path / "again"
    assert main([*made, str(again)]) == 0
    assert np.array_equal(Memory.load(again).embeddings, memory.embeddings)


def test_catches_of_a_dataset_and_of_a_memory_are_embedded(small_folder, tmp_path, capsys):
    pytest.importorskip("safetensors")
    raw = remember(dataset.open(small_folder), "raw")
    raw.save(tmp_path / "memory")
    wanted = raw.refiled(LearnedIndex.load(Path("models/encoder")))
    for source in (small_folder, tmp_path / "memory"):
        out = tmp_path / "embedded.npz"
        assert main(["memory", "embed", str(source), "--split", "all", "--out", str(out)]) == 0
        assert f"{len(wanted)} embeddings of 32 numbers" in capsys.readouterr().out
        with np.load(out) as file:
            np.testing.assert_array_equal(file["embeddings"], wanted.embeddings)
            assert file["families"].tolist() == raw.families
            assert file["strata"].tolist() == raw.strata


def test_a_cluster_makes_the_same_memory(small_folder, scheduler, tmp_path, monkeypatch):
    monkeypatch.setattr(growth, "CHUNK", 6)
    for index in ("raw", "models/encoder"):
        given = ["memory", "make", small_folder, "--split", "all", "--index", index, "--out"]
        files = []
        for name, more in (("here", []), ("there", ["--cluster", scheduler])):
            assert main([*given, str(tmp_path / name), *more]) == 0
            (data,) = (tmp_path / name).glob("data-*")
            files.append({path.name: path.read_bytes() for path in data.iterdir()})
            files[-1]["words"] = json.loads((tmp_path / name / "manifest.json").read_text())[
                "words"
            ]
        assert files[0] == files[1] and len(files[0]) > 6


BAD = [
    (["--index", "best"], "index: 'best' is not one of raw, random, pca, learned"),
    (["--most", "0"], "--most 0: must be at least 1"),
    (["--seed", "-1"], "--seed -1: must be at least 0"),
    (["--planner", "gmc"], "planner: 'gmc' has no plans"),
    (["--split", "tset"], "--split: 'tset' is not one of"),
    (["--split", "nowhere"], "all"),
]


def test_bad_arguments_are_refused_in_one_line(small_folder, tmp_path, capsys):
    for arguments, complaint in BAD:
        command = ["memory", "make", small_folder, "--out", str(tmp_path / "memory")]
        assert main([*command, *arguments]) == 2
        said = capsys.readouterr().err
        assert complaint in said and said.count("\n") == 1
    assert not (tmp_path / "memory").exists()
