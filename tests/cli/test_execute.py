"""``gcm-learn execute``: a line for each situation, and what fails does not stop the rest."""

from __future__ import annotations

import json
from dataclasses import replace

import pytest

from gcm_learn import execution, situation as records
from gcm_learn.arms import Chain, hands_along
from gcm_learn.cli import main
from gcm_learn.execution import execution_to_json, shipped_bodies
from gcm_learn.families import paper_scene
from gcm_learn.planners import InTube
from tests.policies.conftest import straight_in_space


@pytest.fixture
def file(tmp_path):
    """The paper's pendulum, and the same with an arm that no body fits."""
    scene = paper_scene("fig8-space")
    odd = replace(scene, name="odd", arm=replace(scene.arm, forearm=(0.3, 0.0, 0.0)))
    path = tmp_path / "two.jsonl"
    records.write_situations(path, [odd, scene])
    return path


@pytest.mark.slow
def test_a_line_tells_what_came_of_each(file, tmp_path, capsys):
    out = tmp_path / "done.jsonl"
    assert main(["execute", str(file), "--out", str(out)]) == 0
    first, second, summary = capsys.readouterr().out.splitlines()
    assert first.startswith("odd: no body: body: none that is shipped fits the arm (human: ")
    assert second.startswith("fig8-space: caught 'ball' at 0.6")
    assert "rad/s^2 from the motors of 'nao'" in second
    assert summary == "1 no body, 1 caught"
    odd, caught = (json.loads(line) for line in out.read_text().splitlines())
    assert (odd["status"], odd["catch_time"]) == ("no body", None)
    assert (caught["status"], caught["catch_body"], caught["contact"]) == ("caught", "ball", None)
    assert 0.0 <= caught["error_median"] <= caught["error_max"] < 0.01
    assert len(caught["limits"]) == 4
    assert set(odd) == set(caught)


def test_reports_go_to_standard_output_alone(file, capsys):
    assert main(["execute", str(file), "--out", "-", "--body", "nao"]) == 0
    lines = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    assert [line["name"] for line in lines] == ["odd", "fig8-space"]
    assert all(line["format"] == "gcm-learn/execution@1" for line in lines)


def test_a_file_of_arms_without_a_body_is_bad_input(file, capsys):
    odd = file.with_name("odd.json")
    odd.write_text(file.read_text().splitlines()[0])
    assert main(["execute", str(odd)]) == 2
    out, err = capsys.readouterr()
    assert out.startswith("odd: no body: ") and "no body fits any of the arms" in err


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
    assert "weak.json:1: joints[0].torque: must not be negative" in capsys.readouterr().err


def test_planar_arms_are_refused(scene_file, scene, capsys):
    assert main(["execute", str(scene_file(scene()))]) == 2
    said = capsys.readouterr().err
    assert "has a planar arm, which has no mass; spatial arms and chains are executed" in said


@pytest.fixture
def chains(tmp_path):
    """A Panda beside a ball that comes near, a crane without a body, and the paper's pendulum."""
    panda = Chain(records.shipped_arm("panda"), (0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785), 0.03)
    hand = hands_along(panda, panda.joints)[0][0]
    comes = records.SolidQuadratic(tuple(hand + (0.0, 0.3, 0.1)), (0.0, -0.4, -0.1), (0.0,) * 3)
    ball = records.Body("target", "ball", records.Sphere(0.02), comes)
    other = Chain(records.shipped_arm("planar-2"), (0.3, -0.5), 0.03)
    made = [records.Situation("near", 1.0, panda, (ball,), format="gcm-learn/situation@3")]
    made += [replace(made[0], name="bare", arm=other), paper_scene("fig8-space")]
    path = tmp_path / "three.jsonl"
    records.write_situations(path, made)
    return path


