"""``gcm-learn draw``: what can be drawn, drawn and written."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from gcm_learn import families, read_situations
from gcm_learn.cli import main

ROOT = Path(__file__).parents[2]


def test_families_are_listed_one_a_line(capsys):
    assert main(["draw", "--list"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in lines] == [*families.family_names(), *families.PRESETS]
    assert all(len(line.split()) > 4 for line in lines)


def test_drawing_is_the_same_from_the_name_and_from_the_printed_ranges(tmp_path, capsys):
    assert main(["draw", "gate-solid", "--list"]) == 0
    ranges = tmp_path / "ranges.json"
    ranges.write_text(capsys.readouterr().out)
    drawn = []
    for family in ("gate-solid", str(ranges)):
        assert main(["draw", family, "--count", "3", "--seed", "5"]) == 0
        drawn.append(capsys.readouterr().out)
    assert drawn[0] == drawn[1] and len(drawn[0].splitlines()) == 3


def test_changed_ranges_are_drawn_from(tmp_path, capsys):
    ranges = tmp_path / "ranges.json"
    ranges.write_text('{"family": "moving-point", "obstacles": [7, 7]}')
    assert main(["draw", str(ranges)]) == 0
    assert len(json.loads(capsys.readouterr().out)["bodies"]) == 8


def test_an_item_is_the_same_whatever_the_count(tmp_path, capsys):
    out = tmp_path / "gates.jsonl"
    assert main(["draw", "gate", "--count", "4", "--out", str(out)]) == 0
    assert capsys.readouterr().out == ""
    assert read_situations(out) == [families.draw("gate", 0, k) for k in range(4)]
    assert main(["draw", "gate"]) == 0
    assert capsys.readouterr().out == out.read_text().splitlines(keepends=True)[0]


@pytest.mark.parametrize("family", ["conveyor-chain", "panda-crowded-accelerated"])
def test_families_for_chains_take_an_arm_of_ones_own(family, tmp_path, capsys):
    model = json.loads((ROOT / "gcm_learn" / "arms" / "models" / "ur5.json").read_text())
    arm = tmp_path / "mine.json"
    arm.write_text(json.dumps(model | {"name": "mine"}))
    assert main(["draw", family, "--arm", str(arm), "--count", "2"]) == 0
    own = capsys.readouterr().out.splitlines()
    assert main(["draw", family, "--arm", "ur5", "--count", "2"]) == 0
    shipped = capsys.readouterr().out.splitlines()
    drawn = [json.loads(line)["arm"]["model"] for line in own]
    assert [one["name"] for one in drawn] == ["mine", "mine"] and len(drawn[0]["joints"]) == 6
    assert [line.replace('"mine"', '"ur5"') for line in own] == shipped
