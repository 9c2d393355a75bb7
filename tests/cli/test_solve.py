"""``gcm-learn solve``: what goes in, what comes out, and what is refused."""

from __future__ import annotations

import csv
import io
import json
import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest

from gcm_learn import families, solve
from gcm_learn.cli import main
from gcm_learn.cli.solve import Trajectories
from gcm_learn.compiled.notice import NOTICE
from gcm_learn.errors import StopError
from gcm_learn.families import paper_scene
from gcm_learn.situation import write_situations
from tests.extras import planner_params

ROOT = Path(__file__).parents[2]


def read_lines(text: str) -> list[dict]:
    return [json.loads(line) for line in text.splitlines()]


def test_one_solution_a_line_in_input_order(scene_file, scene, planner, capsys):
    names = [f"s{k}" for k in (3, 1, 2)]
    assert main(["solve", str(scene_file(*map(scene, names)))]) == 0
    out, err = capsys.readouterr()
    solutions = read_lines(out)
    assert [s["name"] for s in solutions] == names
    assert planner.asked == [names[0], *names]  # the first once more before, to load what it needs
    assert {s["format"] for s in solutions} == {"gcm-learn/solution@1"}
    assert err == ""


def test_json_file_and_standard_input_say_the_same(scene_file, scene, planner, capsys, monkeypatch):
    path = scene_file(scene(), name="one.json")
    assert main(["solve", str(path)]) == 0
    from_file = capsys.readouterr().out
    monkeypatch.setattr(sys, "stdin", io.StringIO(path.read_text()))
    assert main(["solve", "-"]) == 0
    assert capsys.readouterr().out == from_file != ""


@pytest.mark.parametrize("name", planner_params())
def test_same_input_same_bytes(name, scene_file, scene, capsys):
    path = str(scene_file(scene("a"), scene("b", horizon=0.4)))
    runs = []
    for _ in range(2):
        assert main(["solve", path, "--planner", name]) == 0
        solutions = read_lines(capsys.readouterr().out)
        assert [s["planner"] for s in solutions] == [name, name]
        runs.append(json.dumps([s | {"planning_ms": 0} for s in solutions]))
    assert runs[0] == runs[1]


def test_a_catch_keeps_the_contract(scene_file, scene, capsys):
    assert main(["solve", str(scene_file(scene()))]) == 0
    (solution,) = read_lines(capsys.readouterr().out)
    assert solution["status"] == "caught" and solution["catch_body"] == "ball"
    path = solution["trajectory"]
    assert path["time"][0] == 0.0 and path["time"][-1] == solution["catch_time"] <= 1.0
    assert path["hand"][0] == [1.1, -0.4]
    assert len(path["time"]) == len(path["hand"]) == len(path["joints"])


BAD = [
    ({"arm": {"hand": [2.4, 0.0], "max_hand_speed": 1.0}}, "arm.hand"),
    ({"arm": {"hand": [1.0, 0.0], "max_hand_speed": -1.0}}, "arm.max_hand_speed"),
    ({"horizon": float("nan")}, "horizon"),
    ({"horizon": "1"}, "horizon"),
    ({"bodies": []}, "bodies"),
    ({"colour": "red"}, "colour"),
    ({"name": "fine"}, "name"),
]


@pytest.mark.parametrize(("change", "field"), BAD)
def test_bad_input_is_refused_in_one_line(change, field, scene_file, scene, planner, capsys):
    path = scene_file(scene("fine"), scene(**change) if "name" not in change else scene("fine"))
    out = path.with_name("out.jsonl")
    assert main(["solve", str(path), "--out", str(out)]) == 2
    stdout, stderr = capsys.readouterr()
    assert stdout == "" and not out.exists() and planner.asked == []
    assert stderr.count("\n") == 1 and stderr.endswith("\n")
    assert "scenes.jsonl:2: " in stderr and field in stderr


@pytest.mark.parametrize("text", ["{", "", "[]", "nonsense", '"a"', "\x00\xff", "{}\n{}"])
def test_what_is_not_a_situation_is_refused(text, tmp_path, planner, capsys):
    path = tmp_path / "scene.json"
    path.write_bytes(text.encode("latin-1"))
    assert main(["solve", str(path)]) == 2
    stdout, stderr = capsys.readouterr()
    assert stdout == "" and stderr.count("\n") == 1 and "scene.json" in stderr


def test_out_takes_everything(scene_file, scene, planner, tmp_path, capsys):
    out = tmp_path / "out.jsonl"
    out.write_text("before")
    assert main(["solve", str(scene_file(scene("a"), scene("b"))), "--out", str(out)]) == 0
    assert [s["name"] for s in read_lines(out.read_text())] == ["a", "b"]
    assert capsys.readouterr() == ("", "")
    assert sorted(os.listdir(tmp_path)) == ["out.jsonl", "scenes.jsonl"]


def test_out_dash_is_standard_output(scene_file, scene, planner, capsys):
    assert main(["solve", str(scene_file(scene())), "--out", "-"]) == 0
    assert len(read_lines(capsys.readouterr().out)) == 1


