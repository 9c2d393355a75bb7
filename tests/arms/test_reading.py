"""What robots' files mean: units, soft limits, looks, packages, and what is left out by name."""

from __future__ import annotations

import numpy as np
import pytest

from gcm_learn.arms import chain_of, read_robot
from gcm_learn.arms.robots import tree
from gcm_learn.cli import main
from gcm_learn.errors import RobotError

BOX = '<geometry><box size="0.4 0.05 0.05"/></geometry>'
COVER = f'<collision><origin xyz="0.2 0 0"/>{BOX}</collision>'
LOOKS = f'<visual><origin xyz="0.2 0 0"/>{BOX}</visual>'
LIMIT = '<limit lower="-2" upper="2" velocity="2" effort="10"/>'
URDF = """<robot name="small"><link name="base"/>
<link name="one">{one}</link><link name="two">{two}</link>
<joint name="a" type="{kind}"><parent link="base"/><child link="one"/>
 <origin xyz="0 0 0.1"/><axis xyz="0 0 1"/>{limit}</joint>
<joint name="b" type="revolute"><parent link="one"/><child link="two"/>
 <origin xyz="0.4 0 0"/><axis xyz="0 0 1"/>
 <limit lower="-2" upper="2" velocity="2" effort="10"/></joint>
</robot>"""
DAE = """<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><created>2020-01-01T00:00:00</created><modified>2020-01-01T00:00:00</modified>
{unit}<up_axis>{up}</up_axis></asset>
<library_geometries><geometry id="g"><mesh>
<source id="s"><float_array id="f" count="12">0 0 0 {l} 0 0 0 {l} 0 0 0 {h}</float_array>
<technique_common><accessor source="#f" count="4" stride="3"><param name="X" type="float"/>
<param name="Y" type="float"/><param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#s"/></vertices>
<triangles count="4"><input semantic="VERTEX" source="#v" offset="0"/>
<p>0 1 2 0 1 3 0 2 3 1 2 3</p></triangles></mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="scene"><node id="n">
<translate>0 0 {l}</translate><instance_geometry url="#g"/></node></visual_scene>
</library_visual_scenes><scene><instance_visual_scene url="#scene"/></scene></COLLADA>"""


@pytest.fixture
def robot(tmp_path):
    """Return a function that writes a robot of two links, reads it and keeps what it is told."""

    def made(*, name="small.urdf", whole=None, visual=False, packages=(), **changes):
        parts = {"one": COVER, "two": COVER, "kind": "revolute", "limit": LIMIT} | changes
        (tmp_path / name).write_text(whole or URDF.format(**parts), "utf-8")
        return read_robot(tmp_path / name, packages, visual)

    return made


def refused(make, **changes) -> str:
    """Return the one line with which a file is refused."""
    with pytest.raises(RobotError) as error:
        chain_of(make(**changes), "base", "two")
    assert "\n" not in str(error.value)
    return str(error.value)


def told(robot) -> list[str]:
    """Return the remarks on a robot whose joints are all the arm's."""
    return list(robot.remarks({joint.name for joint in robot.joints}))


def corner(robot, link="one"):
    """Return the largest coordinates of a link's geometry (3,)."""
    hulls = robot.links[link].hulls
    return np.max([(h.centres + h.radii[:, None]).max(axis=0) for h in hulls], axis=0)


@pytest.mark.parametrize(
    ("unit", "metres"),
    [
        ('<unit name="centimeter" meter="0.01"/>', 0.01),
        ('<unit name="inch" meter="0.0254"/>', 0.0254),
        ('<unit name="meter" meter="1"/>', 1.0),
        ('<unit name="meter"/>', 1.0),
        ("", 1.0),
    ],
)
@pytest.mark.parametrize("up", ["Z_UP", "Y_UP"])
def test_collada_has_its_unit_and_is_not_turned(robot, tmp_path, unit, metres, up):
    """As in rviz and Gazebo; the scale of the URDF and the places of nodes count, too."""
    pytest.importorskip("trimesh")
    text = DAE.format(unit=unit, up=up, l=0.4 / metres, h=0.1 / metres)
    (tmp_path / "bar.dae").write_text(text, "utf-8")
    mesh = '<collision><geometry><mesh filename="bar.dae" scale="1 1 2"/></geometry></collision>'
    np.testing.assert_allclose(corner(robot(one=mesh)), (0.4, 0.4, 1.0), atol=1e-9)


