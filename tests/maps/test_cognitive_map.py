"""Cognitive maps: what building one promises, and saving without loss."""

import itertools
import json
from dataclasses import replace

import numpy as np
import pytest

from gcm_learn import seeding
from gcm_learn.arms import Arm
from gcm_learn.charts import Lattice, chart_of
from gcm_learn.charts.extended import occupied_cells
from gcm_learn.charts.lattice import hand_space
from gcm_learn.errors import ArmKindError, FileFormatError, LatticeError
from gcm_learn.families import gate_scene
from gcm_learn.families.random_planar import random_planar
from gcm_learn.families.random_solid import random_solid
from gcm_learn.maps import CognitiveMap, build_map, explore
from gcm_learn.scene import pack
from gcm_learn.situation import situation_from_json
from gcm_learn.wave import MarchingParams, WaveParams
from tests.charts.test_chart import CHAIN
from tests.refusals import refusal
from tests.situation.scenes import NAO
from tests.worlds import among, disc

ENGINES = {"wave": WaveParams(), "marching": MarchingParams()}
GOAL = disc("goal", (-0.9, 1.2), role="target", radius=0.08)
POST = disc("post", (0.2, 0.9), radius=0.1)
ARM = Arm((1.3, 0.6), 3.4)


def scene(*bodies, horizon=2.0, arm=ARM):
    return among(arm, *bodies, horizon=horizon)


def same(first, second):
    """Whether two maps hold the same, to the bit."""
    names = ("lattice", "hand", "interception", "kappa", "engine")
    arrays = [
        (m.arrival.mask, m.arrival.compressed(), m.effective_obstacles, m.effective_target)
        for m in (first, second)
    ]
    return all(getattr(first, name) == getattr(second, name) for name in names) and all(
        map(np.array_equal, *arrays)
    )


@pytest.fixture(params=ENGINES)
def engine(request):
    return request.param


def build(situation, engine, **changes):
    return build_map(situation, replace(ENGINES[engine], **changes))


def test_it_says_where_and_when_the_target_was_met(engine):
    found = build(scene(GOAL, POST), engine)
    assert found.engine == engine and found.hand == ARM.hand
    assert found.interception.body == "goal"
    iy, ix = found.interception.cell
    assert found.effective_target[iy, ix]
    centres = found.lattice.centres
    assert found.interception.position == (centres[ix], centres[iy])
    away = np.hypot(found.interception.position[0] + 0.9, found.interception.position[1] - 1.2)
    assert away <= 0.08 + ARM.grasp + found.lattice.spacing
    assert found.interception_tau == pytest.approx(found.interception.time / found.kappa)
    assert 0.0 < found.interception.time <= 2.0


@pytest.mark.parametrize("seed", range(10))
def test_obstacles_are_masked_and_contacts_are_outside_of_them(engine, seed):
    family = random_planar if seed % 2 else random_solid
    found = build(family(seeding.rng(41, seed)), engine, until="horizon")
    assert (found.arrival.mask | ~found.effective_obstacles).all()
    assert not (found.effective_target & found.effective_obstacles).any()
    inside = hand_space(found.lattice).inside.reshape(found.arrival.shape)
    assert found.arrival.mask[~inside].all()
    assert (found.arrival.compressed() >= 0.0).all()
    if found.interception is not None:
        assert not found.effective_obstacles[found.interception.cell]
        assert not found.arrival.mask[found.interception.cell]
    else:
        assert not found.effective_target.any()


@pytest.mark.parametrize("seed", range(10))
def test_the_front_is_nowhere_faster_than_the_hand(engine, seed):
    situation = random_planar(seeding.rng(42, seed))
    found = build(situation, engine, until="horizon")
    x, y = np.meshgrid(found.lattice.centres, found.lattice.centres)
    away = np.hypot(x - situation.arm.hand[0], y - situation.arm.hand[1])
    # The wave starts in the cell's centre, and its first cells a little ahead of time.
    slack = 1.5 * found.lattice.spacing if engine == "wave" else 1e-9
    assert (found.arrival.filled(np.inf) >= (away - slack) / situation.arm.max_hand_speed).all()


