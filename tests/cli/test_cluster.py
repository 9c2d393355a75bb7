"""``gcm-learn cluster``: a table of the catches of a dataset or a memory, and a page."""

from __future__ import annotations

import pytest

pytest.importorskip("sklearn")
pytest.importorskip("pyarrow")

from pyarrow.parquet import read_table

from gcm_learn import artifacts, dataset
from gcm_learn.cli import main
from gcm_learn.recall import Memory, RawIndex

SAMPLE = artifacts.shipped("data") / "sample"


@pytest.mark.slow
def test_records_are_in_the_table_with_their_clusters(tmp_path, capsys):
    words = ["--by", "map", "--most", "12", "--count", "3"]
    assert main(["cluster", str(SAMPLE), "--out", str(tmp_path), *words]) == 0
    said = capsys.readouterr().out
    table = read_table(tmp_path / "labels.parquet").to_pydict()
    records = {record.index: record for record in dataset.open(SAMPLE)[:12]}
    caught = [k for k, record in records.items() if record.earliest() is not None]
    assert table["index"] == caught and set(table["cluster"]) == {1, 2, 3}
    assert table["family"] == [records[k].family for k in caught]
    medoids = [c for c, is_one in zip(table["cluster"], table["medoid"], strict=True) if is_one]
    assert sorted(medoids) == [1, 2, 3]
    assert f"3 clusters of {len(caught)} catches" in said
    assert (tmp_path / "index.html").as_uri() in said


def test_what_has_no_catches_is_one_line(tmp_path, capsys):
    Memory(RawIndex.fit([record.situation for record in dataset.open(SAMPLE)[:2]])).save(tmp_path)
    assert main(["cluster", str(tmp_path), "--out", str(tmp_path / "out")]) == 2
    assert capsys.readouterr().err == ("gcm-learn: count: 0 catches make from 2 to -1 clusters\n")