@pytest.mark.parametrize("meter", ["0", "-1", "nan", "inf", "small"])
def test_a_unit_that_is_none_is_refused(robot, tmp_path, meter):
    pytest.importorskip("trimesh")
    text = DAE.format(unit=f'<unit meter="{meter}"/>', up="Z_UP", l=1, h=1)
    (tmp_path / "bar.dae").write_text(text, "utf-8")
    mesh = '<collision><geometry><mesh filename="bar.dae"/></geometry></collision>'
    said = refused(robot, one=mesh)
    assert "link 'one': bar.dae: its unit is" in said or "bar.dae: cannot be read (" in said


@pytest.mark.parametrize(("size", "hint"), [("40 1 1", True), ("0.4 0.3 0.3", False)])
def test_a_link_that_is_much_longer_than_its_joints_is_a_hint(robot, size, hint):
    given = f'<collision><geometry><box size="{size}"/></geometry></collision>'
    said = told(robot(one=given))
    assert said == (["one: 40 long, joints 0.4 apart; is the unit right?"] if hint else [])


def test_links_that_are_only_seen_are_named_or_taken(robot):
    seen = robot(two=LOOKS)
    assert not seen.links["two"].hulls
    assert told(seen) == ["no collision geometry: two; --visual takes their looks"]
    taken = robot(two=LOOKS, one=COVER + LOOKS.replace("0.4 0", "9 9"), visual=True)
    np.testing.assert_allclose(corner(taken, "two"), (0.4, 0.025, 0.025))
    np.testing.assert_allclose(corner(taken, "one"), (0.4, 0.025, 0.025))
    assert told(taken) == [] == told(robot(two=""))
    assert "has no collision geometry; try --visual" in refused(robot, one=LOOKS, two=LOOKS)


def test_looks_are_not_checked_unless_they_are_taken(robot):
    odd = LOOKS.replace('size="0.4 0.05 0.05"', 'size="big"')
    robot(two=odd)
    assert "link 'two': box.size: must be 3 finite" in refused(robot, two=odd, visual=True)


def test_the_command_tells_and_takes_looks(tmp_path, capsys):
    file, out = tmp_path / "small.urdf", tmp_path / "arm.json"
    file.write_text(URDF.format(one=COVER, two=LOOKS, kind="revolute", limit=LIMIT), "utf-8")
    command = ["arm", str(file), "--base", "base", "--tip", "two", "--capsules", "1"]
    command += ["--out", str(out)]
    assert main(command) == 0
    said = capsys.readouterr().out
    assert "2 joints, 1 capsules" in said and "  no collision geometry: two; --visual" in said
    assert main([*command, "--visual"]) == 0
    assert "2 joints, 2 capsules" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("soft", "bounds"),
    [
        ('soft_lower_limit="-1.5" soft_upper_limit="1.5"', (-1.5, 1.5)),
        ('soft_lower_limit="-3" soft_upper_limit="1"', (-2.0, 1.0)),
        ('soft_lower_limit="-1"', (-1.0, 0.0)),
        ('soft_lower_limit="-3" soft_upper_limit="3"', (-2.0, 2.0)),
        ("", (-2.0, 2.0)),
    ],
)
def test_ranges_are_the_narrower_of_both_limits(robot, soft, bounds):
    read = robot(limit=f'{LIMIT}<safety_controller k_velocity="10" {soft}/>')
    assert read.joints[0].range == bounds
    if bounds == (-2.0, 2.0):
        assert told(read) == []
    else:
        assert told(read) == [f"a: from {bounds[0]:g} to {bounds[1]:g} by its soft limits"]


