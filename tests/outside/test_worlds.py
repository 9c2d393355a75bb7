"""Scenes of MoveIt, meshes and clouds, as obstacles of given situations."""

import struct
from dataclasses import replace

import numpy as np
import pytest

from gcm_learn import read_situations
from gcm_learn.arms import rotation_of
from gcm_learn.cli import main
from gcm_learn.errors import FileFormatError
from gcm_learn.outside import World, bodies_of, read_pcd, scene_node, yaml_node
from gcm_learn.planners.registry import get_planner
from gcm_learn.situation import Cloud, Mesh
from tests.judging import judge
from tests.panda import PANDA
from tests.refusals import refusal

POINTS = np.array([(1, 2, 3), (0.5, -2, 0.25), (np.nan, 0, 0), (1, 2, 3), (1, 2, 3)])
FINITE = POINTS[[0, 1, 3, 4]]


def packed(raw):
    """LZF of a text, as plain bytes only."""
    made = b"".join(bytes((31,)) + raw[k : k + 32] for k in range(0, len(raw) - 31, 32))
    made += bytes((len(raw) % 32 - 1,)) + raw[-(len(raw) % 32) :]
    return struct.pack("<II", len(made), len(raw)) + made


def pcd(form="binary", size=4, head=None, cut=None):
    """A file with a colour before the points and padding among them."""
    x, y, z = POINTS.T.astype(f"<f{size}")
    colour, padding = np.arange(5, dtype="<u4"), np.zeros((5, 3), dtype="u1")
    if form == "ascii":
        rows = zip(colour, x, y, z, strict=True)
        data = "".join("{} {} {} 0 0 0 {}\n".format(*row) for row in rows).encode()
    elif form == "binary":
        columns = (column.reshape(5, -1).view("u1") for column in (colour, x, y, padding, z))
        data = np.hstack([*columns]).tobytes()
    else:
        data = packed(b"".join(column.tobytes() for column in (colour, x, y, z)))
    given = head or "FIELDS rgb x y _ z\nSIZE 4 {0} {0} 1 {0}\nTYPE U F F U F\nCOUNT 1 1 1 3 1\n"
    view = "VIEWPOINT 0 0 0 1 0 0 0"
    text = f"# .PCD v0.7\nVERSION 0.7\n{given.format(size)}{view}\nPOINTS 5\nDATA {form}\n"
    return text.encode() + data[:cut]


@pytest.mark.parametrize("form", ["ascii", "binary", "binary_compressed"])
@pytest.mark.parametrize("size", [4, 8])
def test_all_forms_of_pcd_hold_the_same_points(form, size, tmp_path):
    (tmp_path / "a.pcd").write_bytes(pcd(form, size))
    np.testing.assert_array_equal(read_pcd(tmp_path / "a.pcd"), POINTS)


def test_what_the_library_of_lzf_packed_is_unpacked(tmp_path):
    """Five points (0.5, 1, 2) by columns, as liblzf 3.6 writes them."""
    data = bytes.fromhex("040000003f00e0080300802013e00703010040e00503010040")
    head = b"FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nPOINTS 5\nDATA binary_compressed\n"
    (tmp_path / "a.pcd").write_bytes(head + struct.pack("<II", len(data), 60) + data)
    np.testing.assert_array_equal(read_pcd(tmp_path / "a.pcd"), [(0.5, 1, 2)] * 5)


XYZ = "FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\n"
BROKEN = [
    (b"", "has no line DATA"),
    (b"DATA ascii\n0 0 0\n", 'POINTS: must be a number above 0 (got "")'),
    (pcd("zip"), 'DATA: must be ascii, binary or binary_compressed (got "zip")'),
    (pcd(head="FIELDS x y z\nSIZE 4 4\nTYPE F F F\n"), "FIELDS: must fit SIZE, TYPE and COUNT"),
    (pcd(head="FIELDS x y\nSIZE 4 4\nTYPE F F\n"), "FIELDS: must have x, y and z"),
    (pcd(head=XYZ.replace("4 4 4", "4 2 4")), "FIELDS: y must be of type F with 4 or 8 bytes"),
    (pcd(head=f"{XYZ}COUNT 1 1 2\n"), "FIELDS: z must be of type F"),
    (pcd(cut=-1), "DATA: ends after 94 of 95 bytes"),
    (pcd("binary_compressed", cut=-1), "DATA: does not unpack to 80 bytes by LZF"),
    (pcd("binary_compressed", head=XYZ.replace("4", "8")), "DATA: ends after 80 of 120 bytes"),
    (pcd("ascii", head=XYZ), "DATA: must be 5 lines, each of 3 numbers"),
    (pcd("ascii").replace(b"nan", b"here"), "could not convert string 'here' to float64 at row 2"),
]  # fmt: skip


@pytest.mark.parametrize(("content", "message"), BROKEN)
def test_a_broken_cloud_is_refused_in_one_line(content, message, tmp_path):
    path = tmp_path / "a.pcd"
    path.write_bytes(content)
    said = refusal(FileFormatError, read_pcd, path)
    assert said.startswith(f"{path}: ") and message in said


