"""``gcm-learn example``: files to begin with, which other commands take."""

from __future__ import annotations

import pytest

from gcm_learn import artifacts
from gcm_learn.cli import main
from gcm_learn.cli.example import PLACES


def test_all_are_listed_by_names_of_their_own(capsys):
    assert main(["example"]) == 0
    listed = capsys.readouterr().out
    paths = [path for pattern in PLACES.values() for path in artifacts.source().glob(pattern)]
    assert all(path.name in listed for path in paths)
    assert len({path.name for path in paths}) == len({path.stem for path in paths}) == len(paths)


def test_one_is_copied_once(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(["example", "ppo"]) == 0
    assert capsys.readouterr().out == "ppo.yml\n"
    original = artifacts.source() / "experiments" / "04_policies" / "ppo.yml"
    assert (tmp_path / "ppo.yml").read_bytes() == original.read_bytes()
    assert main(["example", "ppo.yml"]) == 2
    assert capsys.readouterr().err == "gcm-learn: --out ppo.yml: is there already\n"
    assert main(["example", "ppo.yml", "--out", "no/where.yml"]) == 2
    assert capsys.readouterr().err.startswith("gcm-learn: --out no/where.yml: No such file")
    assert main(["example", "pppo.yml"]) == 2
    assert "did you mean 'ppo.yml'?" in capsys.readouterr().err


def test_the_sample_is_copied_whole(tmp_path):
    dataset = pytest.importorskip("gcm_learn.dataset")
    assert main(["example", "sample", "--out", str(tmp_path / "mine")]) == 0
    assert len(dataset.open(tmp_path / "mine")) == 500


def test_what_help_names_is_an_example(capsys):
    helped = {"train-policy": ["ppo.yml"], "generate": ["train.toml", "README.md"]}
    for command, names in helped.items():
        assert main([command, "--help"]) == 0
        said = " ".join(capsys.readouterr().out.replace("│", " ").split())
        assert all(f"gcm-learn example {name}" in said for name in names)
