"""Arms from URDF and MJCF: kinematics of other readers, capsules that enclose, refusals."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from gcm_learn.arms import SpatialArm, chain_of, frames_at, hands_along, read_robot
from gcm_learn.cli import main
from gcm_learn.errors import RobotError
from gcm_learn.families.space.arms import HUMAN, NAO
from gcm_learn.referee import examine
from gcm_learn.situation import (
    arm_names,
    arm_to_json,
    read_arm,
    read_situations,
    shipped_arm,
    situation_to_json,
)
from tests.motion.controllers import franka_fault, read_table

URDF = """<robot name="elbow">
 <link name="world"/>
 <link name="foot"><collision><origin xyz="0 0 0.05"/>
   <geometry><box size="0.3 0.2 0.1"/></geometry></collision></link>
 <link name="upper"><collision><origin xyz="0 0 0.2" rpy="0 0.1 0"/>
   <geometry><cylinder radius="0.05" length="0.4"/></geometry></collision></link>
 <link name="slide"><collision><geometry><sphere radius="0.06"/></geometry></collision></link>
 <link name="fore"><collision><origin xyz="0.1 0 0" rpy="0.3 0.2 0.1"/>
   <geometry><mesh filename="package://elbow/fore.stl" scale="2 1 1"/></geometry></collision></link>
 <link name="palm"/>
 <link name="thumb"><collision><origin xyz="0.05 0 0"/>
   <geometry><box size="0.1 0.02 0.02"/></geometry></collision></link>
 <link name="finger"><collision><origin xyz="0.05 0 0"/>
   <geometry><box size="0.1 0.02 0.02"/></geometry></collision></link>
 <joint name="stand" type="fixed"><parent link="world"/><child link="foot"/>
   <origin xyz="1 0 0" rpy="0 0 1"/></joint>
 <joint name="turn" type="continuous"><parent link="foot"/><child link="upper"/>
   <origin xyz="0 0 0.1" rpy="0.2 0 0.4"/><axis xyz="0 0 2"/>
   <limit effort="9" velocity="2"/></joint>
 <joint name="reach" type="prismatic"><parent link="upper"/><child link="slide"/>
   <origin xyz="0 0 0.4" rpy="0 0.5 0"/><axis xyz="1 0 0"/>
   <limit lower="0.1" upper="0.3" effort="9" velocity="0.5"/></joint>
 <joint name="bend" type="revolute"><parent link="slide"/><child link="fore"/>
   <origin xyz="0.1 0 0"/><axis xyz="0 1 0"/>
   <limit lower="-2" upper="2" effort="9" velocity="3"/></joint>
 <joint name="wrist" type="fixed"><parent link="fore"/><child link="palm"/>
   <origin xyz="0.3 0 0.02" rpy="0 0 0.7"/></joint>
 <joint name="grip" type="revolute"><parent link="palm"/><child link="thumb"/>
   <axis xyz="0 0 1"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
 <joint name="follow" type="revolute"><parent link="palm"/><child link="finger"/>
   <axis xyz="0 0 1"/><limit lower="-1" upper="1" effort="1" velocity="1"/>
   <mimic joint="grip" multiplier="-1" offset="0.1"/></joint>
