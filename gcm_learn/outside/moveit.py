"""Planning scenes and motion plan requests of MoveIt, as their messages are written in YAML."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from gcm_learn.arms import Base, ChainModel, quaternion_of, rotation_of
from gcm_learn.checks import quote, show
from gcm_learn.outside.nodes import Node, unique
from gcm_learn.situation import Body, Box, Cylinder, Mesh, SolidQuadratic, SolidShape, Sphere

TYPES = {1: "box", 2: "sphere", 3: "cylinder", 4: "cone", 5: "prism"}
"""Numbers of shapes in ``shape_msgs/SolidPrimitive``."""
SIZES = {"box": 3, "sphere": 1, "cylinder": 2}
"""Shapes that are understood, and how many dimensions they have."""
OBJECT = (
    "id", "header", "pose", "type", "operation", "primitives", "primitive_poses", "meshes",
    "mesh_poses", "planes", "plane_poses", "subframe_names", "subframe_poses",
)  # fmt: skip
"""Fields of ``moveit_msgs/CollisionObject``."""
REQUEST = (
    "workspace_parameters", "start_state", "goal_constraints", "path_constraints",
    "trajectory_constraints", "reference_trajectories", "pipeline_id", "planner_id", "group_name",
    "num_planning_attempts", "allowed_planning_time", "max_velocity_scaling_factor",
    "max_acceleration_scaling_factor", "cartesian_speed_end_effector_link",
    "cartesian_speed_limited_link", "max_cartesian_speed",
)  # fmt: skip
"""Fields of ``moveit_msgs/MotionPlanRequest``."""
SCENE = (
    "name", "robot_model_name", "robot_state", "fixed_frame_transforms", "link_padding",
    "link_scale", "allowed_collision_matrix", "object_colors", "world", "is_diff",
)  # fmt: skip
"""Fields of ``moveit_msgs/PlanningScene``."""
FIRST_LINKS = ("base", "base_link", "{}_link0", "{}_base_link")
"""Frames in the robot's base; braces stand for its name."""


@dataclass(frozen=True)
class Pose:
    """A place and a turn.

    Parameters
    ----------
    place : (3,) ndarray
    turn : (3, 3) ndarray
    """

    place: np.ndarray
    turn: np.ndarray

    def then(self, other: Pose) -> Pose:
        """Return the composed pose of `other`, which is given in the frame of this pose."""
        return Pose(self.place + self.turn @ other.place, self.turn @ other.turn)


IDENTITY = Pose(np.zeros(3), np.eye(3))


def bodies_of(scene: Node, world: Pose = IDENTITY) -> tuple[Body, ...]:
    """Return the obstacles of a planning scene, at rest.

    Parameters
    ----------
    scene : Node
        A ``moveit_msgs/PlanningScene``.
    world : Pose, optional
        Of the scene's frame in the world.

    Raises
    ------
    FileFormatError
        Names file and field, for planes, octomaps and whatever else is not understood.
    """
    scene.members(SCENE)
    state = scene.find("robot_state")
    attached = None if state is None else state.find("attached_collision_objects")
    if attached is not None:
        raise attached.error("objects that the robot holds are not understood")
    content = scene.at("world")
    content.members(("collision_objects", "octomap"))
    _refuse_octomap(content.find("octomap"))
    frames = {name: world.then(pose) for name, pose in _frames_of(scene).items()}
    objects = content.find("collision_objects")
    rows = [] if objects is None else objects.rows()
    unique((row.at("id"), row.at("id").text()) for row in rows)
    bodies = [body for row in rows for body in _object(row, frames)]
    unique((content, body.name) for body in bodies)
    return tuple(bodies)


def _refuse_octomap(octomap: Node | None) -> None:
    if octomap is None:
        return
    inner = octomap.find("octomap") or octomap
    if inner.find("data") is not None or not isinstance(inner.value, dict):
        raise octomap.error("octomaps are not understood")


def _frames_of(scene: Node) -> dict[str, Pose]:
    """Return the poses of the frames in which objects may be given."""
    robot, state = scene.find("robot_model_name"), scene.find("robot_state")
    name = "" if robot is None else robot.text()
    base = IDENTITY if state is None else base_pose(state)
    frames = {"": IDENTITY, "world": IDENTITY}
    frames |= dict.fromkeys((frame.format(name) for frame in FIRST_LINKS), base)
    given = scene.find("fixed_frame_transforms")
    for row in [] if given is None else given.rows():
        frames[row.at("child_frame_id").text()] = _transform(row.at("transform"))
    return frames


