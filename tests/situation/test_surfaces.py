"""Clouds and meshes: numbers and files, read alike by the package and by the referee."""

from __future__ import annotations

import copy
import json
import pickle
import struct
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from gcm_learn.arms import rotation_of
from gcm_learn.errors import SituationError
from gcm_learn.referee import Unreadable, inlined, read_points
from gcm_learn.referee.kinds import checked
from gcm_learn.situation import (
    Cloud,
    Mesh,
    canonical,
    read_mesh,
    read_situations,
    situation_from_json,
    situation_to_json,
)
from tests.planar_geometry import depths
from tests.situation.scenes import CHAIN, NAO, SCENES

CORNERS = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0.5, 1.5, 0), (0, 1, 0.25)], dtype=float)
FACES = ((0, 1, 2, 3, 4), (0, 1, 2))
FANS = [(0, 1, 2), (0, 2, 3), (0, 3, 4), (0, 1, 2)]
"""A pentagon and a triangle, and the triangles that they are."""


def _stl(binary):
    triangles = CORNERS[np.array(FANS)]
    if binary:
        rows = [struct.pack("<12fH", 0, 0, 1, *corners.ravel(), 0) for corners in triangles]
        return b" " * 80 + struct.pack("<I", len(rows)) + b"".join(rows)
    lines = ["solid made"]
    for corners in triangles:
        rows = [f"vertex {x} {y} {z}" for x, y, z in corners]
        lines += ["facet normal 0 0 1", "outer loop", *rows, "endloop", "endfacet"]
    return "\n".join([*lines, "endsolid made", ""]).encode()


def _ply(form):
    head = [
        "ply", f"format {form} 1.0", "comment made up", "element vertex 5", "property float x",
        "property float y", "property double z", "property uchar red", "element face 2",
        "property list uchar int vertex_indices", "end_header", "",
    ]  # fmt: skip
    if form == "ascii":
        rows = [f"{x} {y} {z} 7" for x, y, z in CORNERS]
        rows += [" ".join(map(str, [len(face), *face])) for face in FACES]
        return "\n".join([*head[:-1], *rows, ""]).encode()
    order = "<" if "little" in form else ">"
    body = b"".join(struct.pack(f"{order}ffdB", *corner, 7) for corner in CORNERS)
    for face in FACES:
        body += struct.pack(f"{order}B{len(face)}i", len(face), *face)
    return "\n".join(head).encode() + body


OBJ = "# made\no one\n{}\nvn 0 0 1\nf 1//1 2//1 3//1 4//1 5//1\no two\nf -5 -4 -3\n"
OFF = "OFF # made\n5 2 0\n{}\n5 0 1 2 3 4\n3 0 1 2\n"
FILES = {
    "text.stl": _stl(False), "binary.stl": _stl(True), "text.ply": _ply("ascii"),
    "little.ply": _ply("binary_little_endian"), "big.ply": _ply("binary_big_endian"),
    "two.obj": OBJ.format("\n".join("v {} {} {}".format(*c) for c in CORNERS)).encode(),
    "some.off": OFF.format("\n".join("{} {} {}".format(*c) for c in CORNERS)).encode(),
}  # fmt: skip


def with_shape(shape, k=1):
    """The scene of the fourth version with another shape of a body."""
    scene = json.loads(json.dumps(SCENES["fourth"]))
    scene["bodies"][k]["shape"] = shape
    return scene


@pytest.mark.parametrize("name", FILES)
def test_all_kinds_of_files_hold_the_same_triangles(name, tmp_path):
    (tmp_path / name).write_bytes(FILES[name])
    scene = with_shape({"kind": "mesh", "file": name, "scale": 2.0})
    made = situation_from_json(scene, tmp_path).bodies[1].shape
    assert read_mesh(tmp_path / name, 2.0) == made
    wanted = np.sort((2.0 * CORNERS[np.array(FANS)]).reshape(-1, 9), axis=0)
    np.testing.assert_allclose(np.sort(made.corners.reshape(-1, 9), axis=0), wanted)
    other = inlined(scene, tmp_path)["bodies"][1]["shape"]
    corners = np.array(other["vertices"])[np.array(other["triangles"])]
    np.testing.assert_allclose(np.sort(corners.reshape(-1, 9), axis=0), wanted)