def test_nothing_is_reached_after_the_horizon(engine):
    found = build(scene(GOAL, horizon=0.3), engine)
    assert found.interception is None and found.interception_tau is None
    assert found.arrival.max() <= 0.3 + 0.003  # the wave looks round every few steps
    assert 100 < found.arrival.count() < 3000


def test_contacts_can_be_ignored_for_a_while(engine):
    first = build(scene(GOAL), engine).interception
    later = build_map(scene(GOAL), ENGINES[engine], ignore=first.time + 0.03).interception
    assert later.time >= first.time + 0.03
    assert later.cell != first.cell


def test_a_target_behind_a_frozen_obstacle_is_no_contact(engine):
    """Erratum 13: frozen cells stay excited for ever, and a target crosses them later."""
    over = disc("over", (-0.9, 1.2), radius=0.3)
    found = build(scene(GOAL, over), engine, until="horizon")
    assert found.effective_obstacles.any()
    assert found.interception is None


def test_kappa_is_the_papers_at_the_papers_setting():
    """1/400 s per tau when the hand does 3.4 forearms a second, on 80 cells."""
    assert build(scene(GOAL), "wave").kappa == pytest.approx(1 / 400, rel=0.01)
    fast = build(scene(GOAL, arm=replace(ARM, max_hand_speed=6.8)), "wave")
    assert fast.kappa == pytest.approx(1 / 800, rel=0.01)


def test_the_default_engine_is_the_papers_wave():
    assert same(build_map(scene(GOAL, POST)), build(scene(GOAL, POST), "wave"))


def test_arrays_must_fit_the_lattice():
    found = build(scene(GOAL), "marching")
    with pytest.raises(ValueError, match=r"arrival must be \(40, 40\), got \(80, 80\)"):
        replace(found, chart=Lattice(40))


@pytest.mark.parametrize("case", ["contact", "none", "odd"])
def test_saving_loses_nothing(engine, case, tmp_path):
    situation = scene(GOAL, POST, horizon=2.0 if case == "contact" else 0.2)
    if case == "odd":
        arm = Arm((1.1, 0.6), 2.0, upper_arm=0.8123456789, elbow="left")
        situation = scene(replace(GOAL, name="Ж \n\"'"), POST, arm=arm)
    found = build(situation, engine, n=48 if case == "odd" else 80)
    path = found.save(tmp_path / "map.npz")
    assert path == tmp_path / "map.npz"
    assert same(found, CognitiveMap.load(path))
    assert CognitiveMap.load(path).arrival.dtype == found.arrival.dtype
    assert [p.name for p in tmp_path.iterdir()] == ["map.npz"]


def test_saving_adds_the_suffix_and_overwrites(tmp_path):
    first, second = (build(scene(GOAL, horizon=h), "marching") for h in (0.2, 2.0))
    assert first.save(tmp_path / "a") == tmp_path / "a.npz"
    second.save(str(tmp_path / "a.npz"))
    assert same(second, CognitiveMap.load(tmp_path / "a.npz"))


def test_a_failed_save_leaves_the_old_file(tmp_path, monkeypatch):
    found = build(scene(GOAL), "marching")
    path = found.save(tmp_path / "map")
    before = path.read_bytes()

    def fail(file, **arrays):
        file.write_bytes(b"half")
        raise OSError("disk full")

    monkeypatch.setattr(np, "savez_compressed", fail)
    with pytest.raises(OSError, match="disk full"):
        found.save(path)
    assert path.read_bytes() == before and len(list(tmp_path.iterdir())) == 1


def rewritten(path, **changes):
    """Write a saved map again with other arrays; None leaves one out."""
    with np.load(path) as data:
        arrays = {name: data[name] for name in data.files}
    arrays.update(changes)
    np.savez(path, **{name: a for name, a in arrays.items() if a is not None})
    return path


@pytest.fixture
def saved(tmp_path):
    return build(scene(GOAL, POST), "marching").save(tmp_path / "map")


def header_of(path, **changes):
    with np.load(path) as data:
        return json.dumps({**json.loads(str(data["header"])), **changes})