def _transform(node: Node) -> Pose:
    """Return the pose of a ``geometry_msgs/Transform``."""
    node.members(("translation", "rotation"))
    turn = rotation_of(node.at("rotation").turn())
    return Pose(np.array(node.at("translation").point()), turn)


def _pose(node: Node) -> Pose:
    """Return the pose of a ``geometry_msgs/Pose``; an absent orientation is the identity."""
    node.members(("position", "orientation"))
    turn = node.find("orientation")
    place = np.array(node.at("position").point())
    return Pose(place, np.eye(3) if turn is None else rotation_of(turn.turn()))


def _object(node: Node, frames: dict[str, Pose]) -> Iterator[Body]:
    """Return a body for each primitive and each mesh of a collision object."""
    node.members(OBJECT)
    planes = node.find("planes")
    if planes is not None:
        raise planes.error("planes are not understood")
    operation = node.find("operation")
    if operation is not None and operation.value not in (0, "0", "\0", "add", "ADD"):
        raise operation.error(f"must be 0, to add an object (got {show(operation.value)})")
    frame, pose = _frame(node, frames), node.find("pose")
    own = frame if pose is None else frame.then(_pose(pose))
    shapes = [*_posed(node, "primitives", _shape), *_posed(node, "meshes", _mesh)]
    name = node.at("id").text()
    for k, (shape, given) in enumerate(shapes):
        where, rest = own.then(given), (0.0, 0.0, 0.0)
        motion = SolidQuadratic(tuple(where.place.tolist()), rest, rest, quaternion_of(where.turn))
        called = name if len(shapes) == 1 else f"{name}/{k + 1}"
        yield Body("obstacle", called, shape, motion)


def _posed(
    node: Node, many: str, made: Callable[[Node], SolidShape | Mesh]
) -> Iterator[tuple[SolidShape | Mesh, Pose]]:
    """Return shapes of a collision object with their poses."""
    place = node.inside("primitive_poses" if many == "primitives" else "mesh_poses")
    found = node.find(many)
    shapes, poses = found.rows() if found else [], place.rows() if place.value else []
    if len(shapes) != len(poses):
        raise place.error(f"has {len(poses)} entries for {len(shapes)} {many}")
    return ((made(shape), _pose(pose)) for shape, pose in zip(shapes, poses, strict=True))


def _frame(node: Node, frames: dict[str, Pose]) -> Pose:
    """Return the pose of the frame that an object's header names."""
    header = node.find("header")
    named = None if header is None else header.find("frame_id")
    if named is None:
        return frames[""]
    frame = named.text().removeprefix("/")
    if frame not in frames:
        raise named.error(f"the pose of {quote(frame)} is not known")
    return frames[frame]


def _shape(node: Node) -> SolidShape:
    """Return the shape of a ``shape_msgs/SolidPrimitive``."""
    node.members(("type", "dimensions", "polygon"))
    given = node.at("type").value
    kind = TYPES.get(given, given) if isinstance(given, int) else str(given).lower()
    if kind not in SIZES:
        known = ", ".join(SIZES)
        called = quote(kind) if isinstance(kind, str) else show(kind)
        raise node.at("type").error(f"{called} is not understood (known: {known})")
    sizes = node.at("dimensions")
    given = sizes.numbers(SIZES[kind])
    if kind == "box":
        return sizes.checked(Box, tuple(0.5 * size for size in given))
    if kind == "sphere":
        return sizes.checked(Sphere, *given)
    height, radius = given
    return sizes.checked(Cylinder, radius, 0.5 * height)


def _mesh(node: Node) -> Mesh:
    """Return the shape of a ``shape_msgs/Mesh``."""
    node.members(("triangles", "vertices"))
    vertices = [row.point() for row in node.at("vertices").rows()]
    triangles = [row.at("vertex_indices").value for row in node.at("triangles").rows()]
    return node.checked(Mesh, vertices, triangles)