def test_chains_and_spatial_arms_are_executed_side_by_side(chains, capsys):
    """Each by its own planner and the body of its own arm."""
    assert main(["execute", str(chains), "--out", "-"]) == 0
    near, bare, fig8 = (json.loads(line) for line in capsys.readouterr().out.splitlines())
    assert (near["planner"], near["status"], near["body"]) == ("search", "caught", "panda")
    assert near["error_max"] < 5e-4 and len(near["limits"]) == 7
    assert bare["status"] == "no body" and "panda: joints: the arm has 2" in bare["message"]
    assert (fig8["planner"], fig8["status"], fig8["body"]) == ("search", "caught", "nao")
    assert set(near) == set(fig8)


@pytest.mark.slow
def test_a_hold_is_told_beside_a_touch(chains, capsys):
    """The impulse of both, and that the target stays in the hand."""
    near = records.read_situations(chains)[0]
    ball = replace(near.bodies[0], hold=records.Hold(0.1, 0.1))
    arm = replace(near.arm, max_joint_acceleration=(15, 7.5, 10, 12.5, 15, 20, 20))
    held = replace(near, arm=arm, bodies=(ball,), end="rest", format="gcm-learn/situation@4")
    records.write_situations(chains, [held])
    assert main(["execute", str(chains), "--out", str(chains.with_suffix(".out"))]) == 0
    line = capsys.readouterr().out
    assert "gripped at" in line and "; a touch with" in line and "the target stays" in line
    done = json.loads(chains.with_suffix(".out").read_text())
    assert done["held_until"] >= done["planned_catch_time"] + 0.1
    assert 0.0 < 5.0 * done["impulse"] < done["touch_impulse"]
    assert 0.0 < done["impact_torque"] < done["touch_impact_torque"]
    assert done["stays"] is True and done["placed"] is None


@pytest.mark.parametrize(("options", "planned"), [([], 1), (["--no-tube"], 0)])
def test_plans_are_made_in_the_tube_unless_that_is_switched_off(
    options, planned, file, monkeypatch, capsys
):
    asked = []
    plan = InTube.plan
    monkeypatch.setattr(InTube, "plan", lambda self, given: asked.append(1) or plan(self, given))
    assert main(["execute", str(file), "--out", "-", *options]) == 0
    assert len(asked) == planned
    assert json.loads(capsys.readouterr().out.splitlines()[1])["status"] == "caught"


def test_a_chain_without_mass_does_what_was_planned(chains, capsys):
    argv = ["execute", str(chains), "--plant", "kinematic", "--body", "panda", "--out", "-"]
    assert main(argv) == 0
    near, bare, fig8 = (json.loads(line) for line in capsys.readouterr().out.splitlines())
    assert near["status"] == "caught"
    assert near["catch_time"] == pytest.approx(near["planned_catch_time"], abs=1e-3)
    assert [one["status"] for one in (bare, fig8)] == ["no body", "no body"]


def test_films_are_written(file, tmp_path, monkeypatch):
    shown = []
    monkeypatch.setattr(
        "gcm_learn.plots.animate_execution",
        lambda situation, done, path: (shown.append(execution_to_json(done)), path.touch()),
    )
    assert main(["execute", str(file), "--film", str(tmp_path / "films")]) == 0
    assert [path.name for path in (tmp_path / "films").iterdir()] == ["fig8-space.gif"]
    assert [done["status"] for done in shown] == ["caught"]


def test_an_arm_without_mass_does_what_was_planned(file, capsys):
    assert main(["execute", str(file), "--plant", "kinematic", "--out", "-"]) == 0
    done = json.loads(capsys.readouterr().out.splitlines()[1])
    assert done["status"] == "caught"
    assert done["catch_time"] == pytest.approx(done["planned_catch_time"], abs=1e-3)
    assert done["torque"] is None


@pytest.mark.parametrize("plant", ["mujoco", "kinematic"])
def test_a_world_that_is_seen_inexactly_is_planned_for_while_the_arm_moves(file, plant, capsys):
    argv = ["execute", str(file), "--noise", "0.002", "--plant", plant, "--out", "-"]
    assert main(argv) == 0
    odd, done = (json.loads(line) for line in capsys.readouterr().out.splitlines())
    assert odd["status"] == "no body"
    assert done["status"] in ("caught", "collided", "late")  # thinking takes real time
    assert done["planned_catch_time"] is None


