"""Capsules of robots beside their files' parts, by fcl, which shares nothing with ours."""

from __future__ import annotations

from itertools import pairwise

import fcl
import numpy as np
import pytest
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation

from gcm_learn.arms import chain_of, frames_at, read_robot
from gcm_learn.arms.convex_kernels import gaps
from gcm_learn.arms.robots.capsules import Site, SiteCapsule, packed, reduced
from gcm_learn.arms.robots.fits import FIRST
from gcm_learn.arms.robots.tree import Hull, box, corners, cylinder
from gcm_learn.cli import main
from gcm_learn.errors import RobotError

OVERLAPPING = (  # balls of a mobile base: places and radii
    (-0.13, 0.01, 0.23, 0.28), (0.28, 0.01, 0.39, 0.08), (0.11, -0.06, 0.21, 0.25),
    (0.27, -0.07, 0.39, 0.08), (0.24, -0.15, 0.39, 0.08), (0.17, -0.21, 0.39, 0.08),
    (0.09, -0.23, 0.39, 0.08), (0.03, -0.23, 0.39, 0.08), (0.11, 0.08, 0.21, 0.25),
    (0.27, 0.1, 0.39, 0.08), (0.24, 0.18, 0.39, 0.08), (0.17, 0.24, 0.39, 0.08),
    (0.09, 0.25, 0.39, 0.08),
)  # fmt: skip
LIMIT = 0.02


def bar(length, width=0.05, height=0.05, along=0.5):
    return f'<box size="{length} {width} {height}"/>', (along * length, 0.0, 0.0)


def ball(x, y, z, radius):
    return f'<sphere radius="{radius}"/>', (x, y, z)


def urdf(links, joints):
    """A robot: parts of each link, and (parent, child, type, origin, axis) of joints."""
    text = '<robot name="small">'
    for name, parts in links.items():
        text += f'<link name="{name}">'
        for shape, place in parts:
            origin = " ".join(map(str, place))
            text += f'<collision><origin xyz="{origin}"/><geometry>{shape}</geometry></collision>'
        text += "</link>"
    for k, (parent, child, kind, origin, axis) in enumerate(joints):
        text += (
            f'<joint name="j{k}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
            f'<origin xyz="{origin}"/><axis xyz="{axis}"/>'
            '<limit lower="-2" upper="2" velocity="2" effort="10"/></joint>'
        )
    return text + "</robot>"


MAST = urdf(
    {
        "base": [bar(0.1, 0.1, 0.1, 0.0)],
        "mast": [('<cylinder radius="0.03" length="0.6"/>', (0, 0, 0))],
        "one": [bar(0.6)],
        "two": [bar(0.4)],
        "tip": [],
    },
    [
        ("base", "mast", "fixed", "0.3 0.3 0.2", "0 0 1"),
        ("base", "one", "revolute", "0 0 0.1", "0 0 1"),
        ("one", "two", "revolute", "0.6 0 0", "0 0 1"),
        ("two", "tip", "fixed", "0.4 0 0", "0 0 1"),
    ],
)
BALLS = urdf(
    {"base": [ball(*each) for each in OVERLAPPING], "one": [bar(0.4)], "two": [bar(0.4)]},
    [
        ("base", "one", "revolute", "0 0 0.55", "0 0 1"),
        ("one", "two", "revolute", "0.4 0 0", "0 1 0"),
    ],
)


def made(tmp_path, text, base="base", tip="two", **given):
    file = tmp_path / ("robot.xml" if text.startswith("<mujoco") else "robot.urdf")
    file.write_text(text, "utf-8")
    return chain_of(read_robot(file), base, tip, max_speed=[2.0], **given)


def convex(points):
    """Points' hull as fcl's."""
    faces = ConvexHull(points).simplices
    rows = np.column_stack([np.full(len(faces), 3), faces]).ravel()
    return fcl.Convex(np.ascontiguousarray(points), len(faces), rows)


def apart(one, two):
    return fcl.distance(one, two, fcl.DistanceRequest(), fcl.DistanceResult())


def out_of(capsules, points):
    """Distances of points from the nearest of some capsules, below 0 inside."""
    found = []
    for start, end, radius in capsules:
        axis = end - start
        share = (points - start) @ axis / max(float(axis @ axis), 1e-30)
        near = start + np.clip(share, 0.0, 1.0)[:, None] * axis
        found.append(np.linalg.norm(points - near, axis=1) - radius)
    return np.min(found, axis=0)


def within(rng, points, count=400):
    """Random points of a hull, and its corners."""
    shares = rng.dirichlet(np.full(len(points), 0.3), count)
    return np.concatenate([points, shares @ points])


