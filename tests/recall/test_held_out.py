"""What is held out stays out of training, exams, memories and what indexes are fitted to."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("pyarrow")
pytest.importorskip("safetensors")

from gcm_learn import dataset, get_planner
from gcm_learn.cli import main
from gcm_learn.dataset.item import quantities_of
from gcm_learn.evaluation import cases
from gcm_learn.recall import Memory, RawIndex
from gcm_learn.recall.growth import remember
from gcm_learn.recall.hand_features import clearance_features
from gcm_learn.recall.transfer_labels import Sizes, TransferLabels
from gcm_learn.scene.bodies import TOP_SPEED
from gcm_learn.scene.packing import pack

DATA = Path(__file__).parents[2] / "data"
GRASP, UPPER_ARM = -4, -8  # columns of a look's context


@pytest.fixture
def records(marked_folder):
    """Return records of which each split has some."""
    found = dataset.open(marked_folder)
    assert set(found.column("split")) == {"train", "validation", "test", "test-gate", "test-long"}
    return found


@pytest.fixture
def labels(records):
    """Return labels in small batches, most of whose situations are no records'."""
    return TransferLabels(records, 3, sizes=Sizes(situations=60, any=10))


def catches_of(records, split):
    """The situations of a split's catches."""
    some = records.where(split=split)
    return [r.situation for r in some if any(plan.caught for plan in r.plans.values())]


def test_an_encoder_learns_from_the_records_for_training_alone(records, labels):
    assert labels.situations == catches_of(records, "train")
    assert len(labels.situations) == len(labels.knots) == len(labels.path_features) > 5


def test_an_encoder_is_examined_on_the_records_for_validation_alone(records, labels):
    asked = []

    def best(features, k):
        asked.append(features.context)
        return np.zeros((len(features.context), k), np.int64)

    assert labels.validate(best)
    reachable = records.where(split="validation", stratum=("L", "W", "Q"))
    wanted = [clearance_features(record.situation).context for record in reachable]
    np.testing.assert_array_equal(np.unique(asked[0], axis=0), np.unique(wanted, axis=0))


def marks_of(labels):
    """What the arms of a batch's situations grasp, and their upper arms."""
    context = labels.labels(0, None).features.context
    return {round(float(grasp) / 10.0, 3) for grasp in context[:, GRASP]}, context[
        :, UPPER_ARM
    ].max()


def test_labels_draw_neither_a_family_nor_a_range_that_is_held_out(labels):
    arm = labels.situations[0].arm
    seen = clearance_features(labels.situations[0]).context
    assert seen[[GRASP, UPPER_ARM]] == pytest.approx([10.0 * arm.grasp, arm.upper_arm])
    grasps, longest = marks_of(labels)
    assert grasps == {0.05, 0.06} and longest <= 1.1
    labels.spec = replace(labels.spec, holdouts=labels.spec.holdouts[:1])
    grasps, longest = marks_of(labels)
    assert grasps == {0.05, 0.06} and longest > 1.1
    labels.spec = replace(labels.spec, holdouts=())
    assert 0.08 in marks_of(labels)[0]


@pytest.mark.parametrize("split", [None, "train", "validation", "test-gate"])
def test_a_memory_holds_one_split_alone(records, marked_folder, tmp_path, split):
    """By default that for training, to which its index is fitted too."""
    chosen = [] if split is None else ["--split", split]
    assert main(["memory", "make", marked_folder, "--out", str(tmp_path / "memory"), *chosen]) == 0
    memory, split = Memory.load(tmp_path / "memory"), split or "train"
    assert memory.situations() == catches_of(records, split)
    assert memory.index.key == RawIndex.fit([r.situation for r in records.where(split=split)]).key


class Watched:
    """Records that note which of them are read."""

    def __init__(self, records):
        self.records, self.spec, self.read = records, records.spec, set()

    def __len__(self):
        return len(self.records)

    def __getitem__(self, k):
        self.read.add(k)
        return self.records[k]

    def part(self, rows):
        """Some of them."""
        self.read.update(rows.tolist())
        return self.records.part(rows)


def test_a_memory_of_some_records_has_seen_no_others(records):
    watched = Watched(records)
    memory = remember(watched, most=12, seed=4)
    assert len(watched.read) == 12
    read = [records[k].situation for k in sorted(watched.read)]
    assert memory.situations() == [s for s in read if s in memory.situations()]
    assert memory.index.key == RawIndex.fit(read).key


def test_the_memory_that_ships_holds_nothing_that_is_held_out_or_compared_on():
    memory = get_planner("recall").memory
    holdouts = dataset.read_spec(DATA / "specs" / "train.toml").holdouts
    for k in range(0, len(memory), 5):
        entry = memory[k]
        top = float(pack(entry.situation).bodies.rows[:, TOP_SPEED].max())
        quantities = quantities_of(entry.situation, top)
        assert not any(holdout.holds(entry.family, quantities) for holdout in holdouts)
    bodies = {case.situation.bodies for case in cases("demo", count=50)}
    assert len(bodies) == 50 and not bodies & {s.bodies for s in memory.situations()}