def test_soft_limits_that_leave_nothing_are_refused(robot):
    soft = '<safety_controller k_velocity="1" soft_lower_limit="3" soft_upper_limit="4"/>'
    said = refused(robot, limit=LIMIT + soft)
    assert "joint 'a': safety_controller: 3 to 4 leaves it no range" in said
    low = soft.replace('"3"', '"-4"').replace('="4"', '="-3"')
    assert "joint 'a': safety_controller: -4 to -3 leaves" in refused(robot, limit=LIMIT + low)
    soft = soft.replace('"3"', '"low"')
    said = refused(robot, limit=LIMIT + soft)
    assert "joint 'a': safety_controller.soft_lower_limit: must be a finite number" in said


@pytest.mark.parametrize("limit", ['<limit velocity="2" effort="10"/>', ""])
def test_joints_without_bounds_are_refused_on_the_chain(robot, limit):
    """URDF takes bounds that are missing for 0; nothing is refused for joints beside the chain."""
    if limit:
        assert "joint 'a': has no range; give its limits, or make" in refused(robot, limit=limit)
    free = robot(kind="continuous", limit=limit)
    turn = chain_of(free, "base", "two", max_speed=[1.0], capsules=1).model.joints[0]
    assert turn.range == pytest.approx((-2.0 * np.pi, 2.0 * np.pi))
    beside = chain_of(robot(limit=limit), "one", "two", capsules=1).model
    assert [joint.name for joint in beside.joints] == ["b"]


@pytest.mark.parametrize(
    ("shape", "reaches"),
    [
        ('<capsule radius="0.1" length="0.4"/>', (0.1, 0.1, 0.3)),
        ('<capsule radius="0.1" length="0"/>', (0.1, 0.1, 0.1)),
        ('<cylinder radius="0.1" length="0"/>', (0.1, 0.1, 0.0)),
    ],
)
def test_capsules_have_the_length_of_their_axis(robot, shape, reaches):
    given = f"<collision><geometry>{shape}</geometry></collision>"
    np.testing.assert_allclose(corner(robot(one=given)), reaches, atol=1e-3)


@pytest.mark.parametrize(
    "shape",
    [
        '<sphere radius="0"/>',
        '<box size="0 0 0"/>',
        '<cylinder radius="0.0" length="0"/>',
        '<capsule radius="0" length="0.1"/>',
    ],
)
def test_shapes_that_are_nothing_are_left_out_by_name(robot, shape):
    kind = shape[1:].split()[0]
    given = f"<collision><geometry>{shape}</geometry></collision>"
    read = robot(one=COVER + given)
    assert len(read.links["one"].hulls) == 1
    assert told(read) == [f"one: a {kind} of size 0 is left out"]
    taken = robot(one=given + LOOKS, visual=True)
    assert len(taken.links["one"].hulls) == 1


@pytest.mark.parametrize(
    ("shape", "reason"),
    [
        ('<sphere radius="-0.1"/>', "sphere.radius: must not be negative"),
        ('<capsule radius="0.1" length="-1"/>', "capsule.length: must not be negative"),
        ('<capsule radius="0.1"/>', "capsule.length: is missing"),
    ],
)
def test_sizes_that_cannot_be_are_refused(robot, shape, reason):
    given = f"<collision><geometry>{shape}</geometry></collision>"
    assert f"link 'one': {reason}" in refused(robot, one=given)


def test_a_root_that_only_joints_name_is_a_link(robot):
    """Such as world; other links that are missing are not."""
    whole = URDF.format(one=COVER, two=COVER, kind="revolute", limit=LIMIT)
    read = robot(whole=whole.replace('<link name="base"/>', ""))
    assert chain_of(read, "base", "two", capsules=1).model.dof == 2
    spelled = whole.replace('<parent link="base"/>', '<parent link="bass"/>')
    assert "joint 'a': there is no link 'bass'" in refused(robot, whole=spelled)
    ends = whole.replace('<link name="two">', '<link name="too">')
    assert "joint 'b': there is no link 'two'" in refused(robot, whole=ends)


MESH = '<collision><geometry><mesh filename="{}"/></geometry></collision>'


