"""What methods are made of."""

from __future__ import annotations

import json

import pytest

from gcm_learn.artifacts import shipped
from gcm_learn.evaluation import costs as module
from gcm_learn.evaluation.costs import costs_of
from gcm_learn.policies.planner import shipped_actor
from gcm_learn.recall import shipped_memory


def test_methods_share_what_they_hold():
    found = costs_of(["layered", "clone", "recall", "clone@20", "hybrid", "straight"])
    assert [cost.methods for cost in found] == [("clone", "clone@20"), ("recall", "hybrid")]


def test_a_memory():
    (cost,) = costs_of(["recall"])
    memory = shipped_memory("recall")
    assert cost.memories == len(memory) and cost.weights is None and cost.steps is None
    files = [p for p in (shipped("models") / "recall").rglob("*") if p.suffix != ".json"]
    assert cost.size == pytest.approx(sum(p.stat().st_size for p in files), rel=1e-3)
    encoder = json.loads((shipped("models") / "encoder" / "metrics.json").read_text())
    assert cost.minutes == encoder["seconds"] / 60 and cost.situations == encoder["memories"]


def test_an_actor():
    (cost,) = costs_of(["ppo-clone"])
    layers = shipped_actor("ppo-clone").layers
    assert cost.weights == sum(w.size + b.size for w, b in layers)
    config = json.loads((shipped("models") / "ppo-clone" / "config.json").read_text())
    assert cost.start == "clone"
    assert cost.situations == sum(share["count"] for share in config["situations"])
    assert cost.steps == max(row["steps"] for row in module.log_of("ppo-clone"))