@pytest.mark.parametrize(
    ("option", "place"),
    [
        ("--out", "missing/out.jsonl"),
        ("--out", "file/out.jsonl"),
        ("--out", "scenes.jsonl"),
        ("--out", "."),
        ("--plot", "file/pictures"),
        ("--plot", "scenes.jsonl"),
    ],
)
def test_places_that_cannot_be_written_to(option, place, scene_file, scene, planner, capsys):
    path = scene_file(scene())
    path.with_name("file").touch()
    before = path.read_text()
    assert main(["solve", str(path), option, str(path.parent / place)]) == 2
    stdout, stderr = capsys.readouterr()
    assert stdout == "" and stderr.count("\n") == 1 and option in stderr
    assert planner.asked == [] and path.read_text() == before


@pytest.mark.parametrize(
    ("error", "code", "said"),
    [
        (KeyboardInterrupt(), 130, "interrupted"),
        (ZeroDivisionError("by\nzero"), 1, "'b': ZeroDivisionError: by zero"),
        (MemoryError(), 1, "'b': MemoryError"),
    ],
)
def test_out_is_left_alone_when_planning_breaks_off(
    error, code, said, scene_file, scene, planner, tmp_path, capsys, monkeypatch
):
    def plan(situation):
        if situation.name == "b":
            raise error
        return type(planner).plan(planner, situation)

    monkeypatch.setattr(planner, "plan", plan)
    out = tmp_path / "out.jsonl"
    out.write_text("before")
    path = scene_file(scene("a"), scene("b"))
    assert main(["solve", str(path), "--out", str(out)]) == code
    stdout, stderr = capsys.readouterr()
    assert stdout == "" and stderr.count("\n") == 1 and said in stderr
    assert out.read_text() == "before"
    assert sorted(os.listdir(tmp_path)) == ["out.jsonl", "scenes.jsonl"]


def test_a_number_that_json_does_not_know_is_an_error(
    scene_file, scene, planner, capsys, monkeypatch
):
    monkeypatch.setattr("gcm_learn.planners.plan_to_json", lambda *_: {"x": float("nan")})
    assert main(["solve", str(scene_file(scene("a")))]) == 1
    stdout, stderr = capsys.readouterr()
    assert stdout == "" and stderr.count("\n") == 1 and "'a'" in stderr


def test_pictures_have_safe_names_that_differ(scene_file, scene, planner, tmp_path, monkeypatch):
    class Picture:
        def savefig(self, place):
            Path(place).write_text("picture")

    monkeypatch.setattr("gcm_learn.plots.plan_figure", lambda situation, plan: Picture())
    names = ["../../a b", "A b", "..", "a/b", "ü"]
    pictures = tmp_path / "new" / "pictures"
    path = scene_file(*map(scene, names))
    assert main(["solve", str(path), "--plot", str(pictures)]) == 0
    assert sorted(os.listdir(pictures)) == [
        "A_b-2.png", "a_b-3.png", "a_b.png", "situation-2.png", "situation.png"
    ]  # fmt: skip


def test_pictures_are_pictures(scene_file, scene, tmp_path, capsys):
    assert main(["solve", str(scene_file(scene())), "--plot", str(tmp_path)]) == 0
    assert len(read_lines(capsys.readouterr().out)) == 1
    picture = (tmp_path / "ball.png").read_bytes()
    assert picture.startswith(b"\x89PNG") and len(picture) > 5000


def run_shell(script: str) -> subprocess.CompletedProcess[str]:
    """Run a script, and drop the line that tells of compiling."""
    command = f'gcm() {{ "{sys.executable}" -c "import sys; from gcm_learn.cli import main; \
sys.exit(main())" "$@"; }}; {script}'
    done = subprocess.run(
        ["bash", "-c", command], cwd=ROOT, capture_output=True, text=True, check=False, timeout=120
    )
    done.stderr = done.stderr.replace(f"{NOTICE}\n", "")
    return done


def test_a_reader_that_stops_early_is_no_error(scene_file, scene):
    path = scene_file(*(scene(f"s{k}") for k in range(300)))
    done = run_shell(f"gcm solve {path} --planner straight | head -n 1; exit ${{PIPESTATUS[0]}}")
    assert len(read_lines(done.stdout)) == 1
    assert done.stderr == "" and done.returncode == 141


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no device that is always full")
def test_a_full_disk_is_said_in_one_line(scene_file, scene):
    path = scene_file(scene())
    done = run_shell(f"gcm solve {path} --planner straight > /dev/full")
    assert done.returncode == 1
    assert done.stderr.count("\n") == 1 and "No space left" in done.stderr


def test_a_deadline_is_told_to_planners_that_can_keep_it(scene_file, scene, capsys):
    path = str(scene_file(scene("a"), scene("b", horizon=0.4)))
    answers = []
    for options in ([], ["--deadline", "60s"], ["--deadline", "0"]):
        assert main(["solve", path, "--planner", "layered", *options]) == 0
        answers.append([s["status"] for s in read_lines(capsys.readouterr().out)])
    assert answers[0] == answers[1] and set(answers[2]) <= {"caught", "unreachable"}


