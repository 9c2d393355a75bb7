"""The samples in git are datasets that this version reads, and what data/README.md says."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest

from gcm_learn import dataset
from gcm_learn.dataset import read_spec
from gcm_learn.dataset.manifest import faults_of
from gcm_learn.dataset.record import PARTS, Record, rows_of, schema_of
from gcm_learn.dataset.verifying import verify_shard

DATA = Path(__file__).parents[2] / "data"
README = (DATA / "README.md").read_text("utf-8")


COUNTS = {"sample": 500, "sample-space": 300}


@pytest.fixture(scope="module", params=COUNTS)
def sample(request):
    return dataset.open(DATA / request.param)


def spec_of(sample):
    return read_spec(DATA / sample.spec.name / "spec.toml")


def test_it_is_what_its_specification_says_and_light(sample):
    spec, count = spec_of(sample), COUNTS[sample.spec.name]
    assert spec.digest == sample.spec.digest and len(sample) == spec.count == count
    assert sample.manifest["complete"] and sample.manifest["failed"] == 0
    files = [path for path in (DATA / spec.name).rglob("*") if path.is_file()]
    assert sum(path.stat().st_size for path in files) < 5_000_000
    assert {family.family for family in spec.families} == set(sample.column("family"))
    shares = np.array([list(sample.column("stratum")).count(s) for s in "LWQU"]) / count
    assert np.abs(shares - 0.25).max() < 0.01


def test_records_are_packed_as_they_were_stored(sample):
    part = sample[::50]
    made = [Record(sample.spec, {p.name: p.__get__(one, Record) for p in PARTS}) for one in part]
    assert part.table().replace_schema_metadata(None).equals(rows_of(sample.spec, made))


def test_its_catches_hold(sample):
    report = verify_shard(sample.spec, 0, str(DATA / sample.spec.name))
    assert report.faults == 0, report.quoted
    assert report.plans > 0.25 * COUNTS[sample.spec.name]
    assert not list(faults_of(sample.folder, hashes=True))


def test_the_list_of_datasets_has_it(sample):
    listed = json.loads((DATA / "manifest.json").read_text())["datasets"]
    (entry,) = [one for one in listed if one["name"] == sample.spec.name]
    for name in ("hash", "records", "bytes"):
        assert entry[name] == sample.manifest[name]
    for one in listed:
        assert read_spec(DATA.parent / one["spec"]).digest == one["spec_digest"]


def test_the_readme_explains_every_column_and_field():
    spec, spatial = (read_spec(DATA / name / "spec.toml") for name in COUNTS)
    tables, others = README.split("## Record")[1].split("**`gcm-learn/record@2`**")
    for name in (*set(schema_of(spatial).names) - set(schema_of(spec).names), "joints", "rates"):
        assert name.startswith("plan_") or f"`{name}`" in others
    told = set(re.findall(r"`(\w+)`", "".join(re.findall(r"^\| (.*?) \|", tables, re.M))))
    columns = {name for name in schema_of(spec).names if not name.startswith("plan_")}
    assert columns | {"plan_NAME"} == told
    fields = README.split("## Specification")[1].split("## Record")[0]
    told = set(re.findall(r"^\| `(\w+)`", fields, re.M))
    assert told == {*dataset.DatasetSpec.__dataclass_fields__, "format"}


SPECIFICATIONS = sorted([*DATA.glob("*/spec.toml"), *DATA.glob("specs/*.toml")])


@pytest.mark.parametrize("path", SPECIFICATIONS, ids=lambda p: f"{p.parent.name}-{p.stem}")
def test_specifications_can_be_read(path):
    assert read_spec(path).count > 0


def test_the_readmes_examples_run(monkeypatch, tmp_path):
    reading, torch = re.findall(r"^```python\n(.*?)^```", README, re.M | re.S)
    monkeypatch.chdir(DATA.parent)
    cached = reading.replace("hard.cache(", f"hard.cache({str(tmp_path)!r}, ")
    assert cached != reading
    scope: dict = {"__name__": "example"}
    exec(compile(cached, "README.md", "exec"), scope)
    pytest.importorskip("torch")
    *lines, last = torch.splitlines()
    exec(compile("\n".join(lines), "README.md", "exec"), scope)
    assert tuple(eval(last, scope)) == (8, 3, 80, 80)
    assert next(iter(scope["streamed"]))["image"].shape == (8, 3, 80, 80)


def test_the_sample_in_space_has_arms_of_all_kinds():
    sample = dataset.open(DATA / "sample-space")
    assert sample.manifest["schema"] == "gcm-learn/record@2"
    assert len(set(sample.column("upper_arm"))) >= 20
    smooth = [name for name in sample.column("structure") if "acceleration" in name]
    assert 50 < len(smooth) < 150
    hurried = sample.where(structure=tuple(smooth), stratum=("W", "Q"))
    for record in hurried[:5]:
        plan, arm = record.plans["search"], record.situation.arm
        assert plan.caught and any(arm.joint_rates)
        assert np.allclose(plan.trajectory.rates[0], arm.joint_rates)
    assert set(sample.column("split")) >= {"train", "validation", "test", "test-family"}