def covered(parts, limit=LIMIT, most=40):
    """Capsules of one site, divided until they lie close."""
    parts = [reduced(part) for part in parts]
    cells = [SiteCapsule(parts, Site(0, parts, limit))]
    while len(cells) < most and max(cell.overhang for cell in cells) > limit:
        worst = max(cells, key=lambda cell: cell.overhang)
        cells = [cell for cell in cells if cell is not worst] + list(worst.divided())
    return cells


def boxes(rng, count):
    """Boxes that touch, turned as one."""
    turn, parts = Rotation.random(random_state=rng.integers(1 << 30)).as_matrix(), []
    for k in range(count):
        pose = np.eye(4)
        pose[:3, :3], pose[:3, 3] = turn, turn @ [0.1 * k, 0.05 * k, 0.0]
        parts.append(box(rng.uniform(0.03, 0.2, 3)).moved(pose))
    return parts


def test_distances_of_hulls_are_those_of_fcl():
    rng = np.random.default_rng(0)
    for count in (4, 8, 60):
        one, two = rng.normal(size=(2, count, 3)) * rng.uniform(0.05, 0.3, 3)
        parts = packed([corners(one), corners(two)])
        turns = Rotation.random(200, random_state=1).as_matrix()
        places = rng.normal(size=(200, 3)) * 0.4
        found = gaps(*parts, 1, turns, places, 1e9)
        first = fcl.CollisionObject(convex(one))
        shape, theirs = convex(two), []
        for turn, place in zip(turns, places, strict=True):
            theirs.append(apart(first, fcl.CollisionObject(shape, fcl.Transform(turn, place))))
        theirs = np.maximum(theirs, 0.0)
        assert 0 < np.sum(theirs > 0.0) < 200 or count == 4
        np.testing.assert_array_equal(found > 0.0, theirs > 0.0)
        np.testing.assert_allclose(np.maximum(found, 0.0), theirs, atol=1e-4)
        cut = gaps(*parts, 1, turns, places, 0.1)
        np.testing.assert_allclose(cut, np.minimum(found, 0.1), atol=1e-7)


def test_distances_of_round_hulls_are_less_by_their_radii():
    rng = np.random.default_rng(1)
    points = rng.normal(size=(6, 3)) * 0.1
    for radii in (np.full(6, 0.02), rng.uniform(0.01, 0.03, 6)):
        parts = packed([Hull(np.column_stack([points, radii])), Hull(np.zeros((1, 4)))])
        places, still = rng.normal(size=(50, 3)), np.tile(np.eye(3), (50, 1, 1))
        found = gaps(*parts, 1, still, places, 1e9)
        ways = rng.normal(size=(20000, 3))
        ways /= np.linalg.norm(ways, axis=1, keepdims=True)
        dense = (places @ ways.T - (ways @ points.T + radii).max(axis=1)).max(axis=1)
        assert np.all(found > dense - 1e-7) and np.all(found - dense < 2e-3)


@pytest.mark.parametrize("seed", range(3))
def test_capsules_hold_boxes_and_all_between_their_corners(seed):
    rng = np.random.default_rng(seed)
    parts = boxes(rng, 1 + seed)
    cells = covered(parts, most=4)
    capsules = [cell.capsule for cell in cells]
    for part in parts:
        assert out_of(capsules, within(rng, part.centres)).max() <= 0.0
    for cell in cells:  # each alone holds its pieces, so that nothing between is left out
        assert max(out_of([cell.capsule], hull.centres).max() for hull in cell.hulls) <= 0.0


@pytest.mark.parametrize(
    "parts",
    [
        [box((0.2, 0.15, 0.02))],
        pytest.param([cylinder(0.06, 0.1)], marks=pytest.mark.slow),
        [box((0.3, 0.05, 0.05)), box((0.05, 0.3, 0.05))],
    ],
    ids=["plate", "cylinder", "cross"],
)
def test_overhang_is_small_and_as_large_as_fcl_says(parts):
    cells = covered(parts)
    assert 1 < len(cells) <= 20
    solids = [fcl.CollisionObject(convex(part.centres)) for part in parts]
    rng = np.random.default_rng(2)
    for cell in cells:
        start, end, radius = cell.capsule
        assert cell.overhang <= LIMIT
        for _ in range(100):
            way = rng.normal(size=3)
            axis, share = end - start, rng.random()
            if rng.random() < 0.5:
                way -= way @ axis * axis / max(float(axis @ axis), 1e-30)
            else:
                share = float(way @ axis > 0.0)
            point = start + share * axis + radius * way / np.linalg.norm(way)
            at = fcl.CollisionObject(fcl.Sphere(1e-6), fcl.Transform(point))
            assert min(apart(at, solid) for solid in solids) <= cell.overhang + 2e-3