SHAPES = (
    "box\n0.1 0.2 0.3\n0.1 0 0\n0 0 0 1", "sphere\n0.05\n0 0.1 0\n0 0 0 1",
    "cylinder\n0.03 0.4\n0 0 0.1\n0 0 0.7071068 0.7071068",
    "mesh\n4 2\n0 0 0\n0.2 0 0\n0 0.2 0\n0 0.2 0.1\n0 1 2\n0 1 3\n0 0 0\n0 1 0 0",
)  # fmt: skip


def scene_text(posed=True):
    """What RViz exports; older versions join the poses of an object and of its shapes."""
    pose, frames = ("0.5 -0.4 0.3\n0 0 0 1\n", "1\ngrip\n0 0 0\n0 0 0 1\n") if posed else ("", "")
    shapes = "".join(f"{shape}\n0 0.5 0 1\n" for shape in SHAPES)
    return f"(noname)+\n* my shelf\n{pose}4\n{shapes}{frames}* none\n{pose}0\n{frames}.\n"


MESH = """
world:
  collision_objects:
    - {id: my shelf, operation: "\\0", pose: {position: [0.5, -0.4, 0.3]}, meshes: [{
        triangles: [{vertex_indices: [0, 1, 2]}, {vertex_indices: [0, 1, 3]}],
        vertices: [{x: 0, y: 0, z: 0}, [0.2, 0, 0], [0, 0.2, 0], [0, 0.2, 0.1]]}],
      mesh_poses: [{position: [0, 0, 0], orientation: [0, 1, 0, 0]}]}
    - {id: none}
"""


def test_a_scene_is_the_same_in_text_and_in_yaml():
    bodies = bodies_of(scene_node("a.scene", scene_text()))
    (same,) = bodies_of(yaml_node("a.yaml", MESH))
    assert replace(same, name="my shelf/4") == bodies[3]
    assert [b.name for b in bodies] == [f"my shelf/{k}" for k in (1, 2, 3, 4)]
    box, ball, can, mesh = bodies
    assert box.shape.half_extents == (0.05, 0.1, 0.15) and ball.shape.radius == 0.05
    assert (can.shape.radius, can.shape.half_length) == (0.03, 0.2)
    np.testing.assert_allclose(can.motion.position, (0.5, -0.4, 0.4))
    corners = mesh.shape.corners @ rotation_of(mesh.motion.orientation).T + mesh.motion.position
    np.testing.assert_allclose(corners[1], [(0.5, -0.4, 0.3), (0.3, -0.4, 0.3), (0.5, -0.2, 0.2)])
    older = bodies_of(scene_node("a.scene", scene_text(posed=False)))
    for new, old in zip(bodies, older, strict=True):
        assert new.shape == old.shape and new.motion.orientation == old.motion.orientation
        shift = np.subtract(new.motion.position, old.motion.position)
        np.testing.assert_allclose(shift, (0.5, -0.4, 0.3))


SCENES = [
    ("box", "cone", 'a.scene:6: "cone" is not understood'),
    ("0.1 0.2 0.3", "0.1 0.2 wide", 'a.scene:7: must be numbers (got "0.1 0.2 wide")'),
    ("mesh\n4 2", "mesh\n4 2.5", 'a.scene:22: must be whole numbers (got "4 2.5")'),
    ("mesh\n4 2", "mesh\n4 900", 'must be whole numbers (got "0 0 0.5")'),
    ("0 1 3", "0 1 7", "meshes[0]: triangles[1][2]: 7 is no vertex (there are 4)"),
    ("0.2 0 0", "0.2 nan 0", "meshes[0].vertices[1][1]: must be finite"),
    ("0 0 0.7071068 0.7071068", "0 0 0.7 0.9", "must be a quaternion of length 1 (got 1.14017543)"),
    ("* none", "* my shelf", 'collision_objects[1].id: "my shelf" is given twice'),
    ("* none", "+ none", 'a.scene:36: must be *, before an object, or . at the end (got "+")'),
    ("\n.\n", "\n", "a.scene:43: ends too early"),
]  # fmt: skip


@pytest.mark.parametrize(("old", "new", "message"), SCENES)
def test_what_is_not_understood_in_a_scene_is_refused(old, new, message):
    text = scene_text().replace(old, new, 1)
    assert message in refusal(FileFormatError, lambda: bodies_of(scene_node("a.scene", text)))


def ply(form, rows):
    head = f"ply\nformat {form} 1.0\nelement vertex {len(rows)}\n"
    head += "".join(f"property float {axis}\n" for axis in "xyz") + "end_header\n"
    if form == "ascii":
        return (head + "".join("{} {} {}\n".format(*row) for row in rows)).encode()
    return head.encode() + rows.astype("<f4").tobytes()


