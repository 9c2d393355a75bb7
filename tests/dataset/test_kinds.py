"""Records of every kind of arm: record@1, record@2 and record@3."""

import pickle
from dataclasses import replace

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from gcm_learn import build_map, dataset, seeding
from gcm_learn.cli.inspect import report
from gcm_learn.dataset import FamilyShare, generate, make_item, read_spec, verify_dataset
from gcm_learn.dataset.cells import counts_of
from gcm_learn.dataset.folder import Folder
from gcm_learn.dataset.item import parameters_of, structure_of, twin_key
from gcm_learn.dataset.record import Record
from gcm_learn.dataset.shards import KEY, shard_name
from gcm_learn.dataset.verifying import _broken_plans
from gcm_learn.errors import DatasetError, UnknownNameError
from gcm_learn.families import draw, family_names
from gcm_learn.maps import chain_to
from gcm_learn.motion import opening, verify
from gcm_learn.planners import JointProblem, any_straight, without_waits
from gcm_learn.recall.map_features import joint_map_features
from gcm_learn.scene import pack
from gcm_learn.situation import SpatialFrame, canonical
from gcm_learn.wave import MarchingParams
from tests.dataset.conftest import CHAINS, PICKS, SPACE
from tests.dataset.test_sample import DATA
from tests.situation.test_spatial_frame import MIRROR, moved


def made_of(spec, tmp_path_factory):
    folder = tmp_path_factory.mktemp(spec.name)
    generate(spec, folder, workers=1)
    return dataset.open(folder)


@pytest.fixture(scope="module")
def space(tmp_path_factory):
    return made_of(SPACE, tmp_path_factory)


@pytest.fixture(scope="module")
def chains(tmp_path_factory):
    return made_of(CHAINS, tmp_path_factory)


@pytest.fixture(params=["records", "space", "chains"])
def made(request):
    return request.getfixturevalue(request.param)


