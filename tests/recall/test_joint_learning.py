"""Features that encoders see of arms in joints, and learning from them on the command line."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
import pytest

from tests.refusals import refusal
from tests.worlds import solid_ball

pytest.importorskip("torch")
pytest.importorskip("safetensors")
pytest.importorskip("pyarrow")

from gcm_learn import dataset, families, recall, seeding
from gcm_learn.arms import CHAIN, SPATIAL, Kind
from gcm_learn.cli import main
from gcm_learn.dataset import DatasetSpec, FamilyShare, Split
from gcm_learn.errors import EncoderError, RecallError
from gcm_learn.families import family_from_dict
from gcm_learn.recall import EncoderConfig, Memory, RecallPlanner, Sizes, TransferLabels
from gcm_learn.recall.encoder import load_encoder
from gcm_learn.recall.features import TOUCH, joint_count, joint_path_features
from gcm_learn.recall.joint_features import CELLS, FREE, posture_features
from gcm_learn.recall.kinds import MEMORIES
from gcm_learn.recall.map_features import coarse_map, joint_map_features
from gcm_learn.recall.waypoints import GOAL
from gcm_learn.situation import canonical
from tests.recall.test_chain_recall import turned
from tests.recall.test_joint_recall import mirrored


def seen_in_a_mirror(situation):
    """A canonical situation and the same in a mirror."""
    return situation, mirrored(situation)


def seen_from_aside(situation):
    """A situation whose first joint turns freely, and the same turned; `low` and `high` differ."""
    model = situation.arm.model
    joints = (replace(model.joints[0], range=(-12.0, 12.0)), *model.joints[1:])
    arm = replace(situation.arm, model=replace(model, joints=joints))
    free = replace(situation, arm=arm)
    return free, turned(free, 1.1)


@dataclass(frozen=True)
class Case:
    """A kind of arm in the tests."""

    kind: Kind
    joints: int
    names: tuple[str, str]
    planners: tuple[str, ...]
    alike: Callable[[Any], tuple[Any, Any]]
    differs: tuple[int, ...]
    """Numbers of a context that differ between two situations that look the same."""

    def spec(self, **more):
        """A dataset of a few records."""
        shares = tuple(FamilyShare(name) for name in self.names)
        split = Split(validation=0.2, test=0.1)
        given = {"map": "none", "shard_size": 12, "split": split} | more
        return DatasetSpec(self.kind.name, 11, 36, shares, self.planners, **given)


CASES = {
    "spatial": Case(
        SPATIAL, 4, ("window-space", "late-target-space"), ("straight", "search"),
        seen_in_a_mirror, (),
    ),
    "chain": Case(
        CHAIN, 7, ("swarm-chain", "handover-chain"), ("straight", "search"),
        seen_from_aside, (50 + 14, 50 + 21),
    ),
}  # fmt: skip


SLOW = pytest.mark.slow  # compiles recall for spatial arms


@pytest.fixture(scope="module", params=["chain", pytest.param("spatial", marks=SLOW)])
def case(request):
    """Each kind of arm in joints."""
    return CASES[request.param]


@pytest.mark.parametrize("k", range(6))
def test_a_turn_or_a_mirror_changes_nothing(case, k):
    situation = canonical(families.draw(case.names[k % 2], 31, k))[0]
    mine, other = (posture_features(one) for one in case.alike(situation))
    assert mine.cells.shape[1] == CELLS
    assert np.allclose(mine.cells, other.cells, atol=1e-5)
    same = ~np.isin(np.arange(mine.context.size), case.differs)
    assert np.allclose(mine.context[same], other.context[same], atol=1e-5)
    assert (mine.context[~same] != other.context[~same]).all()


def test_each_obstacle_is_seen_alone_and_those_far_away_are_not(case):
    situation = canonical(families.draw(case.names[0], 32, 1))[0]
    reach = situation.arm.reach
    near = solid_ball("near", (0.5 * reach, 0.1, 0.3 * reach), radius=0.05 * reach)
    far = solid_ball("far", ((2.0 + FREE) * reach, 0.0, 0.0), radius=0.05 * reach)
    alone = posture_features(replace(situation, bodies=(*situation.targets, near))).cells
    both = posture_features(replace(situation, bodies=(*situation.targets, far, near))).cells
    assert len(alone) == 1 and np.array_equal(alone, both)
    assert 0.0 < alone.max() <= TOUCH and (alone == 0.0).any()
    more = posture_features(replace(situation, bodies=(*situation.bodies, near))).cells
    assert np.array_equal(more[-1], alone[0])


def test_the_approach_of_a_chain_is_seen():
    drawn = (families.draw("handover-chain", 34, k) for k in range(40))
    situation = next(s for s in drawn if s.targets[0].approach)
    target = situation.targets[0]
    without = replace(situation, bodies=(replace(target, approach=()), *situation.obstacles))
    mine, other = posture_features(situation).context[-32:], posture_features(without).context[-32:]
    assert np.allclose(np.linalg.norm(mine[:30].reshape(10, 3), axis=1), 1.0, atol=1e-6)
    assert mine[30] == 1.0 and mine[31] == pytest.approx(math.cos(target.approach[0].within))
    assert not other.any()


def test_paths_are_told_apart_by_ends_ways_and_waits(case):
    rng, shape = np.random.default_rng(3), (1, MEMORIES.of(case.kind).knots[0], case.joints + 2)
    knots = rng.uniform(0.1, 1.0, shape).astype(np.float32).repeat(4, axis=0)
    goals = rng.uniform(-1.0, 1.0, (1, GOAL)).astype(np.float32).repeat(4, axis=0)
    knots[1, 5, -1] += 0.5
    knots[2, 6, case.joints - 1] += 0.5
    goals[3, 0] += 0.1
    found = joint_path_features(knots, goals)
    assert found.shape == (4, joint_count(case.joints)) and np.isfinite(found).all()
    assert len(np.unique(found, axis=0)) == 4
    still = np.zeros(shape, np.float32)
    assert np.isfinite(joint_path_features(still, goals[:1])).all()
    assert joint_path_features(knots[:0], goals[:0]).shape == (0, joint_count(case.joints))


@pytest.fixture(scope="module")
def folder(case, tmp_path_factory):
    """A dataset of a few records."""
    place = tmp_path_factory.mktemp(case.kind.name)
    dataset.generate(case.spec(), place, workers=1)
    return place


@pytest.fixture
def small(monkeypatch):
    """Labels of few situations, for the command line as well."""
    labels = partial(TransferLabels, sizes=Sizes(24, 10, 4, 2))
    monkeypatch.setattr(recall, "TransferLabels", labels, raising=False)
    return labels


@pytest.mark.slow
def test_labels_are_what_comes_of_trying(folder, small):
    source = small(dataset.open(folder), 3)
    batch = source.labels(0, None)
    assert source.situation_counts == (batch.features.context.shape[1], CELLS)
    assert batch.valid.any() and not batch.valid.all()
    again = small(dataset.open(folder), 3).labels(0, None)
    assert np.array_equal(batch.valid, again.valid)
    own = batch.own >= 0
    assert batch.valid[own, batch.own[own]].mean() > 0.6  # most are valid where they come from


@pytest.mark.slow
def test_train_and_remember_on_the_command_line(case, folder, small, tmp_path, capsys):
    model, place = tmp_path / "encoder", tmp_path / "memory"
    words = ["--turns", "2", "--dim", "8", "--seed", "5"]
    assert main(["train", "encoder", str(folder), "--out", str(model), *words]) == 0
    assert case.kind.plural in (model / "card.md").read_text("utf-8")
    encoder = load_encoder(model)
    assert encoder.kind == case.kind and encoder.dim == 8
    assert main(["memory", "make", str(folder), "--out", str(place), "--index", str(model)]) == 0
    loaded = Memory.load(place)
    assert loaded.kind == case.kind and loaded.index.key == encoder.key and len(loaded) > 5
    situation = families.draw(case.names[0], 33, 0)
    query = loaded.index.embed_query(situation)
    seen = posture_features(situation)
    assert np.array_equal(query, encoder.embed_features(seen)) and query.shape == (8,)
    planner = RecallPlanner(loaded)
    assert sum(planner.plan(families.draw(case.names[0], 33, k)).caught for k in range(6)) > 0
    capsys.readouterr()


@pytest.mark.slow
def test_an_encoder_keeps_to_the_number_of_joints_that_it_learned_from(tmp_path, small, capsys):
    case = CASES["chain"]
    own = {"family": "handover-chain", "arm": {"model": "ur5"}}
    shares = (FamilyShare("handover-chain"), FamilyShare("handover-chain", config=own))
    dataset.generate(replace(case.spec(), count=10, families=shares), tmp_path / "mixed", workers=1)
    with pytest.raises(RecallError, match="the dataset has arms of 6 and 7 joints"):
        small(dataset.open(tmp_path / "mixed"))
    shares = shares[1:]
    dataset.generate(replace(case.spec(), count=24, families=shares), tmp_path / "ur5", workers=1)
    model = str(tmp_path / "encoder")
    assert main(["train", "encoder", str(tmp_path / "ur5"), "--out", model, "--turns", "1"]) == 0
    encoder, other = load_encoder(model), families.draw("handover-chain", 35, 0)
    assert encoder.embed_situation(family_from_dict(own).draw(seeding.rng(3, 0), "ur5")).any()
    with pytest.raises(EncoderError, match="situation: of an arm with another number of joints"):
        encoder.embed_situation(other)
    with pytest.raises(EncoderError, match="memory: of an arm with another number of joints"):
        encoder.embed_memories([other], np.zeros((1, 12, 9)), np.zeros((1, GOAL)))
    capsys.readouterr()


def test_encoders_know_every_kind_of_arm():
    assert EncoderConfig(memory="map", arm=CHAIN.name).uses_maps
    words = "arm: must be one of planar, spatial, chain"
    assert words in refusal(EncoderError, EncoderConfig, arm="other")


@pytest.mark.slow  # compiles a march for spatial arms
@pytest.mark.parametrize("k", range(4))
def test_coarse_maps_are_the_same_in_a_mirror(k):
    situation, other = seen_in_a_mirror(canonical(families.draw("window-space", 41, k))[0])
    mine, yours = (joint_map_features(coarse_map(one)) for one in (situation, other))
    assert mine.shape == (3 * 8**3 + 5 + 12 * 9,) and np.isfinite(mine).all()
    assert mine[8**3 : 2 * 8**3].any()
    np.testing.assert_allclose(mine, yours, atol=1e-5)