@pytest.fixture
def room(tmp_path):
    (tmp_path / "cloud.pcd").write_bytes(pcd())
    (tmp_path / "text.ply").write_bytes(ply("ascii", POINTS))
    (tmp_path / "bytes.ply").write_bytes(ply("binary_little_endian", POINTS))
    np.save(tmp_path / "saved.npy", FINITE)
    (tmp_path / "flag.off").write_text("OFF\n3 1 0\n0 0 9\n1 0 9\n0.01 0 9\n3 0 1 2\n")
    (tmp_path / "shelf.scene").write_text(scene_text())
    return tmp_path


@pytest.mark.parametrize("name", ["cloud.pcd", "text.ply", "bytes.ply", "saved.npy"])
def test_a_cloud_becomes_an_obstacle_at_rest(name, room, capsys):
    out, half = room / "out.jsonl", 0.5**0.5
    place = ["--at", "0", "0", "5", "--turn", str(half), "0", "0", str(half), "--scale", "0.5"]
    command = [str(room / name), "--into", str(PANDA), "--radius", "0.1", "--out", str(out)]
    assert main(["convert", *command, *place]) == 0
    said = capsys.readouterr().err
    assert ("1 of 5: points of" in said) == (name != "saved.npy") and "0 of 1: the start" in said
    (before,), (after,) = read_situations(PANDA), read_situations(out)
    *others, body = after.bodies
    assert tuple(others) == before.bodies and after.format == "gcm-learn/situation@4"
    assert body.name == name[:-4] and body.shape == Cloud(0.5 * FINITE, 0.1)
    assert body.motion.position == (0, 0, 5)
    np.testing.assert_allclose(body.motion.orientation, (half, 0, 0, half))


def test_simplification_is_told_and_made_up_for(room):
    sources = [room / "cloud.pcd", room / "flag.off"]
    plain = World(PANDA, 0.1).convert(sources)
    simple = World(PANDA, 0.1, simplify=0.1).convert(sources)
    cloud, flag = plain.situations[0].bodies[-2:]
    fewer, bare = simple.situations[0].bodies[-2:]
    assert fewer.shape == cloud.shape.simplified(0.1)[0]
    assert bare.shape == flag.shape.simplified(0.1)[0]
    assert flag.margin is None and isinstance(bare.shape, Mesh)
    assert (bare.margin.now, bare.margin.rate) == (pytest.approx(0.005), 0.0)
    said = list(simple.notes())
    assert "2 of 4: points of cloud are left, radius larger by 0" in said
    assert "1 of 1: triangles of flag are left, margin 0.005" in said
    assert not any("left, " in note for note in plain.notes())


def test_an_arm_in_a_scene_with_a_mesh_is_planned_for_and_judged(room):
    (situation,) = World(PANDA, at=(0.0, 0.0, 0.1)).convert([room / "shelf.scene"]).situations
    assert [b.shape.kind for b in situation.bodies[-4:]] == ["box", "sphere", "cylinder", "mesh"]
    plan = get_planner("search").plan(situation)
    assert plan.caught and judge(situation, plan) == []


REFUSED = [
    (["cloud.pcd"], "radius: is missing: "),
    (["cloud.pcd", "--radius", "1", "--turn", "1", "1", "0", "0"], "turn: must have length 1"),
    (["cloud.pcd", "text.ply", "cloud.pcd", "--radius", "1"], 'bodies[5].name: "cloud" is already'),
    (["seen.pcd", "--radius", "1"], "seen.pcd: VIEWPOINT: must be 0 0 0 1 0 0 0, a pose is given"),
    (["odd.pcd", "--radius", "1"], "odd.pcd: could not convert string to float: 'here'"),
    (["shelf.scene", "--scale", "2"], "scale: is for clouds and meshes (shelf.scene is in metres)"),
    (["shelf.scene", "--arm", "ur5"], "--arm: is no option of --into"),
    (["notes.txt"], "notes.txt: is no mesh of stl, obj, off, ply"),
    (["none.scene"], "none.scene: cannot be read (No such file or directory)"),
    (["nan.ply", "--radius", "1"], "nan.ply: has no points"),
    (["cut.ply", "--radius", "1"], "cut.ply: cannot be read"),
]  # fmt: skip


@pytest.mark.parametrize(("arguments", "message"), REFUSED)
def test_what_cannot_be_an_obstacle_is_refused(arguments, message, room, capsys, monkeypatch):
    monkeypatch.chdir(room)
    (room / "nan.ply").write_bytes(ply("ascii", POINTS[2:3]))
    (room / "cut.ply").write_bytes(ply("binary_little_endian", POINTS)[:-1])
    (room / "seen.pcd").write_bytes(pcd().replace(b"T 0 0 0 1", b"T 0 0 1 1"))
    (room / "odd.pcd").write_bytes(pcd().replace(b"T 0 0 0 1", b"T 0 0 here 1"))
    (room / "out.jsonl").write_text("old")
    assert main(["convert", *arguments, "--into", str(PANDA), "--out", "out.jsonl"]) == 2
    stdout, stderr = capsys.readouterr()
    assert message in stderr and stderr.count("\n") == 1 and stdout == ""
    assert (room / "out.jsonl").read_text() == "old"