@pytest.mark.slow
def test_balls_that_overlap_get_few_capsules_that_fit(tmp_path):
    base = made(tmp_path, BALLS, capsules=12).covers[0]
    assert base.link == "base" and base.overhang <= 0.02
    few = made(tmp_path, BALLS, capsules=4)
    assert few.covers[0].capsules == 4 and few.covers[0].overhang < 0.1
    capsules = [(np.array(link.start), np.array(link.end), link.radius) for link in few.model.links]
    rng = np.random.default_rng(0)
    for x, y, z, radius in OVERLAPPING:
        way = rng.normal(size=(200, 3))
        way /= np.linalg.norm(way, axis=1, keepdims=True)
        assert out_of(capsules[:4], [x, y, z] + radius * way).max() <= 0.0


def named(fitted):
    """Names of links that are checked against each other."""
    links = fitted.model.links
    return {frozenset((links[i].name, links[j].name)) for i, j in fitted.model.self_collision}


def test_only_links_that_one_joint_joins_are_left_out(tmp_path):
    assert named(made(tmp_path, MAST, capsules=1)) == {frozenset(("mast", "one"))}


@pytest.mark.parametrize("axis, checked", [("1 0 0", 0), ("0 1 0", 1)])
def test_tubes_of_a_telescope_may_lie_in_each_other(tmp_path, axis, checked):
    tubes = {name: [bar(1.0 - 0.1 * k, 0.1 - 0.02 * k)] for k, name in enumerate("abc")}
    slides = [("a", "b", "prismatic", "0.1 0 0", "1 0 0"), ("b", "c", "prismatic", "0.1 0 0", axis)]
    model = made(tmp_path, urdf(tubes, slides), "a", "c", capsules=1).model
    assert len(model.self_collision) == checked


def test_bodies_of_mjcf_are_joined_by_their_joint(tmp_path):
    pytest.importorskip("mujoco")
    text = """<mujoco><compiler angle="radian"/><worldbody><body name="base">
      <geom type="box" size="0.1 0.1 0.1"/>
      <body name="post" pos="0.2 0.2 0"><geom type="sphere" size="0.05"/></body>
      <body name="one" pos="0 0 0.08"><joint name="a" axis="0 0 1" range="-2 2" limited="true"/>
       <geom type="box" size="0.3 0.03 0.03" pos="0.3 0 0"/>
       <body name="two" pos="0.6 0 0"><joint name="b" axis="0 1 0" range="-3 3" limited="true"/>
        <geom type="box" size="0.3 0.03 0.03" pos="0.3 0 0"/>
       </body></body></body></worldbody></mujoco>"""
    assert named(made(tmp_path, text, capsules=1)) == {
        frozenset(pair) for pair in (("one", "post"), ("two", "post"), ("two", "base"))
    }


def test_a_tool_covers_the_way_to_the_hand(tmp_path):
    fitted = made(tmp_path, MAST, tip="tip", point=(0.0, 0.1, 0.05), tool=0.06, capsules=1)
    assert [cover.link for cover in fitted.covers][-1] == "tool of tip"
    link = next(link for link in fitted.model.links if link.name == "tool of tip")
    assert link.joint == 2 and link.end == fitted.model.hand.point
    assert link.start == pytest.approx((0.4, 0.0, 0.0))
    assert link.radius == pytest.approx(0.06, abs=1e-5)
    assert frozenset(("tool of tip", "mast")) in named(fitted)
    with pytest.raises(RobotError, match=r"^tool: must be above 0 \(got 0\)$"):
        made(tmp_path, MAST, tool=0.0)


def test_many_links_of_one_frame_share_capsules(tmp_path):
    links = {"base": [bar(0.1, 0.1, 0.1, 0.0)], "one": [bar(0.3)], "two": [bar(0.1)]}
    joints = [
        ("base", "one", "revolute", "0 0 0.1", "0 0 1"),
        ("one", "two", "revolute", "0.3 0 0", "0 1 0"),
    ]
    for k in range(30):
        links[f"finger {k}"] = [bar(0.02, 0.02, 0.02)]
        joints.append(
            ("two", f"finger {k}", "fixed", f"{0.1 + 0.03 * (k // 8)} {0.03 * (k % 8)} 0", "0 0 1")
        )
    fitted = made(tmp_path, urdf(links, joints), capsules=1)
    assert len(fitted.model.links) <= FIRST
    held = [p for hulls, link in zip(fitted.parts, fitted.model.links, strict=True) for p in hulls]
    assert len(held) == 33
    assert any(" more" in cover.link for cover in fitted.covers)