</robot>
"""
MJCF = """<mujoco><worldbody><body name="base" pos="0.1 0 0">
 <geom type="box" size="0.1 0.1 0.05"/>
 <body name="arm" pos="0 0 0.2" quat="0.8 0 0.6 0">
  <joint name="a" axis="0 0 1" pos="0.02 0.03 0" range="-2 2" limited="true"/>
  <joint name="b" axis="0 1 0" pos="-0.01 0 0.05" range="-1 1.5" limited="true" ref="0.3"/>
  <geom type="capsule" size="0.04 0.1" pos="0 0 0.1"/>
  <geom type="sphere" size="0.5" contype="0" conaffinity="0"/>
  <body name="tool" pos="0 0.1 0.3">
   <joint name="c" type="slide" axis="1 0 0" range="0 0.2" limited="true"/>
   <geom type="cylinder" size="0.03 0.05"/>
  </body></body></body></worldbody></mujoco>"""
POINT = (0.05, 0.01, -0.02)


def elbow_in(place):
    trimesh = pytest.importorskip("trimesh")
    folder = place / "elbow" / "urdf"
    folder.mkdir(parents=True)
    trimesh.creation.icosphere(radius=0.08, subdivisions=2).export(place / "elbow" / "fore.stl")
    (folder / "elbow.urdf").write_text(URDF, "utf-8")
    return folder / "elbow.urdf"


@pytest.fixture
def elbow(tmp_path):
    pytest.importorskip("yourdfpy")
    return elbow_in(tmp_path)


@pytest.fixture(scope="module")
def fitted(tmp_path_factory):
    robot = read_robot(elbow_in(tmp_path_factory.mktemp("elbow")))
    return chain_of(robot, "foot", "palm", point=POINT, at={"grip": 0.4}, capsules=2)


def hands(model, joints):
    rotations, places = frames_at(model, joints)
    k, point = model.hand.joint, np.array(model.hand.point)
    return rotations[k] @ point + places[k], rotations[k] @ np.array(model.hand.axis)


def postures(model, count=20):
    low, high = np.array([joint.range for joint in model.joints]).T
    return np.random.default_rng(0).uniform(low, high, (count, model.dof))


def test_the_hand_is_where_yourdfpy_has_it(elbow, fitted):
    from yourdfpy import URDF as Reader

    robot = Reader.load(str(elbow), load_meshes=False, load_collision_meshes=False)
    model = fitted.model
    assert [joint.name for joint in model.joints] == ["turn", "reach", "bend"]
    assert [joint.max_speed for joint in model.joints] == [2.0, 0.5, 3.0]
    assert model.joints[0].range == pytest.approx((-2 * np.pi, 2 * np.pi))
    joints = postures(model)
    places, axes = hands(model, joints)
    for values, place, axis in zip(joints, places, axes, strict=True):
        robot.update_cfg({"turn": values[0], "reach": values[1], "bend": values[2], "grip": 0.4})
        pose = robot.get_transform("palm", "foot")
        np.testing.assert_allclose(place, pose[:3, :3] @ POINT + pose[:3, 3], atol=1e-9)
        np.testing.assert_allclose(axis, pose[:3, 2], atol=1e-9)


def test_the_hand_is_where_mujoco_has_it(tmp_path):
    mujoco = pytest.importorskip("mujoco")
    file = tmp_path / "arm.xml"
    file.write_text(MJCF, "utf-8")
    fitted = chain_of(read_robot(file), "base", "tool", point=POINT, max_speed=[2.0], capsules=1)
    model = mujoco.MjModel.from_xml_path(str(file))
    data = mujoco.MjData(model)
    assert [joint.type for joint in fitted.model.joints] == ["revolute", "revolute", "prismatic"]
    assert [cover.link for cover in fitted.covers] == ["base", "arm", "tool"]
    joints = postures(fitted.model)
    places, axes = hands(fitted.model, joints)
    base = np.array([0.1, 0.0, 0.0])
    for values, place, axis in zip(joints, places, axes, strict=True):
        data.qpos[:] = values
        mujoco.mj_kinematics(model, data)
        turn = data.body("tool").xmat.reshape(3, 3)
        there = turn @ POINT + data.body("tool").xpos - base
        np.testing.assert_allclose(place, there, atol=1e-9)
        np.testing.assert_allclose(axis, turn[:, 2], atol=1e-9)


def inside(capsules, points):
    """Return how far points (n, 3) lie beyond the nearest of some links of a model."""
    gaps = []
    for link in capsules:
        a, b = np.array(link.start), np.array(link.end)
        share = (points - a) @ (b - a) / max(float((b - a) @ (b - a)), 1e-30)
        near = a + np.clip(share, 0.0, 1.0)[:, None] * (b - a)
        gaps.append(np.linalg.norm(points - near, axis=1) - link.radius)
    return np.min(gaps, axis=0)


def test_capsules_hold_the_geometry_of_all_links(elbow, fitted):
    """Points of yourdfpy's collision scene, at a posture, in the frames that carry them."""
    from yourdfpy import URDF as Reader

    robot = Reader.load(
        str(elbow), load_meshes=False, build_collision_scene_graph=True,
        load_collision_meshes=True, filename_handler=lambda fname: elbow.parents[1] / "fore.stl",
    )  # fmt: skip
    model, values = fitted.model, postures(fitted.model, 1)
    robot.update_cfg(
        {"turn": values[0, 0], "reach": values[0, 1], "bend": values[0, 2], "grip": 0.4}
    )
    rotations, places = frames_at(model, values)
    from_world = np.linalg.inv(robot.get_transform("foot", collision_geometry=True))
    carrier = {cover.link: cover.joint for cover in fitted.covers}
    assert carrier == {"foot": 0, "upper": 1, "slide": 2, "fore": 3, "thumb": 3, "finger": 3}
    found = 0
    for name in robot.collision_scene.graph.nodes_geometry:
        pose, mesh = robot.collision_scene.graph[name]
        points = robot.collision_scene.geometry[mesh].sample(300)
        points = points @ pose[:3, :3].T + pose[:3, 3]
        points = points @ from_world[:3, :3].T + from_world[:3, 3]
        beyond = np.full(len(points), np.inf)
        for k in range(model.dof + 1):
            held = (points - places[k, 0]) @ rotations[k, 0]
            links = [link for link in model.links if link.joint == k]
            if links:
                beyond = np.minimum(beyond, inside(links, held))
        assert beyond.max() < 1e-9
        found += 1
    assert found == 6