def test_a_file_is_read_again_where_it_changed(tmp_path):
    path = tmp_path / "a.npy"
    np.save(path, np.zeros((2, 3)))
    first = read_points(path)
    assert read_points(path) is first
    np.save(path, np.ones((3, 3)))
    assert (read_points(path) == np.ones((3, 3))).all()


@pytest.mark.parametrize("kind", ["<f4", ">f8"])
def test_points_may_stand_in_a_file(kind, tmp_path):
    points = CORNERS.astype(kind)
    np.save(tmp_path / "a.npy", points)
    scene = with_shape({"kind": "cloud", "points": "a.npy", "radius": 0.1})
    (tmp_path / "scene.json").write_text(json.dumps(scene))
    (made,) = read_situations(tmp_path / "scene.json")
    assert made.bodies[1].shape == Cloud(CORNERS, 0.1)
    assert inlined(scene, tmp_path)["bodies"][1]["shape"]["points"] == CORNERS.tolist()


def _pickled(path: Path) -> None:
    np.save(path, np.array([[{}, 0, 0]], dtype=object), allow_pickle=True)


def _saved(array):
    return lambda path: np.save(path, array)


BROKEN = {
    "pickle.npy": _pickled,
    "whole.npy": _saved(np.zeros((2, 3), dtype=int)),
    "half.npy": _saved(np.zeros((2, 3), dtype=np.float16)),
    "flat.npy": _saved(np.zeros(3)),
    "none.npy": _saved(np.zeros((0, 3))),
    "nan.npy": _saved(np.array([[0.0, np.nan, 0.0]])),
    "cut.npy": lambda path: path.write_bytes(b"\x93NUMPY\x01\x00"),
    "cut.stl": lambda path: path.write_bytes(FILES["binary.stl"][:-7]),
    "cut.ply": lambda path: path.write_bytes(FILES["little.ply"][:-7]),
    "empty.obj": lambda path: path.write_bytes(b""),
    "points.obj": lambda path: path.write_bytes(b"v 0 0 0\nv 1 0 0\n"),
    "far.off": lambda path: path.write_bytes(b"OFF\n1 1 0\n0 0 0\n3 0 1 2\n"),
    "nan.off": lambda path: path.write_bytes(b"OFF\n1 1 0\n0 0 nan\n3 0 0 0\n"),
    "folder.stl": lambda path: path.mkdir(),
}


@pytest.mark.parametrize("name", BROKEN)
def test_a_broken_file_is_refused_in_one_line(name, tmp_path):
    BROKEN[name](tmp_path / name)
    cloud = name.endswith(".npy")
    shape = {"points": name, "radius": 0.1} if cloud else {"file": name}
    scene = with_shape({"kind": "cloud" if cloud else "mesh", **shape})
    with pytest.raises(SituationError) as refused:
        situation_from_json(scene, tmp_path)
    assert "\n" not in str(refused.value)
    assert str(refused.value).startswith(f"bodies[1].shape.{'points' if cloud else 'file'}")
    with pytest.raises(Unreadable):
        checked(inlined(scene, tmp_path))


def test_numbers_come_back_from_json():
    cloud, mesh = Cloud(CORNERS, 0.1), Mesh(CORNERS, FANS)
    for shape in (cloud, mesh):
        made = situation_from_json(
            with_shape({"kind": "cloud", "points": [[0, 0, 1]], "radius": 1})
        )
        body = replace(made.bodies[1], shape=shape)
        made = replace(made, bodies=(made.bodies[0], body, *made.bodies[2:]))
        again = situation_from_json(json.loads(json.dumps(situation_to_json(made))))
        assert again == made
        assert pickle.loads(pickle.dumps(made)) == made
        assert hash(again.bodies[1].shape) == hash(shape)
    assert cloud != Cloud(CORNERS, 0.2)
    assert mesh != Mesh(CORNERS, FANS[:3])
    assert cloud != mesh