@pytest.mark.parametrize(
    ("seed", "most"), [(0, 1), *(pytest.param(k, None, marks=pytest.mark.slow) for k in range(3))]
)
def test_capsules_report_what_parts_do(tmp_path, seed, most):
    """Postures of a random arm of boxes; parts by fcl."""
    rng = np.random.default_rng(seed)
    names = ["base", "one", "two", "three", "four"]
    links = {name: [bar(*rng.uniform((0.2, 0.04, 0.04), (0.4, 0.1, 0.1)))] for name in names}
    links["base"] += [ball(0.1, 0.2, 0.1, 0.1)]
    joints = []
    for a, b in pairwise(names):
        axis = " ".join(map(str, rng.integers(0, 2, 2)))
        joints.append((a, b, "revolute", f"{rng.uniform(0.2, 0.4)} 0 0", f"{axis} 1"))
    fitted = made(tmp_path, urdf(links, joints), tip="four", capsules=most)
    assert 0.0 < fitted.freedom.parts < 1.0
    assert most or fitted.freedom.capsules >= 0.9 * fitted.freedom.parts
    model = fitted.model
    low, high = np.array(model.ranges).T
    rotations, places = frames_at(model, rng.uniform(low, high, (300, model.dof)))
    parts = {name: [] for name in names}
    for name, each in links.items():
        for shape, place in each:
            size = [float(word) for word in shape.split('"')[1].split()]
            solid = fcl.Box(*size) if len(size) == 3 else fcl.Sphere(*size)
            parts[name].append((solid, np.array(place)))
    checked, free = named(fitted), 0
    joined = {frozenset(pair) for pair in pairwise(names)}
    for m in range(300):
        ours = touching(model, rotations[:, m], places[:, m])
        free += not ours
        for i, one in enumerate(names):
            for j in range(i):
                pair = frozenset((one, names[j]))
                if pair not in joined and overlap(
                    parts, (one, i), (names[j], j), rotations[:, m], places[:, m]
                ):
                    assert pair in checked and pair in ours
    assert free / 300 == pytest.approx(fitted.freedom.capsules, abs=0.1)


def touching(model, rotations, places):
    """Names of links whose capsules overlap in a posture, by fcl, of pairs that are checked."""
    solids = []
    for link in model.links:
        turn, place = rotations[link.joint], places[link.joint]
        a, b = (turn @ np.array(end) + place for end in (link.start, link.end))
        z = (b - a) / max(float(np.linalg.norm(b - a)), 1e-12) if np.any(a != b) else np.eye(3)[2]
        x = np.cross(z, np.eye(3)[np.argmin(np.abs(z))])
        x /= np.linalg.norm(x)
        pose = fcl.Transform(np.stack([x, np.cross(z, x), z], axis=1), 0.5 * (a + b))
        shape = fcl.Capsule(link.radius, float(np.linalg.norm(b - a)))
        solids.append(fcl.CollisionObject(shape, pose))
    names = [link.name for link in model.links]
    pairs = [(i, j) for i, j in model.self_collision if hit(solids[i], solids[j])]
    return {frozenset((names[i], names[j])) for i, j in pairs}


def overlap(parts, one, two, rotations, places):
    """True if parts of two links, given with their frames, overlap in a posture."""
    sides = []
    for name, k in (one, two):
        poses = [
            fcl.Transform(rotations[k], rotations[k] @ at + places[k]) for _, at in parts[name]
        ]
        shapes = [shape for shape, _ in parts[name]]
        sides.append(list(map(fcl.CollisionObject, shapes, poses)))
    return any(hit(a, b) for a in sides[0] for b in sides[1])


def hit(one, two):
    return fcl.collide(one, two, fcl.CollisionRequest(), fcl.CollisionResult()) > 0


def test_the_command_says_how_free_the_arm_is(tmp_path, capsys):
    file = tmp_path / "mast.urdf"
    file.write_text(MAST, "utf-8")
    command = ["arm", str(file), "--base", "base", "--tip", "tip", "--capsules", "1"]
    command += ["--out", str(tmp_path / "a.json")]
    assert main(command) == 0
    said = capsys.readouterr().out
    assert "free of self-collision in" in said and "by the file's parts" in said
    assert "mast and one overlap in" in said or "one and mast overlap in" in said
    assert "the hand is a point" in said
    assert main([*command, "--tool", "0.02"]) == 0
    said = capsys.readouterr().out
    assert "the hand is a point" not in said and "tool of tip" in said
    assert main([*command, "--tool", "-1"]) == 2
    assert "tool: must be above 0 (got -1)" in capsys.readouterr().err
