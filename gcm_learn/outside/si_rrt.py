"""Scenes of SI-RRT: boxes and balls whose poses are given frame by frame, and a goal posture."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import ClassVar

import numpy as np

from gcm_learn.arms import Base, Chain, ChainModel
from gcm_learn.checks import positive, quote
from gcm_learn.errors import SituationError
from gcm_learn.outside import converted
from gcm_learn.outside.nodes import Node, json_nodes, unique
from gcm_learn.situation import (
    Body,
    Box,
    Sampled,
    Situation,
    SolidMotion,
    SolidQuadratic,
    SolidShape,
    Sphere,
)

FILES = r".+\.json(\.gz)?"
KEPT = 1e-6
"""Largest error of a pose that is left out, in each number."""
LEAST = 0.1
"""Least product of neighbouring orientations, 1 where they are equal."""
SHAPES = ("box", "sphere")
FIELDS = (
    "start_configuration", "end_configuration", "robot_joint_max_velocity", "start_time",
    "robot_capsules_radius", "robot_urdf", "robot_joints_order", "robot_base_coords",
    "robot_base_quat_rot", "frame_count", "fps", "blender_file_path", "obstacles",
)  # fmt: skip
"""Fields of a scene."""


@dataclass(frozen=True)
class SiRrt:
    """Settings of a conversion.

    Parameters
    ----------
    arm : str, optional
        Name of an arm that ships or an arm file, whose joints have the names of the scene's.  By
        default the shipped ``xarm6`` with the radii of the scene.
    horizon : float, optional
        Of every situation [s]; by default the time of all frames.
    within : float
        Largest angle between the hand's axis and that of the goal posture [rad].
    grasp : float
        Distance of hand and target at which it is caught [m].
    """

    arm: str | None = None
    horizon: float | None = None
    within: float = converted.WITHIN
    grasp: float = converted.GRASP

    summary: ClassVar[str] = "scenes of SI-RRT, with boxes that move frame by frame"

    def convert(self, sources: Sequence[Path]) -> converted.Converted:
        """Return a situation for each scene."""
        result, model = converted.Converted(), converted.model_named(self.arm or "xarm6")
        for scene in json_nodes(sources, FILES, result.leaving_out):
            name = Path(scene.file).name.split(".json")[0]
            taken = {situation.name for situation in result.situations}
            name = name if name not in taken else f"{name}-{len(taken) + 1}"
            with result.leaving_out():
                situation, goal = self._convert(name, scene, model)
                result.count("the start is blocked", converted.is_blocked(situation))
                ended = converted.goal_is_blocked(at_end(situation), goal)
                result.count("the goal posture is blocked at the end", ended)
                result.situations.append(situation)
        return result.at_least_one()

    def _convert(
        self, name: str, scene: Node, model: ChainModel
    ) -> tuple[Situation[Chain], tuple[float, ...]]:
        scene.members(FIELDS)
        start_time = scene.find("start_time")
        if start_time is not None and start_time.number() != 0.0:
            raise start_time.error(f"must be 0 (got {start_time.number():g})")
        order = _order(scene.at("robot_joints_order"), model)
        start = _sorted(scene.at("start_configuration"), order)
        goal = _sorted(scene.at("end_configuration"), order)
        rate = _rate(scene.at("fps"))
        horizon = self.horizon
        if horizon is None:
            horizon = scene.at("frame_count").number() / rate
        bodies = tuple(_bodies(scene.at("obstacles"), rate))
        base = Base(scene.at("robot_base_coords").point(), scene.at("robot_base_quat_rot").turn())
        try:
            arm = Chain(self._measured(model, scene, order), start, self.grasp, base)
            target = converted.resting_target(arm, goal, self.within)
            return Situation(name, horizon, arm, (target, *bodies)), goal
        except SituationError as error:
            raise scene.error(str(error)) from None

    def _measured(self, model: ChainModel, scene: Node, order: Sequence[int]) -> ChainModel:
        """Return the model with the speeds and radii that the scene gives.

        A model given by `arm` keeps its radii.
        """
        speeds, radii = scene.find("robot_joint_max_velocity"), scene.find("robot_capsules_radius")
        if speeds is not None:
            faster = iter(_sorted(speeds, order))
            joints = (
                replace(joint, max_speed=next(faster)) if joint.follows is None else joint
                for joint in model.joints
            )
            model = replace(model, joints=tuple(joints))
        if radii is not None and self.arm is None:
            wider = zip(model.links, radii.numbers(len(model.links)), strict=True)
            model = replace(model, links=tuple(replace(link, radius=r) for link, r in wider))
        return model


def at_end(situation: Situation[Chain]) -> Situation[Chain]:
    """Return the situation with bodies that rest where their samples end."""
    bodies = []
    for body in situation.bodies:
        if isinstance(body.motion, Sampled):
            last = body.motion.pieces[-1].motion
            body = replace(body, motion=last)
        bodies.append(body)
    return replace(situation, bodies=tuple(bodies))


def _order(node: Node, model: ChainModel) -> list[int]:
    """Return where in a scene's lists the values of each joint of an arm are."""
    given = [row.text() for row in node.rows()]
    wanted = [joint.name for joint in model.coordinates]
    if sorted(given) != sorted(wanted):
        names = ", ".join(wanted)
        raise node.error(f"must be the joints of {quote(model.name)} ({names})")
    return [given.index(name) for name in wanted]