def start_of(request: Node, scene: Node) -> Node:
    """Return the robot's state from which a request starts: the request's, or else the scene's."""
    given = request.find("start_state")
    joints = None if given is None else given.find("joint_state")
    if given is None or joints is None or joints.find("name") is None:
        return scene.at("robot_state")
    if given.find("attached_collision_objects") is not None:
        reason = "objects that the robot holds are not understood"
        raise given.at("attached_collision_objects").error(reason)
    return given


def posture_of(state: Node, model: ChainModel, robot: str) -> tuple[float, ...]:
    """Return the values (n,) of an arm's joints in a robot's state.

    Joints that the arm does not have, such as fingers, are left out.

    Parameters
    ----------
    state : Node
        A ``moveit_msgs/RobotState``.
    model : ChainModel
    robot : str
        Name of the robot, with which names of joints may begin.
    """
    joints = state.at("joint_state")
    names, values = joints.at("name").rows(), joints.at("position").rows()
    if len(names) != len(values):
        reason = f"has {len(values)} entries for {len(names)} names"
        raise joints.at("position").error(reason)
    given = {name.text(): value for name, value in zip(names, values, strict=True)}
    unique((name, name.text()) for name in names)
    return _in_order(joints, given, model, robot)


def goal_of(request: Node, model: ChainModel, robot: str) -> tuple[float, ...]:
    """Return the joint values (n,) that the goal of a request asks for.

    Raises
    ------
    FileFormatError
        If there is another goal than one posture, or a constraint on the way to it.
    """
    request.members(REQUEST)
    _refuse_constraints(request)
    goals = request.at("goal_constraints").rows()
    if len(goals) != 1:
        raise request.at("goal_constraints").error(f"must have one goal (got {len(goals)})")
    (goal,) = goals
    for name in goal.members():
        if name not in ("name", "joint_constraints") and goal.find(name) is not None:
            raise goal.inside(name).error("only joint_constraints are understood")
    rows = goal.at("joint_constraints").rows()
    unique((row.at("joint_name"), row.at("joint_name").text()) for row in rows)
    given = {row.at("joint_name").text(): row.at("position") for row in rows}
    where = goal.at("joint_constraints")
    followers = {joint.name for joint in model.joints if joint.follows is not None}
    extra = set(given) - followers - set(_names(where, model, robot, given))
    if extra:
        raise where.error(f"{quote(min(extra))} is no joint of the arm {quote(model.name)}")
    return _in_order(where, given, model, robot)


def _refuse_constraints(request: Node) -> None:
    """Refuse constraints of the way, if they are more than empty lists."""
    for name in ("path_constraints", "trajectory_constraints", "reference_trajectories"):
        found = request.find(name)
        parts = found.value.values() if found and isinstance(found.value, dict) else [found]
        if found is not None and any(parts):
            raise found.error("is not understood")


def _names(node: Node, model: ChainModel, robot: str, given: dict[str, Node]) -> Sequence[str]:
    """Return the names of an arm's joints in a file."""
    names = []
    for joint in model.coordinates:
        called = [name for name in (joint.name, f"{robot}_{joint.name}") if name in given]
        if not called or not joint.name:
            raise node.error(f"has no value for joint {quote(joint.name)} of {quote(model.name)}")
        names.append(called[0])
    return names


def _in_order(
    node: Node, given: dict[str, Node], model: ChainModel, robot: str
) -> tuple[float, ...]:
    return tuple(given[name].number() for name in _names(node, model, robot, given))


def base_pose(state: Node) -> Pose:
    """Return the pose of a robot's base from its floating joint; the identity without one."""
    floating = state.find("multi_dof_joint_state")
    transforms = None if floating is None else floating.find("transforms")
    if transforms is None:
        return IDENTITY
    rows = transforms.rows()
    if len(rows) > 1:
        raise transforms.error(f"must have one entry, the robot's base (got {len(rows)})")
    return _transform(rows[0])


def base_of(state: Node, scene: Node) -> Base:
    """Return the base of an arm from its robot's start `state`, or else from the scene's state."""
    given = state.find("multi_dof_joint_state")
    other = scene.find("robot_state")
    if other is not None and (given is None or given.find("transforms") is None):
        state = other
    pose = base_pose(state)
    return Base(tuple(pose.place.tolist()), quaternion_of(pose.turn))
