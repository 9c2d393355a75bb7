"""Specifications: read strictly, and what they say of item k before it is made."""

import json
import pickle
from collections import Counter
from dataclasses import replace
from pathlib import Path

import pytest

from gcm_learn.dataset import FamilyShare, Holdout, Split, read_spec, spec_from_json, spec_to_json
from gcm_learn.dataset.splits import lot_of, split_of
from gcm_learn.errors import FileFormatError, SpecError
from gcm_learn.seeding import rng
from tests.dataset.conftest import CHAINS, SMALL, SPACE
from tests.refusals import refusal

ROOT = Path(__file__).parents[2]

TOML = """
format = "gcm-learn/dataset-spec@1"
name = "mine"
seed = 7
count = 100
planners = ["gcm"]
strata = {W = 1, Q = 3}

[[families]]
family = "random-planar"
share = 2.5

[split]
test = 0.2

[[holdouts]]
split = "test-fast"
quantity = "top_speed"
above = 1.0
"""


def test_toml_and_json_say_the_same(tmp_path):
    (tmp_path / "a.toml").write_text(TOML)
    spec = read_spec(tmp_path / "a.toml")
    assert spec.planners == ("gcm",) and spec.split == Split(test=0.2)
    assert spec.holdouts == (Holdout("test-fast", quantity="top_speed", above=1.0),)
    (tmp_path / "a.json").write_text(json.dumps(spec_to_json(spec)))
    again = read_spec(tmp_path / "a.json")
    assert again == spec and again.digest == spec.digest
    assert pickle.loads(pickle.dumps(spec)) == spec


WRONG = [
    ("seed = 7", "seed = -1", "seed: must be at least 0 (got -1)"),
    ("seed = 7", "seed = true", "seed: must be a whole number (got True)"),
    ("count = 100", "", "count: is missing"),
    ("count = 100", "cuont = 100", "cuont: is not a known field"),
    ("share = 2.5", "share = 0", "families[0].share: must be positive (got 0)"),
    ('family = "random-planar"', 'family = "x"', "families[0].family: 'x' is not one of"),
    ("share = 2.5", "config = {colour = 1}", "families[0].config.colour"),
    ('["gcm"]', '["gcm", "gcm"]', "planners[1]: 'gcm' is given twice"),
    ('["gcm"]', '["gmc"]', "did you mean 'gcm'?"),
    ("Q = 3", "X = 3", "strata.X: is not one of L, W, Q, U"),
    ("{W = 1, Q = 3}", "{W = 0}", "strata: must have a share above zero"),
    ("test = 0.2", "test = 1.5", "split.test: must be a share"),
    ("test = 0.2", "test = 0.99", "split.test: the shares of validation and test exceed 1"),
    ("above = 1.0", "", "holdouts[0].above: is missing"),
    ('"top_speed"', '"mass"', "holdouts[0].quantity: 'mass' is not one of"),
    ("spec@1", "spec@2", "format: must be 'gcm-learn/dataset-spec@1'"),
    ('name = "mine"', 'name = "a/b"', "name: must be a word"),
    ("seed = 7", "seed = ", "line 4"),
]


@pytest.mark.parametrize(("old", "new", "words"), WRONG)
def test_what_is_wrong_is_said_in_one_line(old, new, words, tmp_path):
    assert old in TOML
    path = tmp_path / "a.toml"
    path.write_text(TOML.replace(old, new))
    said = refusal(FileFormatError, read_spec, path)
    assert words in said and str(path) in said


def test_a_missing_file_and_a_strange_one(tmp_path):
    for error, call, given, words in (
        (FileFormatError, read_spec, tmp_path / "no.toml", "cannot be read"),
        (FileFormatError, read_spec, tmp_path / "spec.yaml", "toml or .json"),
        (SpecError, spec_from_json, [], "must be a table"),
    ):
        assert words in refusal(error, call, given)


ORACLE, WHOLE = "the oracle does not take chains", "map: must be 'marching' or 'none' for "
MIXED = (FamilyShare("gate"), FamilyShare("window-space"))


@pytest.mark.parametrize(
    ("spec", "change", "words"),
    [
        (CHAINS, {"map": "wave"}, f"{WHOLE}chains"),
        (SPACE, {"map": "marching"}, "n: must be at most 40 for maps of spatial arms (got 80)"),
        (CHAINS, {"planners": ("layered",)}, "planners[0]: 'layered' does not take chains"),
        (CHAINS, {"audit": 0.1}, f"audit: {ORACLE}"),
        (CHAINS, {"label": "oracle"}, f"label: {ORACLE}"),
        (SMALL, {"effort": 0.5}, "effort: is for spatial arms and chains"),
        (SPACE, {"effort": 2.0}, "effort: must be a share, 0 to 1 (got 2.0)"),
        (SPACE, {"map": "wave"}, f"{WHOLE}spatial arms"),
        (
            SPACE,
            {"planners": ("gcm",)},
            "planners[0]: 'gcm' does not take spatial arms; 'marching'",
        ),
        (SPACE, {"families": MIXED}, "families[1]: is for spatial arms, and the first one for pl"),
    ],
)
def test_what_does_not_go_together_is_refused(spec, change, words):
    assert words in refusal(SpecError, replace, spec, **change)


