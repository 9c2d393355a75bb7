"""``gcm-learn cover`` and ``solve --planner covered``."""

from __future__ import annotations

import json

from gcm_learn.cli import main
from gcm_learn.cover import parametric_family
from gcm_learn.situation import situation_to_json


def test_a_cover_grows_is_enlarged_and_answers(tmp_path, capsys):
    out, words = tmp_path / "cover", ["cover", "belt", "--free", "2", "--out"]
    assert main([*words, str(out), "--cells", "3"]) == 0
    said = capsys.readouterr().out
    assert "25.0 % of belt with 2 free parameters, 1 stored catches, 5 cells examined" in said
    assert main([*words, str(out), "--check", "50", "--seed", "2"]) == 0
    said = capsys.readouterr().out
    assert "stored catches" in said and "0 of 50 draws from proven cells break a promise" in said
    family = parametric_family("belt").free(2)
    file = tmp_path / "scenes.jsonl"
    scenes = [family.situation(family.centre, "in"), family.situation(2 * family.high, "out")]
    file.write_text("".join(json.dumps(situation_to_json(s)) + "\n" for s in scenes))
    assert main(["solve", str(file), "--planner", "covered", "--memory", str(out)]) == 0
    first, second = map(json.loads, capsys.readouterr().out.splitlines())
    assert first["status"] == "caught" and first["clearance"] > 0.0
    assert second["message"].startswith("not covered: along = 0.8 is outside of -0.4 to 0.4")


def test_what_is_not_covered_is_said(tmp_path, capsys):
    assert main(["cover", "belt", "--cells", "1", "--out", str(tmp_path / "c")]) == 0
    assert "not covered: 100.00 %, not examined" in capsys.readouterr().out


def test_a_cover_of_something_else_is_not_overwritten(tmp_path, capsys):
    out = str(tmp_path / "c")
    assert main(["cover", "belt", "--free", "2", "--cells", "1", "--out", out]) == 0
    assert main(["cover", "belt", "--free", "3", "--cells", "1", "--out", out]) == 2
    assert "holds a cover of belt with 2 free parameters" in capsys.readouterr().err


def test_a_folder_that_cannot_be_made_is_named(tmp_path, capsys):
    file = tmp_path / "file"
    file.write_text("")
    assert main(["cover", "belt", "--cells", "1", "--out", str(file / "c")]) == 2
    assert f"--out {file / 'c'}" in capsys.readouterr().err