def packed(folder, name):
    """Make a package of another name than its folder, with a mesh."""
    trimesh = pytest.importorskip("trimesh")
    (folder / "meshes").mkdir(parents=True)
    (folder / "package.xml").write_text(f"<package><name> {name}\n</name></package>", "utf-8")
    trimesh.creation.box((0.2, 0.2, 0.2)).export(folder / "meshes" / "bar.stl")


@pytest.mark.parametrize(
    ("place", "packages"),
    [
        ("ws/arm", ()),  # the file's own package
        ("ws/looks", ()),  # one beside it
        ("looks", ()),  # one beside what is above it
        ("other/src/looks", ("other",)),
        ("other", ("other",)),
    ],
)
def test_packages_have_the_name_in_their_manifest(tmp_path, place, packages):
    packed(tmp_path / place, "pretty_arm")
    if place != "ws/arm":
        packed(tmp_path / "ws" / "arm", "another")
    (tmp_path / "broken").mkdir()
    (tmp_path / "broken" / "package.xml").write_text("<package>", "utf-8")
    file = tmp_path / "ws" / "arm" / "urdf" / "small.urdf"
    file.parent.mkdir()
    mesh = MESH.format("package://pretty_arm/meshes/bar.stl")
    file.write_text(URDF.format(one=mesh, two="", kind="revolute", limit=LIMIT), "utf-8")
    read = read_robot(file, [tmp_path / folder for folder in packages])
    np.testing.assert_allclose(corner(read), 0.1)


def test_models_are_looked_for_as_folders(robot, tmp_path):
    packed(tmp_path / "models" / "pretty", "any")
    mesh = MESH.format("model://pretty/meshes/bar.stl")
    np.testing.assert_allclose(corner(robot(one=mesh, packages=[tmp_path / "models"])), 0.1)
    said = refused(robot, one=MESH.format("model://ugly/bar.stl"))
    assert "model://ugly/bar.stl: is not found in the folders above the file; name a" in said


@pytest.mark.parametrize("scheme", ["https", "fuel"])
def test_other_places_are_refused(robot, scheme):
    said = refused(robot, one=MESH.format(f"{scheme}://there/bar.stl"))
    assert f"{scheme}://there/bar.stl: only files, package:// and model:// are read" in said


XACRO = 'xmlns:xacro="http://www.ros.org/wiki/xacro"'


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("a.urdf", f'<robot {XACRO}><xacro:include filename="b.xacro"/></robot>'),
        ("a.urdf", '<robot name="a"><xacro:macro name="m" params="x"/></robot>'),
        ("a.urdf", '<robot name="a"><link name="${prefix}base"/></robot>'),
        ("a.urdf", URDF.format(one=MESH.format("$(find p)/b.stl"), two="", kind="", limit="")),
        ("a.urdf", URDF.format(one="", two="", kind="fixed", limit='<origin rpy="0 0 ${pi/2}"/>')),
        ("a.urdf.xacro", URDF.format(one=COVER, two=COVER, kind="revolute", limit=LIMIT)),
        ("a.xacro", "<robot"),
    ],
)
def test_xacro_is_recognised(robot, tmp_path, name, text):
    said = refused(robot, name=name, whole=text)
    assert said.startswith(f"{tmp_path / name}: this is xacro, expand it first: xacro ")
    assert said.endswith(f"{name} > robot.urdf")


def test_a_namespace_that_is_not_used_is_no_xacro(robot):
    text = URDF.format(one=COVER, two=COVER, kind="revolute", limit=LIMIT)
    text = text.replace("<robot", f"<robot {XACRO}").replace(
        "</robot>", '<gazebo><plugin file="$(find x)"/></gazebo></robot>'
    )
    assert robot(whole=text).name == "small"


def test_elements_of_others_do_not_count(robot):
    """Pinocchio's, for one; and robots may be in URDF's own namespace."""
    text = URDF.format(
        one=f'{COVER}<collision_checking><capsule name="x"/></collision_checking>',
        two=COVER, kind="revolute", limit=LIMIT,
    )  # fmt: skip
    read = robot(whole=text.replace("<robot", '<robot xmlns="http://www.ros.org"'))
    assert len(read.links["one"].hulls) == 1
    assert "has no links" in refused(robot, whole='<robot name="a"/>')