def test_numbers_of_a_record_do_not_change():
    points = CORNERS.copy()
    cloud = Cloud(points, 0.1)
    points[0] = 7.0
    assert cloud.points[0, 0] == 0.0
    with pytest.raises(ValueError, match="read-only"):
        cloud.points[0] = 7.0


def test_older_formats_have_neither():
    scene = copy.deepcopy(CHAIN)
    body = {"role": "obstacle", "name": "measured", "motion": CHAIN["bodies"][0]["motion"]}
    scene["bodies"].append(body | {"shape": {"kind": "cloud", "points": [[9, 9, 9]], "radius": 1}})
    with pytest.raises(SituationError, match="must be one of sphere, box, capsule, cylinder "):
        situation_from_json(scene)
    made = situation_from_json(scene | {"format": "gcm-learn/situation@4"})
    with pytest.raises(SituationError, match=r"shape.kind: is not known to gcm-learn/situation@3"):
        replace(made, format="gcm-learn/situation@3")
    assert replace(made, format="").format == "gcm-learn/situation@4"


def test_fewer_balls_hold_all_that_were_there(rng):
    cloud = Cloud(rng.uniform(-1.0, 1.0, (3000, 3)), 0.02)
    simple, grown = cloud.simplified(0.2)
    assert len(simple.points) <= 1331
    assert simple.radius == pytest.approx(0.02 + grown)
    apart = np.linalg.norm(cloud.points[:, None] - simple.points, axis=2).min(axis=1)
    assert apart.max() <= grown <= 0.2 * 3**0.5


def test_a_simpler_surface_is_as_near_as_it_says(rng):
    trimesh = pytest.importorskip("trimesh")
    ball = trimesh.creation.icosphere(subdivisions=4)
    mesh = Mesh(ball.vertices, ball.faces)
    simple, moved = mesh.simplified(0.25)
    assert len(simple.triangles) < len(mesh.triangles) / 4
    share = rng.dirichlet((1.0, 1.0, 1.0), len(mesh.triangles))
    points = np.einsum("tc,tcd->td", share, mesh.corners)
    assert depths(simple, points).max() <= moved + 1e-12


@pytest.mark.parametrize("cell", [0.0, -1.0, float("nan"), "x"])
def test_a_wrong_cell_is_refused(cell):
    with pytest.raises(SituationError, match="cell"):
        Cloud(CORNERS, 0.1).simplified(cell)


def test_a_mirrored_arm_sees_mirrored_surfaces(rng):
    scene = copy.deepcopy(NAO) | {"format": "gcm-learn/situation@4"}
    scene["arm"]["joint_range"][1] = [-1.3265, 0.3142]
    scene["bodies"] = [NAO["bodies"][0], {
        "role": "obstacle", "name": "measured",
        "shape": {"kind": "cloud", "points": rng.normal(size=(9, 3)).tolist(), "radius": 0.01},
        "motion": {"kind": "quadratic", "position": [4, 5, 6], "velocity": [0, 0, 0],
                   "acceleration": [0, 0, 0], "orientation": [0.6, 0, 0.8, 0]},
    }]  # fmt: skip
    scene["arm"]["joints"] = [1.4, 0.1, -1.2, -0.6]
    situation = situation_from_json(scene)
    form, frame = canonical(situation)
    assert frame.mirrored
    (centre, turn), (there, turned) = pose_in_world(situation, 1), pose_in_world(form, 1)
    points = situation.bodies[1].shape.points @ turn.T + centre
    seen = form.bodies[1].shape.points @ turned.T + there
    np.testing.assert_allclose(frame.canonical(points), seen, atol=1e-12)


def pose_in_world(situation, k):
    """Place (3,) and rotation (3, 3) of a body at t = 0."""
    motion = situation.bodies[k].motion
    return np.array(motion.position), rotation_of(motion.orientation)
