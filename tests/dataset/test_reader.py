"""What is read is what was made."""

from __future__ import annotations

import pickle

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from gcm_learn import build_map, dataset
from gcm_learn.dataset.cells import counts_of
from gcm_learn.dataset.folder import Folder
from gcm_learn.dataset.item import make_item
from gcm_learn.dataset.shards import KEY, shard_name
from gcm_learn.errors import DatasetError, UnknownNameError
from gcm_learn.motion.rules import rules_of
from gcm_learn.motion.verification import verify
from gcm_learn.scene.packing import pack
from gcm_learn.wave import MarchingParams


def test_records_come_back_as_they_were_made(records):
    for k in (0, 19, 20, 33, 49):
        record, found = records[k], make_item(records.spec, k)
        assert record.index == k and record.situation == found.situation
        assert (record.stratum, record.family, record.split) == (
            found.stratum, found.family, found.split
        )  # fmt: skip
        assert record.frame == found.frame
        np.testing.assert_array_equal(record.parameters, found.parameters)
        for name, plan in found.plans.items():
            stored = record.plans[name]
            assert (stored.status, stored.message) == (plan.status, plan.message)
            assert (stored.catch_time, stored.catch_body) == (plan.catch_time, plan.catch_body)
            if plan.caught:
                assert stored.clearance == plan.clearance
                for part in ("time", "hand", "joints"):
                    a, b = getattr(stored.trajectory, part), getattr(plan.trajectory, part)
                    np.testing.assert_array_equal(a, b)


def test_maps_come_back_to_half_a_step(records):
    seen = 0
    for record in records[:20]:
        fresh = build_map(record.situation, MarchingParams(n=records.spec.n))
        quantum = record.row["quantum"]
        assert quantum == pytest.approx(0.2 * fresh.kappa)
        np.testing.assert_array_equal(record.map.arrival.mask, fresh.arrival.mask)
        away = np.ma.abs(record.map.arrival - fresh.arrival)
        assert away.max() is np.ma.masked or away.max() <= 0.5001 * quantum
        for part in ("effective_obstacles", "effective_target"):
            np.testing.assert_array_equal(getattr(record.map, part), getattr(fresh, part))
        assert record.map.interception == fresh.interception and record.map.lattice == fresh.lattice
        seen += fresh.interception is not None
    assert seen >= 5


def test_catches_hold_after_reading(records):
    caught = 0
    for record in records:
        for plan in record.plans.values():
            if plan.caught:
                situation = record.situation
                body = [b.name for b in situation.bodies].index(plan.catch_body)
                scene = pack(situation)
                verdict = verify(scene, rules_of(scene), plan.trajectory, body)
                assert verdict.good, verdict.reason
                caught += 1
    assert caught > 30


def test_labels_filter_without_reading_maps(records, monkeypatch):
    strata = [record.stratum for record in records]

    def no_row(self, place):
        raise AssertionError("a record was read")

    monkeypatch.setattr("gcm_learn.dataset.reader._Shelf.row", no_row)
    hard = records.where(stratum=("W", "Q"))
    assert len(hard) == strata.count("W") + strata.count("Q")
    assert set(hard.column("stratum")) <= {"W", "Q"}
    assert len(records.where(stratum="L", split="train")) <= strata.count("L")
    short = records.where(upper_arm=lambda column: column < 1.0)
    assert 0 < len(short) < len(records) and short.column("upper_arm").max() < 1.0
    with pytest.raises(UnknownNameError, match=r"colour.*stratum"):
        records.where(colour="red")


def test_slices_and_tables_agree(records):
    part = records[10:40:7]
    assert [record.index for record in part] == [10, 17, 24, 31, 38]
    table = part.table(["index", "stratum"])
    assert table["index"].to_pylist() == [10, 17, 24, 31, 38]
    frame = records.to_pandas()
    assert list(frame["index"]) == list(range(50)) and "arrival" not in frame
    assert records[-1].index == 49
    with pytest.raises(IndexError):
        records[50]
    assert [r.index for r in pickle.loads(pickle.dumps(part))] == [10, 17, 24, 31, 38]
    assert records.where(stratum="nothing").table(["index"]).num_rows == 0


def test_audited_records_carry_the_oracles_bounds(records):
    audited = records.where(oracle_stratum=lambda column: [x is not None for x in column])
    assert len(audited) == records.manifest["audit"]["records"] >= 1
    for record in audited:
        assert record.row["oracle_lower"] <= record.row["oracle_upper"]


def test_another_version_and_other_files_are_refused(records, tmp_path):
    with pytest.raises(DatasetError, match="no dataset"):
        dataset.open(tmp_path)
    folder = Folder(tmp_path)
    folder.make()
    content = records.folder.read(shard_name(0))
    table = pq.read_table(pa.BufferReader(content))
    header = table.schema.metadata[KEY].replace(b"record@1", b"record@9")
    pq.write_table(table.replace_schema_metadata({KEY: header}), folder.path(shard_name(0)))
    with pytest.raises(DatasetError, match=r"record@9.*record@1"):
        dataset.open(tmp_path)
    folder.write(shard_name(0), content[:1000])
    with pytest.raises(DatasetError, match="not a shard"):
        dataset.open(tmp_path)


def test_arrivals_beyond_sixteen_bits_are_not_wrapped():
    arrival = np.ma.MaskedArray([0.0, 65534.0, 7e4], mask=[False, False, True])
    np.testing.assert_array_equal(counts_of(arrival, 1.0), [0, 65534, 65535])
    with pytest.raises(OverflowError):
        counts_of(np.ma.MaskedArray([65535.0], mask=[False]), 1.0)
