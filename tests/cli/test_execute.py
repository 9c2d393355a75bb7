"""``gcm-learn execute``: a line for each situation, and what fails does not stop the rest."""

from __future__ import annotations

import json
from dataclasses import replace

import pytest

from gcm_learn.cli import main
from gcm_learn.execution import execution_to_json, shipped_bodies
from gcm_learn.families import paper_scene
from gcm_learn.situation import write_situations


@pytest.fixture
def file(tmp_path):
    """The paper's pendulum, and the same with an arm that no body fits."""
    scene = paper_scene("fig8-space")
    odd = replace(scene, name="odd", arm=replace(scene.arm, forearm=(0.3, 0.0, 0.0)))
    path = tmp_path / "two.jsonl"
    write_situations(path, [odd, scene])
    return path


def test_a_line_tells_what_came_of_each(file, tmp_path, capsys):
    out = tmp_path / "done.jsonl"
    assert main(["execute", str(file), "--out", str(out)]) == 1
    first, second, summary = capsys.readouterr().out.splitlines()
    assert first.startswith("odd: failed: body: none that is shipped fits the arm (human: ")
    assert second.startswith("fig8-space: caught 'ball' at 0.6")
    assert "rad/s^2 from the motors of 'nao'" in second
    assert summary == "1 failed, 1 caught"
    odd, caught = (json.loads(line) for line in out.read_text().splitlines())
    assert (odd["status"], odd["catch_time"]) == ("failed", None)
    assert (caught["status"], caught["catch_body"], caught["contact"]) == ("caught", "ball", None)
    assert 0.0 <= caught["error_median"] <= caught["error_max"] < 0.01
    assert len(caught["limits"]) == 4
    assert set(odd) == set(caught)


def test_reports_go_to_standard_output_alone(file, capsys):
    assert main(["execute", str(file), "--out", "-", "--body", "nao"]) == 1
    lines = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    assert [line["name"] for line in lines] == ["odd", "fig8-space"]
    assert all(line["format"] == "gcm-learn/execution@1" for line in lines)


def test_a_file_may_hold_the_body(file, tmp_path, capsys):
    body = json.loads(shipped_bodies()["nao"].read_text())
    body["joints"][0]["torque"] = 0.05
    weak = tmp_path / "weak.json"
    weak.write_text(json.dumps(body))
    assert main(["execute", str(file), "--body", str(weak)]) == 1
    assert "joints[0].torque of 0.05 N m leaves nothing to accelerate" in capsys.readouterr().out
    body["joints"][0]["torque"] = -1
    weak.write_text(json.dumps(body))
    assert main(["execute", str(file), "--body", str(weak)]) == 2
    assert "weak.json:1: joints[0].torque: must be positive" in capsys.readouterr().err


def test_planar_arms_are_refused(scene_file, scene, capsys):
    assert main(["execute", str(scene_file(scene()))]) == 2
    assert "execute takes spatial arms only" in capsys.readouterr().err


def test_films_are_written(file, tmp_path, monkeypatch):
    shown = []
    monkeypatch.setattr(
        "gcm_learn.plots.animate_execution",
        lambda situation, done, path: (shown.append(execution_to_json(done)), path.touch()),
    )
    assert main(["execute", str(file), "--film", str(tmp_path / "films")]) == 1
    assert [path.name for path in (tmp_path / "films").iterdir()] == ["fig8-space.gif"]
    assert [done["status"] for done in shown] == ["caught"]