@pytest.mark.parametrize(("form", "name"), [("ros2", "fig4.yaml"), ("csv", "fig4.csv")])
def test_trajectories_end_at_rest(form, name, tmp_path, capsys):
    write_situations(tmp_path / "scene.json", [paper_scene("fig4")])
    made = []
    for more in ((), ("--no-stop",)):
        folder = tmp_path / f"out{len(more)}"
        argv = ["solve", str(tmp_path / "scene.json"), "--trajectories", str(folder)]
        assert main([*argv, "--as", form, *more]) == 0
        assert [path.name for path in folder.iterdir()] == [name]
        made.append((folder / name).read_text())
    assert len(made[0]) > len(made[1])
    assert capsys.readouterr().err == ""


def test_a_catch_without_a_stop_is_refused_in_one_line(tmp_path, capsys, monkeypatch):
    def none(situation, trajectory):
        raise StopError(f"{situation.name!r}: no verified stop was found")

    monkeypatch.setattr("gcm_learn.motion.with_stop", none)
    write_situations(tmp_path / "scene.json", [paper_scene("fig4")])
    argv = ["solve", str(tmp_path / "scene.json"), "--trajectories", str(tmp_path / "out")]
    assert main(argv) == 1
    out, err = capsys.readouterr()
    assert json.loads(out)["status"] == "caught" and not list((tmp_path / "out").iterdir())
    assert err == "gcm-learn: 'fig4': no verified stop was found; see --no-stop\n"
    assert main([*argv, "--no-stop"]) == 0


def _unstopped(situation, trajectory):
    raise StopError("no stop")


def test_movements_under_limits_of_acceleration_are_planned_to_end_at_rest(
    tmp_path, capsys, monkeypatch
):
    monkeypatch.setattr("gcm_learn.motion.with_stop", _unstopped)
    write_situations(tmp_path / "panda.jsonl", [families.draw("panda-crowded-accelerated", 0, 5)])
    argv = ["solve", str(tmp_path / "panda.jsonl"), "--trajectories", str(tmp_path / "out")]
    assert main([*argv, "--as", "csv", "--rate", "500"]) == 0
    answer = json.loads(capsys.readouterr().out)
    assert answer["format"] == "gcm-learn/solution@3"  # the answer is to what was asked
    assert any(answer["trajectory"]["rates"][-1])
    (made,) = (tmp_path / "out").iterdir()
    *_, before, last = csv.DictReader(io.StringIO(made.read_text()))
    assert {value for name, value in last.items() if name.endswith("_velocity")} == {"0.0"}
    assert float(last["time"]) - float(before["time"]) <= 0.002 + 1e-9


def test_a_stop_is_tried_where_no_plan_ends_at_rest(tmp_path, monkeypatch):
    situation, asked = families.draw("panda-crowded-accelerated", 0, 5), []
    plan = solve(situation)
    none = replace(plan, status="unreachable", trajectory=None, catch_body=None)
    monkeypatch.setattr(
        "gcm_learn.motion.with_stop", lambda *given: asked.append(given) or given[1]
    )
    Trajectories(tmp_path, "csv", None, lambda ended: none).write(situation, plan)
    assert asked == [(situation, plan.trajectory)] and len(list(tmp_path.iterdir())) == 1


LIMITED = ("marching", "straight", "straight-wait", "st-rrt-star")


@pytest.mark.parametrize("name", planner_params(LIMITED))
def test_a_planner_that_cannot_keep_limits_of_acceleration_refuses(name, tmp_path, capsys):
    easy, hard = (
        families.draw(preset, 0, 0) for preset in ("panda-easy", "panda-crowded-accelerated")
    )
    write_situations(tmp_path / "panda.jsonl", [easy, hard])
    assert main(["solve", str(tmp_path / "panda.jsonl"), "--planner", name]) == 2
    out, err = capsys.readouterr()
    assert out == "" and err.count("\n") == 1
    assert "accelerations are limited, which this planner cannot keep; search, recall" in err


def test_a_stop_is_refused_to_arms_without_limits_of_acceleration(tmp_path, capsys):
    write_situations(tmp_path / "panda.jsonl", [families.draw("panda-easy", 0, 0)])
    assert main(["solve", str(tmp_path / "panda.jsonl"), "--end", "rest"]) == 2
    out, err = capsys.readouterr()
    assert out == "" and err.count("\n") == 1
    assert 'panda.jsonl: end: "rest" needs limits of acceleration' in err


@pytest.mark.parametrize("name", ["recall", "hybrid"])
def test_a_memory_of_another_arm_refuses_and_names_the_way_out(name, tmp_path, capsys):
    six = families.family_from_dict({"family": "throw-chain", "arm": {"model": "ur5"}})
    write_situations(tmp_path / "ur5.jsonl", [families.draw(six, 0, 0)])
    assert main(["solve", str(tmp_path / "ur5.jsonl"), "--planner", name]) == 2
    out, err = capsys.readouterr()
    assert out == "" and err.startswith("gcm-learn: ") and ".py" not in err
    assert "holds catches of 7 joints, this arm has 6; `gcm-learn memory make` makes" in err