def test_records_come_back_as_they_were_made(made):
    form = {"small": 1, "space": 2, "chains": 3}[made.spec.name]
    assert len(made) == made.spec.count
    assert made.manifest["schema"] == f"gcm-learn/record@{form}"
    for record in list(made)[:: max(3, len(made) // 5)]:
        fresh = make_item(made.spec, record.index)
        for name in ("situation", "frame", "stratum", "family", "split", "quantities"):
            assert getattr(record, name) == getattr(fresh, name)
        np.testing.assert_array_equal(record.parameters, fresh.parameters)
        assert record.stratum in "LWQU" and (record.map is None) == (form > 1)
        assert (record.split == "test-others") == (record.family == "other-arm-chain")
        for name, plan in fresh.plans.items():
            stored = record.plans[name]
            for part in ("status", "message", "catch_time", "catch_body", "catches", "clearance"):
                assert getattr(stored, part) == getattr(plan, part)
            for part in ("time", "joints", "hand") if plan.caught else ():
                a, b = getattr(stored.trajectory, part), getattr(plan.trajectory, part)
                np.testing.assert_allclose(a, b, rtol=0.0, atol=1e-12 * (part == "hand"))


@pytest.mark.parametrize(
    "made", ["records", "chains", pytest.param("space", marks=pytest.mark.slow)], indirect=True
)
def test_catches_hold_after_reading(made):
    caught = 0
    for record in made:
        scene = pack(record.situation)
        names = [body.name for body in record.situation.bodies]
        for plan in record.plans.values():
            caught += plan.caught
            if plan.caught and len(record.situation.targets) == 1:
                rules, body = opening(scene).rules, names.index(plan.catch_body)
                assert verify(scene, rules, plan.trajectory, body).good
    assert caught > 0.5 * len(made)
    found = verify_dataset(made.folder.url, 1)
    assert (found.records, found.plans, found.faults) == (len(made), caught, 0)
    assert found.remade == -(-len(made) // made.spec.shard_size)


def test_all_catches_of_several_are_checked(chains):
    record = next(r for r in chains if r.plans["search"].on_the_way)
    plan = record.plans["search"]
    first, *others = plan.on_the_way
    for wrong in (
        first._replace(time=0.5 * first.time),
        first._replace(body=plan.catch_body),
    ):
        worse = {"search": replace(plan, on_the_way=(wrong, *others))}
        spoiled = Record(CHAINS, {"situation": record.situation, "plans": worse, "stratum": "W"})
        assert list(_broken_plans(spoiled))


@pytest.mark.slow
def test_holds_and_places_come_back(tmp_path_factory):
    made = made_of(PICKS, tmp_path_factory)
    plans = [(r.plans["search"], make_item(PICKS, r.index).plans["search"]) for r in made]
    assert all(stored.catches == plan.catches for stored, plan in plans)
    assert any(stored.placed for stored, _ in plans)
    assert verify_dataset(made.folder.url, 1).faults == 0


def test_holds_places_and_margins_count_as_parameters():
    situation = draw("panda-belt", 5, 1)
    (target,) = situation.targets
    assert "box<=@" in structure_of(situation) and "%" in structure_of(situation)
    longer = replace(target.hold, seconds=target.hold.seconds + 0.01)
    bodies = (replace(target, hold=longer), *situation.obstacles)
    first, second = map(parameters_of, (situation, replace(situation, bodies=bodies)))
    assert np.count_nonzero(first != second) == 1


@pytest.fixture(scope="module")
def mapped(tmp_path_factory):
    """Return records of chains with maps; march for chains is compiled."""
    return made_of(replace(CHAINS, name="mapped", map="marching", n=16), tmp_path_factory)


@pytest.mark.slow
def test_the_report_says_which_arms(mapped):
    assert "  seed 7, chains, maps by marching, 16 cells along a side" in list(
        report(dataset.survey(mapped.folder.url))
    )
    for feed in (mapped.cache, mapped.stream):
        with pytest.raises(DatasetError, match="of maps of the plane"):
            feed()


def test_strata_say_what_the_plans_show(space):
    for record in space:
        straight, patient = record.plans["straight"], record.plans["search"]
        problem = JointProblem(record.situation, "test")
        line = any_straight(problem, 32).caught
        assert (record.stratum == "L") == (straight.caught or line)
        if record.stratum == "U":
            assert not patient.caught
        elif record.stratum != "L":
            assert patient.caught
            rests = patient.trajectory.rests and without_waits(problem, patient) is None
            assert (record.stratum == "Q") == rests


def test_the_situation_is_canonical_and_its_frame_leads_back(space):
    for record in space:
        assert canonical(record.situation)[1] == SpatialFrame()
        assert record.situation.arm.base.origin == (0.0, 0.0, 0.0)
        back = record.frame.original(np.zeros(3))
        assert np.allclose(back, record.base.origin)


def test_parameters_of_one_structure_have_one_length(space):
    lengths = {}
    for record in space:
        lengths.setdefault(record.structure, set()).add(len(record.parameters))
    assert all(len(found) == 1 for found in lengths.values())
    assert all(structure.startswith("space") for structure in lengths)


@pytest.mark.slow
def test_the_same_bytes_on_any_number_of_workers(space, tmp_path):
    generate(replace(SPACE, count=8), tmp_path, workers=2)
    shards = sorted((tmp_path / "shards").iterdir())
    assert len(shards) == 2
    for path in shards:
        assert path.read_bytes() == space.folder.read(f"shards/{path.name}")


def test_there_are_no_maps_to_feed(space, chains):
    for records in (space, chains):
        for feed in (records.cache, records.stream):
            with pytest.raises(DatasetError, match="its records hold no maps"):
                feed()


@pytest.mark.slow
def test_maps_of_chains_come_back_with_the_way_to_their_contact(mapped):
    met = 0
    for record in mapped:
        params = MarchingParams(n=mapped.spec.n, margin=0.0)
        fresh, held = build_map(record.situation, params), record.map
        assert (held.arrival.mask == fresh.arrival.mask).all()
        apart = np.ma.abs(held.arrival - fresh.arrival).filled(0.0)
        assert apart.max() <= 0.5001 * record.row["quantum"]
        for part in ("via", "effective_obstacles", "effective_target"):
            np.testing.assert_array_equal(getattr(held, part), getattr(fresh, part))
        assert held.interception == fresh.interception and held.hand == fresh.hand
        assert record.counts.shape == held.chart.shape == (16, 16, 16)
        np.testing.assert_allclose(*map(joint_map_features, (held, fresh)), atol=5e-3)
        if fresh.interception is not None:
            nodes = np.array(chain_to(held, held.met))
            np.testing.assert_allclose(held.postures(nodes), fresh.postures(nodes), atol=1e-6)
            met += 1
    assert met >= 3


@pytest.mark.parametrize("name", family_names("spatial"))
def test_every_family_has_quantities_in_forearms(name):
    record = make_item(replace(SPACE, families=(FamilyShare(name),)), 0)
    assert record.error is None
    assert 0.3 < record.quantities["upper_arm"] < 3.0
    assert record.quantities["max_hand_speed"] > 0.0 and np.isfinite(record.parameters).all()


@pytest.mark.parametrize("name", [*family_names("spatial"), *family_names("chain")])
def test_what_lies_otherwise_is_a_twin(name):
    """In another order of bodies; around spatial arms, turned, moved or mirrored too."""
    situation, rng = draw(name, 8, 0), seeding.rng(8)
    turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    turn *= np.sign(np.linalg.det(turn))
    there = [situation]
    if situation.arm.kind == "spatial":
        for matrix in (np.eye(3), turn, MIRROR, turn @ MIRROR):
            there.append(moved(situation, matrix, rng.normal(size=3)))
    keys = {key_of(one, 1 if len(one.targets) > 1 else -1) for one in there}
    assert len(keys) == 1
    assert key_of(situation, 1) in keys and key_of(draw(name, 8, 1), 1) not in keys


def key_of(situation, order):
    """The key by which twins are found, with bodies as they are (1) or the last one first (-1)."""
    form, _ = canonical(situation)
    form = replace(form, bodies=form.bodies[::order])
    return twin_key(structure_of(form), parameters_of(form))


def test_another_arm_is_another_structure():
    words = set()
    for model in ("panda", "ur5", "iiwa14"):
        share = FamilyShare("swarm-chain", config={"arm": {"model": model}})
        words.add(structure_of(share.draw(np.random.default_rng(0), "x")).split("|")[0])
    assert len(words) == 3 and all(word.startswith("chain-") for word in words)


def test_the_specification_for_pandas_has_all_families():
    spec = read_spec(DATA / "specs" / "panda.toml")
    later = {"person-chain"}  # the dataset and the models that it trained are older
    assert {share.family for share in spec.families} == set(family_names("chain")) - later
    assert spec.kind.name == "chain" and spec.planners == ("straight", "search")


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