def test_shares_of_strata_hold_in_every_part(small):
    spec = replace(small, strata={"L": 1, "W": 2, "Q": 1, "U": 0})
    for first, count in ((0, 400), (13_000, 1000), (999, 57)):
        found = Counter(spec.wanted(k) for k in range(first, first + count))
        for stratum, share in (("L", 0.25), ("W", 0.5), ("Q", 0.25)):
            assert abs(found[stratum] - share * count) <= 3
        assert found["U"] == 0
    assert small.wanted(5) is None


def test_count_continues_a_dataset_and_nothing_else_does(small):
    assert replace(small, count=10**6).digest == small.digest
    for change in ({"seed": 4}, {"n": 80}, {"rungs": 1}, {"strata": {"W": 1}}, {"audit": 0.5}):
        assert replace(small, **change).digest != small.digest
    assert small.shards == 3 and list(small.indices(2)) == list(range(40, 50))


def test_lots_are_even_and_independent_of_seed_and_purpose():
    count = 20_000
    for seed, salt in ((0, 0), (1, 0), (2**62, 1)):
        lots = [lot_of(seed, k, salt) for k in range(count)]
        assert min(lots) >= 0.0 and max(lots) < 1.0
        tenths = Counter(int(10 * x) for x in lots)
        assert max(abs(n - count / 10) for n in tenths.values()) < 5 * (count * 0.09) ** 0.5
    for other in ((1, 1), (2, 0)):
        pairs = [lot_of(1, k) < 0.5 and lot_of(other[0], k, other[1]) < 0.5 for k in range(count)]
        assert abs(sum(pairs) - count / 4) < 5 * (count * 3 / 16) ** 0.5


def test_splits_hold_out_what_they_say():
    rules = (
        Holdout("test-gate", family="gate"),
        Holdout("test-long", quantity="upper_arm", above=1.1),
        Holdout("test-few", quantity="obstacles", below=2.0),
    )
    quantities = {"upper_arm": 1.0, "obstacles": 3.0}

    def split(k, family="swarm", seed=5, **changes):
        return split_of(Split(0.1, 0.2), rules, seed, k, family, quantities | changes)

    assert split(0, "gate", upper_arm=1.2) == "test-gate"
    assert split(0, upper_arm=1.2) == "test-long"
    assert split(0, obstacles=1.0) == "test-few"
    found = Counter(split(k) for k in range(5000))
    assert set(found) == {"train", "validation", "test"}
    assert abs(found["test"] - 1000) < 150 and abs(found["validation"] - 500) < 110
    both = sum(split(k) == split(k, seed=6) == "test" for k in range(5000))
    assert abs(both - 200) < 70  # another seed draws its own


def arm_files(folder, **changes):
    """Write an arm file and a specification beside it, which names it."""
    folder.mkdir()
    model = json.loads((ROOT / "gcm_learn" / "arms" / "models" / "ur5.json").read_text())
    (folder / "mine.json").write_text(json.dumps(model | {"name": "mine"} | changes, indent=2))
    text = TOML.split("strata")[0].replace('["gcm"]', '["search"]') + (
        'map = "none"\narm = "mine.json"\n[[families]]\nfamily = "throw-chain"\n'
        '[[families]]\nfamily = "gate-chain"\n'
    )
    (folder / "spec.toml").write_text(text)
    return folder / "spec.toml"


def test_an_arm_file_beside_the_specification_decides_by_its_content(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    path = arm_files(tmp_path / "a")
    spec = read_spec(path)
    drawn = [share.draw(rng(1), "x").arm.model for share in spec.drawn]
    assert [(model.name, model.dof) for model in drawn] == [("mine", 6), ("mine", 6)]
    (tmp_path / "a" / "mine.json").rename(tmp_path / "a" / "moved.json")
    path.write_text(path.read_text().replace("mine.json", "moved.json"))
    assert read_spec(path).digest == spec.digest
    assert read_spec(arm_files(tmp_path / "b", name="other")).digest != spec.digest
    alone = spec_from_json(spec_to_json(spec))
    assert alone == spec and alone.drawn[1].draw(rng(1), "x") == spec.drawn[1].draw(rng(1), "x")


def test_an_arm_file_of_one_family_lies_beside_the_specification_too(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    path = arm_files(tmp_path / "a")
    own = 'family = "gate-chain"\nconfig = {arm = {model = "mine.json"}}'
    text = path.read_text().replace('arm = "mine.json"', "").replace('family = "gate-chain"', own)
    path.write_text(text)
    models = [share.draw(rng(1), "x").arm.model.name for share in read_spec(path).drawn]
    assert models == ["panda", "mine"]


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("mine.json", "none.json", "none.json: cannot be read (No such file"),
        ("mine.json", "spec.toml", "is not the name of an arm"),
        ("throw-chain", "gate", "arm: "),
    ],
)
def test_an_arm_that_does_not_fit_is_refused(old, new, words, tmp_path):
    path = arm_files(tmp_path / "a")
    path.write_text(path.read_text().replace(old, new))
    said = refusal(FileFormatError, read_spec, path)
    assert "arm: " in said and words in said
