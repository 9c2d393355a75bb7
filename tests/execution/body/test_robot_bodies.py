"""Bodies from robots' files: MuJoCo's own reading of a file needs the same torques."""

import numpy as np
import pytest

from gcm_learn.arms import Chain, chain_of, read_robot
from gcm_learn.cli import main
from gcm_learn.execution import body_of_robot
from gcm_learn.execution.body.model import mujoco
from gcm_learn.execution.body.motors import Dynamics
from gcm_learn.situation import read_arm, read_arm_body

BALL = '<collision><geometry><sphere radius="0.05"/></geometry></collision>'


def link(name, mass, centre, turn, moments):
    """A link of a URDF file with a mass."""
    a, b, c = moments
    return f"""<link name="{name}"><inertial><mass value="{mass}"/>
      <origin xyz="{centre}" rpy="{turn}"/>
      <inertia ixx="{a}" ixy="0.001" ixz="-0.002" iyy="{b}" iyz="0.0005" izz="{c}"/></inertial>
      {BALL}</link>"""


URDF = f"""<robot name="arm">
 {link("foot", 5, "0 0 0.1", "0 0 0", (0.1, 0.1, 0.1))}
 {link("upper", 2, "0.1 0 0.2", "0.3 0.2 0.1", (0.03, 0.04, 0.02))}
 {link("slide", 1.5, "0 0.05 0", "0 1 0", (0.02, 0.02, 0.02))}
 {link("palm", 0.5, "0 0 0.03", "0 0 0.4", (0.01, 0.01, 0.008))}
 {link("thumb", 0.2, "0.05 0 0", "0 0 0", (0.005, 0.006, 0.005))}
 <joint name="turn" type="revolute"><parent link="foot"/><child link="upper"/>
  <origin xyz="0 0 0.1" rpy="0.2 0 0.4"/><axis xyz="0 1 0"/>
  <limit lower="-2" upper="2" effort="9" velocity="2"/><dynamics damping="0.3"/></joint>
 <joint name="reach" type="prismatic"><parent link="upper"/><child link="slide"/>
  <origin xyz="0 0 0.4" rpy="0 0.5 0"/><axis xyz="1 0 0"/>
  <limit lower="0" upper="0.3" effort="50" velocity="0.5"/><dynamics damping="2"/></joint>
 <joint name="wrist" type="fixed"><parent link="slide"/><child link="palm"/>
  <origin xyz="0.3 0 0.02" rpy="0.5 0 0.7"/></joint>
 <joint name="grip" type="revolute"><parent link="palm"/><child link="thumb"/>
  <origin xyz="0 0 0.1" rpy="0 1 0"/><axis xyz="0 0 1"/>
  <limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
</robot>"""
MJCF = """<mujoco><compiler autolimits="true"/><worldbody><body name="base">
 <geom type="box" size="0.1 0.1 0.05"/>
 <body name="arm" pos="0 0 0.2" quat="0.8 0 0.6 0">
  <joint name="a" axis="0 0 1" pos="0.02 0.03 0" range="-114 114" armature="0.2" damping="0.4"/>
  <joint name="b" axis="0 1 0" pos="-0.01 0 0.05" range="-57 80" ref="17" armature="0.1"/>
  <geom type="capsule" size="0.04 0.1" pos="0 0 0.1"/>
  <body name="tool" pos="0 0.1 0.3">
   <joint name="c" type="slide" axis="1 0 0" range="0 0.2" actuatorfrcrange="-40 40"/>
   <geom type="cylinder" size="0.03 0.05"/>
  </body></body></body></worldbody>
 <actuator><motor joint="a" gear="-3" ctrlrange="-5 4"/><general joint="b" forcerange="-7 6"/>
  <motor joint="c"/></actuator></mujoco>"""
FILES = {"arm.urdf": ("foot", "palm", 2), "arm.xml": ("base", "tool", 3)}


@pytest.fixture(params=FILES)
def file(request, tmp_path):
    """A robot's file."""
    if request.param == "arm.urdf":
        pytest.importorskip("yourdfpy")
    path = tmp_path / request.param
    path.write_text(URDF if request.param == "arm.urdf" else MJCF, "utf-8")
    return path