def _sorted(node: Node, order: Sequence[int]) -> tuple[float, ...]:
    given = node.numbers(len(order))
    return tuple(given[k] for k in order)


def _rate(node: Node) -> float:
    return node.checked(positive, node.number(), "")


def _bodies(obstacles: Node, rate: float) -> Iterator[Body]:
    """Return the obstacles of a scene."""
    rows = obstacles.rows()
    unique((row.at("name"), row.at("name").text()) for row in rows)
    for row in rows:
        moves, shape = _shape(row)
        poses = row.at("positions").rows()
        if not poses:
            raise row.at("positions").error("must not be empty")
        motion = _motion(row, poses if moves else poses[:1], rate)
        yield Body("obstacle", row.at("name").text(), shape, motion)


def _shape(row: Node) -> tuple[bool, SolidShape]:
    """Return whether an obstacle moves, and its shape."""
    given = row.at("type")
    manner, _, kind = given.text().partition("_")
    if manner not in ("static", "dynamic") or kind not in SHAPES:
        known = ", ".join(f"{m}_{k}" for k in SHAPES for m in ("static", "dynamic"))
        raise given.error(f"{quote(given.text())} is not understood (known: {known})")
    row.members(("name", "type", "positions", "dimensions" if kind == "box" else "radius"))
    if kind == "sphere":
        radius = row.at("radius")
        return manner == "dynamic", radius.checked(Sphere, radius.number())
    sizes = row.at("dimensions")
    half = tuple(0.5 * size for size in sizes.numbers(3))
    return manner == "dynamic", sizes.checked(Box, half)


def _motion(row: Node, poses: Sequence[Node], rate: float) -> SolidMotion:
    """Return the motion through `poses`, one pose for each frame."""
    given = [_pose(pose) for pose in poses]
    places = np.array([place for place, _ in given])
    turns = np.array([turn for _, turn in given])
    for k in range(1, len(turns)):  # the same side of the sphere, so that neighbours are near
        if turns[k] @ turns[k - 1] < 0.0:
            turns[k] = -turns[k]
    kept = thinned(places, turns)
    if len(kept) == 1:
        (x, y, z), (a, b, c, d) = places[0].tolist(), turns[0].tolist()
        return SolidQuadratic((x, y, z), converted.REST, converted.REST, (a, b, c, d))
    times = tuple((np.array(kept) / rate).tolist())
    return row.at("positions").checked(
        Sampled, times, tuple(map(_floats, places[kept])), tuple(map(_floats, turns[kept]))
    )


def _pose(node: Node) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Return place and orientation (w, x, y, z) of one frame."""
    rows = node.rows()
    if len(rows) != 7:
        raise node.error(f"must be a list of 7 numbers, place and x, y, z, w (got {len(rows)})")
    place = tuple(row.number() for row in rows[:3])
    return place, Node(node.file, f"{node.path}[3:7]", node.value[3:]).turn()


def _floats(array: np.ndarray) -> tuple[float, ...]:
    return tuple(array.tolist())


def thinned(places: np.ndarray, turns: np.ndarray) -> list[int]:
    """Return the frames that are kept: the others follow from them to 1e-6.

    Bodies rest after the last sample, so a rest at the end is left out.

    Parameters
    ----------
    places : (m, 3) ndarray
    turns : (m, 4) ndarray
        Unit quaternions, neighbours of the same sign.
    """
    kept, last = [0], len(places)
    while last > 1 and _rests(places, turns, last - 2):
        last -= 1
    while kept[-1] < last - 1:
        begin, step = kept[-1], 1
        while begin + 2 * step < last and _follow(places, turns, begin, begin + 2 * step):
            step *= 2
        good, bad = begin + step, min(begin + 2 * step, last)
        while bad - good > 1:
            middle = (good + bad) // 2
            good, bad = (middle, bad) if _follow(places, turns, begin, middle) else (good, middle)
        kept.append(good)
    return kept


def _rests(places: np.ndarray, turns: np.ndarray, k: int) -> bool:
    """Return whether frame k has the pose of the last frame."""
    gap = np.abs(places[k] - places[-1]).max(), np.abs(turns[k] - turns[-1]).max()
    return max(gap) <= KEPT


def _follow(places: np.ndarray, turns: np.ndarray, begin: int, end: int) -> bool:
    """Return whether all frames between two follow from these."""
    share = np.linspace(0.0, 1.0, end - begin + 1)[:, None]
    straight = places[begin] + share * (places[end] - places[begin])
    if np.abs(straight - places[begin : end + 1]).max() > KEPT:
        return False
    product = float(turns[begin] @ turns[end])
    if product < LEAST:
        return False
    angle = float(np.arccos(min(product, 1.0)))
    if angle < KEPT:
        turned = turns[begin] + share * (turns[end] - turns[begin])
    else:
        first, second = np.sin((1.0 - share) * angle), np.sin(share * angle)
        turned = (first * turns[begin] + second * turns[end]) / np.sin(angle)
    return bool(np.abs(turned - turns[begin : end + 1]).max() <= KEPT)