@pytest.mark.parametrize("late", ["0", "20", "20ms"])
def test_percepts_and_commands_may_come_late(late, file, monkeypatch, capsys):
    seen = []
    loop = execution.Loop
    monkeypatch.setattr(execution, "Loop", lambda *a, **b: seen.append(loop(*a, **b)) or seen[-1])
    argv = ["execute", str(file), "--latency", late, "--plant", "kinematic", "--out", "-"]
    assert main(argv) == 0
    done = json.loads(capsys.readouterr().out.splitlines()[1])
    assert done["status"] in ("caught", "collided", "late")  # thinking takes real time
    expected = 0.0 if late == "0" else 0.02
    assert (seen[0].latency, seen[0].perception.latency) == (expected, expected)
    assert seen[0].perception.place == 0.0


@pytest.mark.slow
@pytest.mark.parametrize("planner", ["recall", "hybrid"])
@pytest.mark.parametrize("noise", ["0", "0.002"])
def test_who_recalls_moves_arms_with_mass(planner, noise, tmp_path, capsys):
    file = tmp_path / "near.json"
    scene = paper_scene("fig8-space")
    still = replace(
        scene.targets[0], motion=records.SolidQuadratic((0.17, 0.08, 0.0), (0.0,) * 3, (0.0,) * 3)
    )
    records.write_situations(file, [replace(scene, bodies=(still, *scene.obstacles))])
    argv = ["execute", str(file), "--planner", planner, "--noise", noise, "--out", "-"]
    assert main(argv) == 0
    done = json.loads(capsys.readouterr().out)
    assert (done["planner"], done["status"]) == (planner, "caught")
    assert (done["planned_catch_time"] is None) == (noise != "0")


@pytest.fixture
def actor(tmp_path, monkeypatch):
    """The name of an actor of the user's own that goes straight."""
    folder = tmp_path / "models" / "goes-straight"
    folder.mkdir(parents=True)
    straight_in_space().save(folder)
    monkeypatch.setenv("GCM_LEARN_MODELS", str(tmp_path / "models"))
    return "goes-straight"


@pytest.mark.parametrize(
    ("plant", "noise"),
    [pytest.param("mujoco", "0", marks=pytest.mark.slow), ("kinematic", "0.002")],
)
def test_a_policy_acts_by_what_is_seen(file, actor, plant, noise, capsys):
    argv = ["execute", str(file), "--planner", actor, "--plant", plant, "--noise", noise]
    assert main([*argv, "--out", "-"]) == 0
    odd, done = (json.loads(line) for line in capsys.readouterr().out.splitlines())
    assert odd["status"] == "no body"
    assert (done["planner"], done["planned_catch_time"]) == (actor, None)
    assert done["status"] in ("caught", "collided", "late")  # thinking takes real time


@pytest.mark.slow
def test_a_policy_can_be_tried_out_first(file, actor, capsys):
    assert main(["execute", str(file), "--planner", f"{actor}@1", "--out", "-"]) == 0
    done = json.loads(capsys.readouterr().out.splitlines()[1])
    assert done["status"] in ("caught", "no plan")


REFUSED = [
    ("--planner nobody", "planner: 'nobody' is not one of covered"),
    ("--planner clone", "--planner clone: an actor in the closed loop does not take planar arms"),
    ("--planner goes-straight --replan once", "--replan once: a policy acts anew in every period"),
    ("--planner gcm", "does not take spatial arms"),
    ("--latency -1", "-1: must be at least 0"),
    ("--latency soon", "--latency: no number: 'soon'"),
    ("--plant kinematic --film films", "--film: is of arms with mass"),
    ("--body none.json", "none.json: cannot be read"),
]


@pytest.mark.usefixtures("actor")
@pytest.mark.parametrize(("options", "said"), REFUSED)
def test_what_makes_no_sense_is_one_line(options, said, file, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(["execute", str(file), *options.split()]) == 2
    err = capsys.readouterr().err
    assert said in err and err.count("\n") == 1