def test_a_body_needs_the_torques_of_its_file(file):
    """At random joints, rates and accelerations; joints off the chain stand."""
    base, tip, dof = FILES[file.name]
    at = {"grip": 0.4} if dof == 2 else {}
    fitted = chain_of(read_robot(file), base, tip, max_speed=[2.0], at=at, capsules=1)
    body, rng = body_of_robot(fitted), np.random.default_rng(0)
    arm = Chain(fitted.model, tuple(joint.range[0] for joint in fitted.model.joints), 0.01)
    library = mujoco()
    model = library.MjModel.from_xml_path(str(file))
    model.opt.disableflags |= library.mjtDisableBit.mjDSBL_CONSTRAINT
    data = library.MjData(model)
    for _ in range(10):
        q, rates, forces = rng.uniform(*np.array(arm.joint_range).T), *rng.normal(size=(2, dof))
        data.qpos[:dof], data.qvel[:dof], data.qacc[:dof] = q, rates, forces
        data.qpos[dof:], data.qvel[dof:], data.qacc[dof:] = 0.4, 0.0, 0.0
        library.mj_inverse(model, data)
        found = Dynamics(arm, body).torques(q[None], rates[None], forces[None])[0]
        np.testing.assert_allclose(found, data.qfrc_inverse[:dof], rtol=1e-6, atol=1e-9)


def test_motors_are_those_of_the_file(file):
    base, tip, dof = FILES[file.name]
    fitted = chain_of(read_robot(file), base, tip, max_speed=[2.0], capsules=1)
    motors = body_of_robot(fitted).joints
    wanted = {
        2: [(9.0, 0.0, 0.3), (50.0, 0.0, 2.0)],
        3: [(15.0, 0.2, 0.4), (7.0, 0.1, 0.0), (40.0, 0.0, 0.0)],
    }[dof]
    np.testing.assert_allclose([(m.torque, m.armature, m.damping) for m in motors], wanted)


def test_the_command_writes_the_body(file, tmp_path, capsys):
    base, tip, dof = FILES[file.name]
    body, arm = tmp_path / "body.json", tmp_path / "arm.json"
    command = [
        "arm",
        str(file),
        "--base",
        base,
        "--tip",
        tip,
        "--max-speed",
        "2",
        "--capsules",
        "1",
    ]
    numbers = [*("--torque", *("7",) * dof), "--armature", "0.3"]
    assert main([*command, *numbers, "--body", str(body), "--out", str(arm)]) == 0
    made = read_arm_body(body)
    assert made.name == read_arm(arm).name
    assert made.joints[0].torque == 7.0 and made.joints[-1].armature == 0.3
    assert len(made.frames) == dof + 1 and made.metres == 1.0
    assert main([*command, "--torque", "7"]) == 2
    assert "--torque and --armature: are for --body" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("old", "new", "reason"),
    [
        ('effort="9"', 'effort="0"', "joint 'turn': has no largest torque; give --torque"),
        ('<mass value="2"/>', '<mass value="-2"/>', "frames[1].mass: must not be negative"),
        ('ixx="0.02"', 'ixx="0.9"', "frames[2].inertia: "),
        ('damping="0.3"', 'damping="-1"', "joints[0].damping: must not be negative"),
    ],
)
def test_faults_of_a_file_are_one_line(tmp_path, old, new, reason, capsys):
    pytest.importorskip("yourdfpy")
    file, body = tmp_path / "arm.urdf", tmp_path / "body.json"
    file.write_text(URDF.replace(old, new, 1), "utf-8")
    command = ["arm", str(file), "--base", "foot", "--tip", "palm", "--capsules", "1"]
    assert main([*command, "--body", str(body)]) == 2
    said = capsys.readouterr().err
    assert reason in said and "arm.urdf: " in said and said.count("\n") == 1
    assert not body.exists()


def test_a_file_without_masses_has_no_body(tmp_path, capsys):
    pytest.importorskip("yourdfpy")
    file = tmp_path / "arm.urdf"
    bare = URDF
    while "<inertial>" in bare:
        first, last = bare.index("<inertial>"), bare.index("</inertial>") + len("</inertial>")
        bare = bare[:first] + bare[last:]
    file.write_text(bare, "utf-8")
    command = ["arm", str(file), "--base", "foot", "--tip", "palm", "--capsules", "1"]
    assert main([*command, "--body", str(tmp_path / "body.json")]) == 2
    assert "frames[2].mass: is 0, and so is the joint's armature" in capsys.readouterr().err