MJCF = """<mujoco><compiler angle="radian"/>
<asset><hfield name="h" nrow="2" ncol="2" size="1 1 1 1" elevation="0 1 0 1"/></asset>
<worldbody><geom name="floor" type="plane" size="0 0 0.05"/>
<geom type="hfield" hfield="h"/><geom type="plane" size="1 1 1" contype="0" conaffinity="0"/>
<body name="cube" pos="2 0 0"><freejoint/><geom type="box" size="0.1 0.1 0.1"/>
 <body name="lid"><geom type="sphere" size="0.1"/></body></body>
<body name="foot" pos="1 0 0.5" euler="0 0 0.3"><freejoint/>
 <geom type="box" size="0.05 0.05 0.05"/><site name="s"/>
 <body name="one" pos="0 0 0.1"><joint name="a" axis="0 0 1" range="-2 2"/>
  <geom type="ellipsoid" size="0.3 0.1 0.05" pos="0.2 0 0"/>
  <body name="two" pos="0.4 0 0"><joint name="b" axis="0 0 1" range="-2 2"/>
   <geom type="box" size="0.1 0.02 0.02" pos="0.1 0 0" contype="0" conaffinity="0"/>
  </body></body></body></worldbody></mujoco>"""


@pytest.fixture
def scene(tmp_path):
    """Return a function that reads a scene of MuJoCo."""
    pytest.importorskip("mujoco")

    def read(*changes, **how):
        text = MJCF
        for old, new in changes:
            text = text.replace(old, new)
        (tmp_path / "scene.xml").write_text(text, "utf-8")
        return read_robot(tmp_path / "scene.xml", **how)

    return read


def covered(robot) -> list[str]:
    """Return the links that have geometry."""
    return [name for name, link in robot.links.items() if link.hulls]


def test_what_cannot_be_covered_of_a_scene_is_left_out_by_name(scene):
    assert told(scene()) == [
        "floor: a plane is left out; give it as an obstacle",
        "geometry of world: a height field is left out; give it as an obstacle",
        "cube: floats alone and is left out; give it as a body",
        "lid: floats alone and is left out; give it as a body",
        "no collision geometry: two; --visual takes their looks",
    ]
    assert covered(scene()) == ["foot", "one"]
    assert covered(scene(visual=True)) == ["foot", "one", "two"]


def test_geometry_of_a_pair_can_touch(scene):
    name = ('pos="0.1 0 0" con', 'pos="0.1 0 0" name="g" con')
    pair = ("</mujoco>", '<contact><pair geom1="floor" geom2="g"/></contact></mujoco>')
    assert covered(scene(name, pair)) == ["foot", "one", "two"]


def test_what_floats_is_where_mujoco_has_it(scene, tmp_path):
    read = scene()
    mujoco = pytest.importorskip("mujoco")
    data = mujoco.MjData(mujoco.MjModel.from_xml_path(str(tmp_path / "scene.xml")))
    mujoco.mj_kinematics(data.model, data)
    first, last = (joint.origin for joint in read.joints if joint.child.startswith("foot"))
    np.testing.assert_allclose((first @ last)[:3, 3], data.body("foot").xpos, atol=1e-9)
    np.testing.assert_allclose((first @ last)[:3, :3].ravel(), data.body("foot").xmat, atol=1e-9)


def test_a_polytope_holds_its_ellipsoid():
    half = np.array([0.3, 0.1, 0.05])
    points = np.random.default_rng(0).normal(size=(5000, 3))
    directions = points / np.linalg.norm(points, axis=1, keepdims=True)
    reached = (directions @ tree.ellipsoid(half).centres.T).max(axis=1)
    needed = np.linalg.norm(directions * half, axis=1)
    assert np.all(reached >= needed) and np.all(reached < 1.1 * needed)