def test_capsules_bear_the_names_of_their_links(fitted):
    names = [link.name for link in fitted.model.links]
    assert names == [cover.link for cover in fitted.covers for _ in range(cover.capsules)]


def test_every_capsule_reaches_as_far_as_what_it_holds(fitted):
    directions = np.random.default_rng(1).normal(size=(500, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    for link, hulls in zip(fitted.model.links, fitted.parts, strict=True):
        ends = np.maximum(directions @ np.array(link.start), directions @ np.array(link.end))
        held = [(directions @ hull.centres.T + hull.radii).max(axis=1) for hull in hulls]
        assert np.min(ends + link.radius - np.max(held, axis=0)) > 0.0


def test_spheres_stay_what_they_are(fitted):
    slide = next(k for k, link in enumerate(fitted.model.links) if link.joint == 2)
    assert fitted.model.links[slide].radius == pytest.approx(0.06, abs=1e-5)
    assert fitted.covers[2].overhang < 1e-5


def test_the_command_writes_an_arm_that_is_read_again(elbow, tmp_path, capsys):
    out, picture = tmp_path / "arm.json", tmp_path / "arm.png"
    command = ["arm", str(elbow), "--base", "foot", "--tip", "palm", "--at", "grip=0.4"]
    command += ["--point", *map(str, POINT), "--capsules", "1"]
    assert main([*command, "--out", str(out), "--plot", str(picture)]) == 0
    assert "elbow: 3 joints" in capsys.readouterr().out and picture.stat().st_size > 5000
    model = read_arm(out)
    given = {"point": POINT, "at": {"grip": 0.4}, "capsules": 1}
    same = chain_of(read_robot(elbow), "foot", "palm", **given)
    assert model == same.model
    limits = ["--max-acceleration", "9", "--max-jerk", "40", "50", "60"]
    assert main([*command, *limits, "--out", str(out)]) == 0
    assert [joint.max_jerk for joint in read_arm(out).joints] == [40.0, 50.0, 60.0]
    capsys.readouterr()
    assert main(command) == 0
    assert json.loads(capsys.readouterr().out) == arm_to_json(model)


@pytest.mark.parametrize(
    ("how", "reason"),
    [
        ({"base": "feet"}, "base: there is no link 'feet' (known: world, foot, upper"),
        ({"tip": "world"}, "tip: 'world' does not hang from 'foot'"),
        ({"tip": "foot"}, "no joint moves between 'foot' and 'foot'"),
        ({"at": {"bend": 1.0}}, "at: joint 'bend' is one of the chain's"),
        ({"at": {"wrist": 1.0}}, "at: there is no joint 'wrist' that moves"),
        ({"max_speed": [1.0, 2.0]}, "max_speed: must have 1 or 3 numbers, for turn, reach, bend"),
    ],
)
def test_what_makes_no_chain_is_refused(elbow, how, reason):
    given = {"base": "foot", "tip": "palm"} | how
    with pytest.raises(RobotError) as error:
        chain_of(read_robot(elbow), given.pop("base"), given.pop("tip"), **given)
    assert reason in str(error.value) and "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("old", "new", "reason"),
    [
        ("fore.stl", "none.stl", "package://elbow/none.stl: is not found"),
        ("package://elbow/fore.stl", "fore.ply", "only meshes of stl, obj, dae are read"),
        ("package://elbow/fore.stl", "fore.stl", "link 'fore': fore.stl: is not there"),
        ('xyz="0 0 2"', 'xyz="0 0 0"', "joint 'turn': its axis has no length"),
        ('<child link="palm"/>', '<child link="paw"/>', "joint 'wrist': there is no link 'paw'"),
        ('velocity="3"', "", "joint 'bend': has no largest speed; give --max-speed"),
        ('type="prismatic"', 'type="floating"', "joint 'reach': is floating, which a chain cannot"),
        ("<robot", "<robo", "is not XML"),
        ('xyz="0 0 0.4"', 'xyz="0 0 nan"', "joint 'reach': origin.xyz: must be 3 finite numbers"),
        ('xyz="0 0 0.4"', 'xyz="0 0"', "joint 'reach': origin.xyz: must be 3 finite numbers"),
        ('xyz="0 0 0.4"', 'xyz="a b c"', "joint 'reach': origin.xyz: must be 3 finite numbers"),
        ('rpy="0.2 0 0.4"', 'rpy="inf 0 0"', "joint 'turn': origin.rpy: must be 3 finite numbers"),
        ('upper="0.3"', 'upper="inf"', "joint 'reach': limit.upper: must be a finite number"),
        ('velocity="3"', 'velocity="fast"', "joint 'bend': limit.velocity: must be a finite"),
        ('velocity="3"', 'velocity="-3"', "joint 'bend': max_speed: must be positive (got -3.0)"),
        ('lower="-2" upper="2"', 'lower="2" upper="-2"', "joint 'bend': range: low 2.0 is above"),
        ('<parent link="slide"/>', "", "joint 'bend': has no parent"),
        (' type="prismatic"', "", "joint 'reach': has no type"),
        ('name="bend"', 'name="turn"', "joint 'turn': is there twice"),
        ('name="palm"', 'name="fore"', "link 'fore': is there twice"),
        ('<link name="palm"/>', "<link/>", "link: one has no name"),
        ('mimic joint="grip"', 'mimic joint="grop"', "mimic.joint: there is no joint 'grop'"),
        ('multiplier="-1"', 'multiplier="nan"', "joint 'follow': mimic.multiplier: must be a"),
        ('radius="0.05"', 'radius="-1"', "link 'upper': cylinder.radius: must not be negative"),
        ('radius="0.05"', 'radius="nan"', "link 'upper': cylinder.radius: must be a finite number"),
        ('radius="0.05" ', "", "link 'upper': cylinder.radius: is missing"),
        ('"0.3 0.2 0.1"', '"0.3 -1 0.1"', "link 'foot': box.size: must not be negative"),
        ('lower="-2" upper="2"', "", "joint 'bend': has no range; give its limits, or make its"),
        ('lower="0.1" upper="0.3"', "", "joint 'reach': has no range; give its limits"),
        ('"0.3 0.2 0.1"', '"0.3 0.2"', "link 'foot': box.size: must be 3 finite numbers"),
        ('<box size="0.3 0.2 0.1"/>', "", "link 'foot': collision.geometry: must be one of box"),
        (
            '<box size="0.3 0.2 0.1"/>',
            "<cone/>",
            "must be one of box, sphere, cylinder, capsule, mesh (got c",
        ),
        ('scale="2 1 1"', 'scale="0 1 1"', "link 'fore': mesh.scale: must not be 0"),
        ('scale="2 1 1"', 'scale="2 1"', "link 'fore': mesh.scale: must be 3 finite numbers"),
        ('filename="package://elbow/fore.stl"', "", "link 'fore': mesh.filename: is missing"),
        (URDF, "", "is not XML"),
        (URDF[600:], "", "is not XML"),
        (URDF, "<html/>", "is no URDF (<robot>) and no MJCF (<mujoco>): begins with <html>"),
    ],
)
def test_files_with_faults_are_refused_by_name(elbow, tmp_path, old, new, reason, capsys):
    elbow.write_text(URDF.replace(old, new, 1), "utf-8")
    out, body = tmp_path / "arm.json", tmp_path / "body.json"
    command = ["arm", str(elbow), "--base", "foot", "--tip", "palm"]
    assert main([*command, "--out", str(out), "--body", str(body)]) == 2
    said = capsys.readouterr().err
    assert reason in said and said.count("\n") == 1 and "elbow.urdf: " in said
    assert not out.exists() and not body.exists()


@pytest.mark.parametrize(
    ("more", "reason"),
    [
        (["--out", "no/arm.json"], "--out no/arm.json: No such file or directory"),
        (["--out", "arm.json", "--body", "no/b.json"], "--body no/b.json: No such file"),
        (["--out", "arm.json", "--plot", "no/a.png"], "--plot no/a.png: No such file"),
        (["--out", "arm.json", "--body", "arm.json"], "--body arm.json: is the file of --out, too"),
        (["--out", "elbow/urdf/elbow.urdf"], "elbow.urdf: is the file of FILE, too"),
        (["--body", "elbow/urdf/elbow.urdf"], "elbow.urdf: is the file of FILE, too"),
        (["--out", "arm.json", "--at", "grip=9"], "at: joint 'grip' stands from -1 to 1 (got 9)"),
        (["--at", "grip=0.1", "--at", "grip=0.2"], "--at grip=0.2: joint 'grip' is given twice"),
        (["--out", "arm.json", "--packages", "no"], "--packages no: is no folder"),
        (["--out", "arm.json", "--max-speed", "nan"], "joint 'turn': max_speed: must be finite"),
        (["--out", "arm.json", "--point", "1e300", "0", "0"], "elbow.urdf: point[0]: is too large"),
    ],
)  # fmt: skip
def test_a_command_that_fails_writes_nothing(elbow, tmp_path, monkeypatch, capsys, more, reason):
    """Neither the arm nor its body; the robot is as it was."""
    monkeypatch.chdir(tmp_path)
    spread = 'ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"'
    masses = f'<inertial><mass value="1"/><inertia {spread}/></inertial>'
    heavy = re.sub(r'(<link name="(?!world|palm)\w+">)', rf"\1{masses}", URDF)
    elbow.write_text(heavy.replace('<link name="palm"/>', f'<link name="palm">{masses}</link>'))
    before = {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()}
    command = ["arm", str(elbow), "--base", "foot", "--tip", "palm", "--capsules", "1"]
    body = [] if "--body" in more else ["--body", "body.json"]
    assert main([*command, *body, *more]) == 2
    out, said = capsys.readouterr()
    assert reason in said and said.count("\n") == 1 and out == ""
    assert {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()} == before


def test_an_mjcf_with_a_place_that_is_no_number_is_refused(tmp_path, monkeypatch, capfd):
    """MuJoCo only warns, and would write a log."""
    pytest.importorskip("mujoco")
    monkeypatch.chdir(tmp_path)
    (tmp_path / "arm.xml").write_text(MJCF.replace('pos="0 0 0.2"', 'pos="0 0 nan"'))
    assert main(["arm", "arm.xml", "--base", "base", "--tip", "tool", "--max-speed", "1"]) == 2
    out, said = capfd.readouterr()
    assert "arm.xml: joint 'a': its place or direction is not finite" in said
    assert out == "" and said.count("\n") == 1 and len(list(tmp_path.iterdir())) == 1


@pytest.mark.slow
def test_the_how_to_runs(elbow, tmp_path, monkeypatch, capsys):
    page = Path(__file__).parents[2] / "docs" / "robots.md"
    command, *_ = re.findall(r"^```bash\n(.*?)^```", page.read_text("utf-8"), re.M | re.S)
    examples = re.findall(r"^```python\n(.*?)^```", page.read_text("utf-8"), re.M | re.S)
    promised = re.findall(r"^```text\n(.*?)^```", page.read_text("utf-8"), re.M | re.S)
    monkeypatch.chdir(tmp_path)
    assert main(command.replace("robot.urdf", str(elbow)).split()[1:]) == 0
    names: dict = {"__name__": "example"}
    for example, text in zip(examples, promised, strict=True):
        capsys.readouterr()
        exec(compile(example, str(page), "exec"), names)
        assert capsys.readouterr().out == text


@pytest.mark.slow
def test_the_way_from_a_measured_room_to_a_trajectory(elbow, tmp_path, monkeypatch, rng):
    """The commands of docs/world.md, among points on a ball and on a wall."""
    page = Path(__file__).parents[2] / "docs" / "world.md"
    text = page.read_text("utf-8")
    scene, *_ = re.findall(r"^```json\n(.*?)^```", text, re.M | re.S)
    commands, *_ = re.findall(r"^```bash\n(.*?)^```", text, re.M | re.S)
    monkeypatch.chdir(tmp_path)
    Path("scene.json").write_text(scene, "utf-8")
    ball = rng.normal(size=(3000, 3))
    ball = 0.1 * ball / np.linalg.norm(ball, axis=1)[:, None] + (0.7, 0.3, 0.2)
    wall = rng.uniform((0.9, -1.0, 0.0), (0.91, 1.0, 1.0), (3000, 3))
    head = "ply\nformat ascii 1.0\nelement vertex 6000\n"
    head += "".join(f"property float {axis}\n" for axis in "xyz") + "end_header\n"
    rows = (" ".join(map(str, row)) for row in np.concatenate([ball, wall]))
    Path("room.ply").write_text(head + "\n".join(rows) + "\n", "utf-8")
    for command in commands.replace("robot.urdf", str(elbow)).splitlines():
        assert main(command.split()[1:]) == 0
    (situation,) = read_situations("room.jsonl")
    (room,) = (body for body in situation.bodies if body.role == "obstacle")
    assert room.shape.kind == "cloud" and len(room.shape.points) < 3000
    answer = json.loads(Path("answer.jsonl").read_text("utf-8"))
    assert answer["status"] == "caught"
    assert not examine(situation_to_json(situation), answer).complaints
    assert Path("moves/room.yaml").is_file()


@pytest.mark.slow
def test_the_pick_of_the_how_to_is_placed_and_runs_at_a_kilohertz(tmp_path, monkeypatch):
    page = Path(__file__).parents[2] / "docs" / "robots.md"
    (scene,) = re.findall(r"^```json\n(.*?)^```", page.read_text("utf-8"), re.M | re.S)
    monkeypatch.chdir(tmp_path)
    panda = shipped_arm("panda")
    limits = zip(panda.joints, (15.0, 7.5, 10.0, 12.5, 15.0, 20.0, 20.0), strict=True)
    joints = tuple(replace(j, max_acceleration=a, max_jerk=500.0 * a) for j, a in limits)
    Path("arm.json").write_text(json.dumps(arm_to_json(replace(panda, joints=joints))), "utf-8")
    Path("scene.json").write_text(scene, "utf-8")
    asked = ["--trajectories", "moves", "--as", "csv", "--rate", "1000", "--out", "answer.jsonl"]
    assert main(["solve", "scene.json", *asked]) == 0
    answer = json.loads(Path("answer.jsonl").read_text("utf-8"))
    (situation,) = read_situations("scene.json")
    assert answer["catches"][0]["placed"] > answer["catches"][0]["held_until"]
    assert not examine(situation_to_json(situation), answer).complaints
    assert franka_fault(read_table(Path("moves/my-belt.csv").read_text("utf-8"))) is None


@pytest.mark.parametrize(("name", "build"), [("nao", NAO), ("human", HUMAN)])
def test_arms_with_four_joints_ship_as_chains(name, build):
    """Their hands are where those of the spatial arms are."""
    model, joints = shipped_arm(name), postures(shipped_arm(name))
    arm = SpatialArm(
        upper_arm=build.upper_arm, forearm=build.forearm, joints=tuple(joints[0]),
        joint_range=build.joint_range, max_joint_speed=build.max_joint_speed, grasp=build.grasp,
    )  # fmt: skip
    there = build.metres * hands_along(arm, joints)[0]
    np.testing.assert_allclose(hands(model, joints)[0], there, atol=1e-6)
    assert [joint.range for joint in model.joints] == list(build.joint_range)


@pytest.mark.parametrize("name", arm_names())
def test_arms_that_ship_say_where_their_numbers_come_from(name):
    assert shipped_arm(name).source and shipped_arm(name).name == name