def refused(path):
    """The one-line error of loading a file, which must name it."""
    message = refusal(FileFormatError, CognitiveMap.load, path)
    assert str(path) in message
    return message


@pytest.mark.parametrize("keep", [0, 1, 100, 0.5, 0.99])
def test_a_file_cut_short_is_refused(saved, keep):
    whole = saved.read_bytes()
    saved.write_bytes(whole[: keep if isinstance(keep, int) else int(keep * len(whole))])
    refused(saved)


def test_a_file_that_is_no_map_is_refused(saved):
    """A pickle in it is not opened."""
    other = header_of(saved, format="gcm-learn/map@9")
    assert "gcm-learn/map@9" in refused(rewritten(saved, header=other))
    refused(rewritten(saved, arrival=np.array([{"a": 1}], dtype=object)))
    for content in (b"hello", b"{}", b"\x80\x04]."):
        saved.write_bytes(content)
        refused(saved)
    with pytest.raises(FileNotFoundError):
        CognitiveMap.load(saved.with_name("nowhere.npz"))


@pytest.mark.parametrize("name", ["header", "arrival", "effective_obstacles", "effective_target"])
def test_a_missing_array_is_refused_by_name(saved, name):
    assert name in refused(rewritten(saved, **{name: None}))


@pytest.mark.parametrize(
    "changes",
    [{"n": 81}, {"n": 10**9}, {"elbow": "up"}, {"contact": {"cell": [1, 2]}}, {"n": None}],
)
def test_a_header_that_does_not_fit_is_refused(saved, changes):
    refused(rewritten(saved, header=header_of(saved, **changes)))


@pytest.mark.parametrize("k", [8, 23])
def test_sheets_are_different_spans_in_which_a_cell_is_free(k):
    """On every sheet a cell is reached later than on the one before, and was blocked between."""
    situation, params = random_planar(seeding.rng(5, k)), MarchingParams(margin=0.0, lookback=0.0)
    cognitive_map = build_map(situation, params, wait=True)
    sheets, instants = cognitive_map.sheets, np.linspace(0.0, situation.horizon, 1000)
    occupied = np.array([occupied_cells(situation, cognitive_map.lattice, t) for t in instants])
    assert len(sheets) > 1
    for before, after in itertools.pairwise(sheets):
        cells = ~np.ma.getmaskarray(after)
        assert not np.ma.getmaskarray(before)[cells].any()
        assert (after[cells] > before[cells]).all()
        for iy, ix in np.argwhere(cells):
            between = (instants > before[iy, ix]) & (instants < after[iy, ix])
            assert occupied[between, iy, ix].any()


SPACE, LINKS = situation_from_json(NAO), situation_from_json(CHAIN)
WAVE, MARCHING = WaveParams(), MarchingParams()
REFUSALS = [
    (SPACE, WAVE, False, "a wave does not take spatial arms"),
    (SPACE, MARCHING, True, "marching that may wait does not take spatial arms"),
    (LINKS, WAVE, False, "a wave does not take chains"),
    (LINKS, MARCHING, True, "marching that may wait does not take chains"),
]


@pytest.mark.parametrize(("situation", "params", "wait", "message"), REFUSALS)
def test_a_map_or_a_front_that_cannot_be_is_refused(situation, params, wait, message):
    said = refusal(ArmKindError, build_map, situation, params, wait=wait)
    assert said == f"{message} (situation {situation.name!r})"
    chart = chart_of(situation, 20)
    assert message in refusal(ArmKindError, explore, pack(situation), chart, params, wait=wait)


def test_a_wave_that_is_to_wait_is_refused():
    said = refusal(LatticeError, build_map, gate_scene(), WAVE, wait=True)
    assert said == "wait: a wave freezes for ever what it meets; take MarchingParams"


@pytest.mark.parametrize(
    ("situation", "wait", "engine"),
    [
        (gate_scene(), False, "wave"),
        (gate_scene(), True, "layered"),
        pytest.param(LINKS, False, "marching", marks=pytest.mark.slow),
    ],
)
def test_every_arm_has_a_map_by_default(situation, wait, engine):
    assert build_map(situation, wait=wait).engine == engine
