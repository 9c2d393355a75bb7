"""Other libraries get the same records."""

from __future__ import annotations

import numpy as np
import pytest

from gcm_learn import dataset
from gcm_learn.dataset.exports import ARM, PER_BODY, STEP, episode_of, export_minari
from gcm_learn.errors import UnknownNameError
from gcm_learn.scene.packing import pose


def test_an_episode_is_the_movement_and_what_is_seen_on_the_way(records):
    record = next(r for r in records if r.plans["layered"].caught and len(r.situation.bodies) > 2)
    plan, situation = record.plans["layered"], record.situation
    seen, actions = episode_of(record, plan, STEP)
    assert len(seen) == len(actions) + 1 and np.abs(actions).max() <= 1.0 + 1e-6
    hand = np.array(situation.arm.hand)
    for k, action in enumerate(actions):
        np.testing.assert_allclose(seen[k, 1:3], hand, atol=1e-9)
        span = (seen[k + 1, 0] - seen[k, 0]) * situation.horizon
        hand = hand + action * situation.arm.max_hand_speed * span
    np.testing.assert_allclose(hand, plan.trajectory.hand[-1], atol=1e-9)
    target = next(b for b in situation.bodies if b.role == "target")
    place = situation.bodies.index(target)
    for row in seen:
        centre, _ = pose(situation, place, row[0] * situation.horizon)
        np.testing.assert_allclose(row[ARM : ARM + 3], centre, atol=1e-9)
        assert row[ARM + 6] == 1.0 and row[ARM + PER_BODY + 6] == -1.0
    np.testing.assert_allclose(seen[0, ARM + 3 : ARM + 5], target.motion.velocity, atol=1e-2)


@pytest.mark.filterwarnings("ignore::UserWarning")
def test_minari_reads_the_episodes(records, tmp_path, monkeypatch):
    minari = pytest.importorskip("minari")
    monkeypatch.setenv("MINARI_DATASETS_PATH", str(tmp_path))
    export_minari(records[:20], "gcm-learn/try-v0")
    episodes = list(minari.load_dataset("gcm-learn/try-v0").iterate_episodes())
    caught = [r for r in records[:20] if r.plans["layered"].caught]
    assert len(episodes) == len(caught) > 5
    for episode, record in zip(episodes, caught, strict=True):
        seen, actions = episode_of(record, record.plans["layered"], STEP)
        np.testing.assert_allclose(episode.observations, seen)
        np.testing.assert_allclose(episode.actions, actions)
        assert episode.rewards.tolist() == [0.0] * (len(actions) - 1) + [1.0]
        assert episode.terminations[-1] and not episode.truncations.any()
    with pytest.raises(UnknownNameError, match="marching"):
        export_minari(records, "gcm-learn/no-v0", planner="gcm")


def test_hugging_face_loads_the_shards(records, tmp_path):
    datasets = pytest.importorskip("datasets")
    loaded = datasets.load_dataset(
        "parquet", data_files=records.files, split="train", cache_dir=str(tmp_path)
    )
    assert len(loaded) == 50 and set(loaded.column_names) == set(records.table().column_names)
    for k in (0, 27):
        row, record = loaded[k], records[k]
        assert row["index"] == record.index and row["stratum"] == record.stratum
        np.testing.assert_array_equal(np.frombuffer(row["arrival"], "<u2"), record.counts.ravel())
        path = record.plans["layered"].trajectory
        assert row["plan_layered"]["time"] == (None if path is None else path.time.tolist())


def test_pandas_gets_the_labels(records):
    pytest.importorskip("pandas")
    frame = dataset.open(records.folder.url).where(stratum="L").to_pandas(["index", "upper_arm"])
    assert list(frame.columns) == ["index", "upper_arm"]
    assert frame["upper_arm"].between(0.8, 1.2).all() and len(frame) > 5
