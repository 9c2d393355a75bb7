"""Joints that follow others in URDF and MJCF: what moves with the chain, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from gcm_learn.arms import chain_of, read_robot
from gcm_learn.arms.robots.following import arranged, leads_of
from gcm_learn.arms.robots.tree import Hull, Robot, RobotJoint, RobotLink, motion
from gcm_learn.errors import RobotError

BALL = (Hull(np.array([[0.0, 0.0, 0.0, 0.05]])),)


def turning(name, parent, child, follows=None, **more):
    """A joint about z, half a unit along x."""
    origin = np.eye(4)
    origin[0, 3] = 0.5
    given = {"range": (-2.0, 2.0), "max_speed": 2.0, "axis": (0.0, 0.0, 1.0)} | more
    return RobotJoint(name, "revolute", parent, child, origin, follows=follows, **given)


def robot_of(*joints, **more):
    """A robot of joints whose links are all balls."""
    names = {end: None for joint in joints for end in (joint.parent, joint.child)}
    return Robot("made", {n: RobotLink(n, BALL) for n in names}, list(joints), **more)


def drawn(seed):
    """A robot of random joints, half of which follow others, ahead of them or behind."""
    rng = np.random.default_rng(seed)
    count, joints = 9, []
    leaders = [k for k in range(count) if rng.random() < 0.5] or [0]
    for k in range(count):
        origin = np.eye(4)
        origin[:3, :3], origin[:3, 3] = (
            Rotation.random(random_state=rng).as_matrix(),
            rng.normal(size=3),
        )
        axis = rng.normal(size=3)
        follows = None
        if k not in leaders:
            known = [*leaders, *[j for j in range(k) if j not in leaders]]  # followers, too
            factor = float(rng.choice([-1.5, 0.5, 2.0, 0.0], p=[0.3, 0.3, 0.3, 0.1]))
            follows = (f"j{rng.choice(known)}", factor, float(rng.uniform(-0.2, 0.2)))
        joints.append(
            RobotJoint(
                f"j{k}", str(rng.choice(["revolute", "prismatic", "fixed"], p=[0.6, 0.3, 0.1])),
                f"l{rng.integers(0, k + 1)}", f"l{k + 1}", origin,
                tuple(axis / np.linalg.norm(axis)), (-9.0, 9.0), 2.0, follows,
            )
        )  # fmt: skip
    return robot_of(*joints)


def values_of(robot, free):
    """Values of all joints by those of leaders, followers of followers included."""
    known = {joint.name: joint for joint in robot.joints}

    def value(name):
        joint = known[name]
        if joint.type == "fixed":
            return 0.0
        if joint.follows is None:
            return free[name]
        return joint.follows[1] * value(joint.follows[0]) + joint.follows[2]

    return {name: value(name) for name in known}


def poses_of(robot, values):
    """Poses (4, 4) of the links from the root on."""
    poses = {"l0": np.eye(4)}
    for joint in robot.joints:
        step = joint.origin @ motion(joint.type, joint.axis, values[joint.name])
        poses[joint.child] = poses[joint.parent] @ step
    return poses


@pytest.mark.parametrize("seed", range(60))
def test_every_link_is_where_the_whole_robot_has_it(seed):
    """Chains begin anywhere; coordinates get values that a free choice of leaders gives them."""
    robot, rng = drawn(seed), np.random.default_rng(seed)
    above = {joint.child: joint.parent for joint in robot.joints}
    tip = f"l{len(robot.joints)}"
    base = above[tip] if seed % 3 else "l0"
    way, link = [], tip
    while link != base:
        way.insert(0, next(joint for joint in robot.joints if joint.child == link))
        link = above[link]
    made, leads = arranged(robot, base, way, {}), leads_of(robot)
    free = {j.name: float(rng.uniform(-1, 1)) for j in robot.joints if j.follows is None}
    moved = {placed.joint.name for placed in made.placed}
    leaders = {leads[name].leader for name in moved}
    free |= {name: 0.0 for name in free if name not in leaders}  # these stand
    values = values_of(robot, free)
    poses, frames, found = poses_of(robot, values), [np.eye(4)], []
    for joint, parent, pose, axis, follows in made.placed:
        value = values[joint.name]
        if follows is not None:
            value = follows.factor * found[follows.joint - 1] + follows.offset
        found.append(value)
        frames.append(frames[parent] @ pose @ motion(joint.type, axis, value))
    assert found == pytest.approx([values[placed.joint.name] for placed in made.placed])
    for name, (number, pose) in made.frames.items():
        wanted = np.linalg.inv(poses[base]) @ poses[name]
        assert frames[number] @ pose == pytest.approx(wanted, abs=1e-9)
    assert made.frames.keys() == poses.keys()
    # whoever shares a leader with the way moves
    for name, lead in leads.items():
        kind = next(joint.type for joint in robot.joints if joint.name == name)
        assert (name in moved) == (lead.leader in leaders and lead.factor != 0 and kind != "fixed")


def test_a_follower_on_the_chain_has_no_coordinate():
    model = chain_of(
        robot_of(turning("a", "base", "one"), turning("b", "one", "two", ("a", -1.0, 0.1))),
        "base", "two",
    ).model  # fmt: skip
    assert [joint.name for joint in model.coordinates] == ["a"]
    assert model.values(np.array([0.7])) == pytest.approx([0.7, -0.6])
    assert model.ranges[0] == pytest.approx((-1.9, 2.0))


def test_a_leader_behind_its_follower_or_off_the_chain():
    behind = chain_of(
        robot_of(turning("a", "base", "one", ("b", 2.0, 0.1)), turning("b", "one", "two")),
        "base", "two",
    ).model  # fmt: skip
    assert [joint.name for joint in behind.coordinates] == ["a"]
    assert behind.values(np.array([0.5])) == pytest.approx([0.5, 0.2])
    beside = chain_of(
        robot_of(
            turning("a", "base", "one"), turning("b", "one", "two", ("crank", 0.5, 0.0)),
            turning("crank", "base", "motor"),
        ),
        "base", "two",
    ).model  # fmt: skip
    assert [joint.name for joint in beside.joints] == ["a", "crank", "b"]
    assert [joint.name for joint in beside.coordinates] == ["a", "crank"]
    assert beside.joints[2].parent == 1


def gripper(**at):
    """Values at which a gripper of three joints behind a chain stands."""
    robot = robot_of(
        turning("a", "base", "one"), turning("left", "one", "l", range=(0.05, 0.5)),
        turning("right", "one", "r", ("left", 2.0, 0.1)),
        turning("tip", "r", "t", ("right", -1.0, 0.0)),
    )  # fmt: skip
    made = arranged(robot, "base", robot.joints[:1], at)
    turns = [made.frames["l"][1], made.frames["r"][1]]
    turns.append(np.linalg.inv(made.frames["r"][1]) @ made.frames["t"][1])
    return [float(Rotation.from_matrix(t[:3, :3]).as_rotvec()[2]) for t in turns]


def test_what_stands_still_follows_its_leader_too():
    assert gripper() == pytest.approx([0.05, 0.2, -0.2])  # the leader cannot stand at 0
    assert gripper(left=0.2) == pytest.approx([0.2, 0.5, -0.5])
    assert gripper(right=0.5) == gripper(left=0.2) == gripper(tip=-0.5)
    for at, reason in (
        ({"left": 0.2, "right": 0.1}, "joint 'right' follows 'left', which stands elsewhere"),
        ({"left": 0.6}, "joint 'left' stands from 0.05 to 0.5"),
        ({"right": 0.1}, "joint 'left' stands from 0.05 to 0.5"),
        ({"a": 0.1}, "joint 'a' is one of the chain's"),
    ):
        with pytest.raises(RobotError, match=reason):
            gripper(**at)


def test_a_circle_of_followers_is_refused():
    robot = robot_of(turning("a", "x", "y", ("b", 1.0, 0.0)), turning("b", "y", "z", ("a", 1.0, 0)))
    with pytest.raises(RobotError, match="joint 'a': follows itself"):
        chain_of(robot, "x", "z")


MJCF = """<mujoco><compiler angle="radian"/><worldbody><body name="base"><geom size="0.05"/>
 <body name="s1" pos="0 0 0.1"><joint name="e1" type="slide" axis="1 0 0" range="0 0.2" ref="0.1"/>
  <geom size="0.05" pos="0.15 0 0"/><body name="s2" pos="0.1 0 0">
   <joint name="e2" type="slide" axis="1 0 0" range="-1 1" ref="0.3"/><geom size="0.05"/>
   <body name="pin" pos="0 0.2 0"><joint name="p" axis="0 0 1" range="-1 1"/><geom size="0.03"/>
   </body></body></body>
 <body name="stand" pos="0 1 0"><joint name="q" axis="0 0 1" range="-1 1"/><geom size="0.02"/>
 </body></body></worldbody>
 <tendon><fixed name="t"><joint joint="e1" coef="1"/><joint joint="e2" coef="-1"/></fixed></tendon>
 <equality>{}</equality></mujoco>"""


def mjcf(tmp_path, equality):
    """A robot of sliding joints, with an equality."""
    pytest.importorskip("mujoco")
    file = tmp_path / "arm.xml"
    file.write_text(MJCF.format(equality), "utf-8")
    return chain_of(read_robot(file), "base", "s2", max_speed=[1.0]).model


def test_equalities_of_mujoco_are_lines_about_its_reference(tmp_path):
    model = mjcf(tmp_path, '<joint joint1="e2" joint2="e1" polycoef="0.01 2"/>')
    assert [joint.name for joint in model.coordinates] == ["e1"]
    # y - 0.3 = 0.01 + 2 (x - 0.1)
    assert model.values(np.array([0.15]))[1] == pytest.approx(0.41)
    model = mjcf(tmp_path, '<joint joint1="p" joint2="e1" polycoef="0 2"/>')
    assert [joint.name for joint in model.joints] == ["e1", "e2", "p"] and model.dof == 2
    fixed = mjcf(tmp_path, '<joint joint1="e2" polycoef="0.01"/>')
    assert [joint.name for joint in fixed.joints] == ["e1"]
    idle = mjcf(tmp_path, '<joint joint1="e2" joint2="e1" active="false"/>')
    assert idle.dof == 2
    both = '<joint joint1="e2" joint2="e1"/><joint joint1="e2" joint2="p" polycoef="0 4"/>'
    model = mjcf(tmp_path, both)
    assert model.dof == 1
    assert model.values(np.array([0.1])) == pytest.approx([0.1, 0.3, 0.0])


@pytest.mark.parametrize(
    ("equality", "reason"),
    [
        ('<joint joint1="e2" joint2="e1" polycoef="0 1 3"/>', "'e2': follows 'e1' by a curve"),
        ('<connect name="bar" body1="s2" body2="stand" anchor="0 0 0"/>', "'bar' ties 's2' to"),
        ('<weld body1="s1" body2="stand"/>', "ties 's1' to 'stand'"),
        ('<tendon tendon1="t"/>', "couples tendons, of joints e1, e2"),
        ('<joint joint1="e2" joint2="e1"/><joint joint1="e1" joint2="e2"/>', "binds it twice"),
    ],
)
def test_bonds_that_are_no_line_are_refused_by_name(tmp_path, equality, reason):
    with pytest.raises(RobotError, match=reason):
        mjcf(tmp_path, equality)


def test_bonds_of_what_stands_still_do_not_matter(tmp_path):
    for equality in (
        '<joint joint1="q" joint2="p" polycoef="0 1 3"/>',
        '<connect body1="base" body2="stand" anchor="0 0 0"/>',
        '<weld body1="s2" body2="pin"/>',
    ):
        assert mjcf(tmp_path, equality).dof == 2
