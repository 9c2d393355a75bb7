"""Problems of MotionBenchMaker: a planning scene and a motion plan request each."""

from __future__ import annotations

import re
import zlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

from gcm_learn.arms import Chain, ChainModel
from gcm_learn.checks import non_negative, quote
from gcm_learn.errors import FileFormatError, SituationError
from gcm_learn.outside import converted
from gcm_learn.outside.in_motion import in_motion
from gcm_learn.outside.moveit import base_of, bodies_of, goal_of, posture_of, start_of
from gcm_learn.outside.nodes import Careful, Node, texts, yaml_node
from gcm_learn.seeding import rng
from gcm_learn.situation import Situation

Files = dict[str, tuple[str, str]]  # name and text of scene and request
FILES = r"(scene|request)(\d+)\.ya?ml"
GRASPED = "the fingers may touch the object that they grasp"
START_BLOCKED = "the start is blocked"
GOAL_BLOCKED = "the goal posture is blocked"


@dataclass(frozen=True)
class MotionBenchMaker:
    """Settings of a conversion.

    Parameters
    ----------
    arm : str, optional
        Name of an arm that ships or an arm file; by default the robot that a scene names.
    horizon : float
        Of every situation [s].
    within : float
        Largest angle between the hand's axis and that of the goal posture [rad].
    grasp : float
        Distance of hand and target at which it is caught [m].
    moving : int, optional
        Seed with which scenes are set in motion; at rest by default.
    """

    arm: str | None = None
    horizon: float = 6.0
    within: float = converted.WITHIN
    grasp: float = converted.GRASP
    moving: int | None = None

    summary: ClassVar[str] = "MoveIt planning scenes and requests, as MotionBenchMaker has them"

    def convert(self, sources: Sequence[Path]) -> converted.Converted:
        """Return a situation for each pair of a scene and a request."""
        non_negative(0 if self.moving is None else self.moving, "moving")
        result, names = converted.Converted(), set()
        for source in sources:
            for name, files in _problems(source, result.leaving_out):
                with result.leaving_out():
                    scene, request = _pair(files)
                    if name in names:
                        raise scene.error(f"there is another problem {quote(name)}")
                    result.situations.append(self._convert(name, scene, request, result))
                    names.add(name)
        return result.at_least_one()

    def _convert(
        self, name: str, scene: Node, request: Node, counts: converted.Converted
    ) -> Situation[Chain]:
        robot, model = self._model(scene)
        state, goal = start_of(request, scene), goal_of(request, model, robot)
        bodies = bodies_of(scene)
        try:
            arm = Chain(model, posture_of(state, model, robot), self.grasp, base_of(state, scene))
            target = converted.resting_target(arm, goal, self.within)
            resting = Situation(name, self.horizon, arm, (target, *bodies))
        except SituationError as error:
            raise request.error(str(error)) from None
        situation = converted.grasping(resting, goal)
        counts.count(GRASPED, situation is not resting)
        blocked = counts.count(START_BLOCKED, converted.is_blocked(situation))
        counts.count(GOAL_BLOCKED, converted.goal_is_blocked(situation, goal))
        if self.moving is None:
            return situation
        return in_motion(situation, goal, rng(self.moving, zlib.crc32(name.encode())), blocked)

    def _model(self, scene: Node) -> tuple[str, ChainModel]:
        """Return the robot's name in the scene, and its arm model."""
        robot = scene.at("robot_model_name") if self.arm is None else scene.find("robot_model_name")
        name = "" if robot is None else robot.text()
        if self.arm is not None:
            return name, converted.model_named(self.arm)
        try:
            return name, converted.model_named(name)
        except SituationError as error:
            reason = f"{error.reason}; --arm FILE gives another"
            raise scene.at("robot_model_name").error(reason) from None


def _problems(source: Path, careful: Careful) -> Iterator[tuple[str, Files]]:
    """Return name and files of every problem of a folder or an archive."""
    found: dict[tuple[str, str], Files] = {}
    for file, text in texts(source, FILES, careful):
        path = Path(file)
        match = re.fullmatch(FILES, path.name)
        if match is None:
            raise FileFormatError(f"{source}: is neither a folder nor a tar archive")
        found.setdefault((str(path.parent), match[2]), {})[match[1]] = (file, text)
    for (folder, number), files in found.items():
        yield f"{Path(folder).name}-{number}", files


def _pair(files: Files) -> tuple[Node, Node]:
    """Return scene and request of a problem."""
    for kind, other in (("scene", "request"), ("request", "scene")):
        if kind not in files:
            there = files[other][0]
            raise FileFormatError(f"{there}: there is no {kind} of that number beside it")
    return yaml_node(*files["scene"]), yaml_node(*files["request"])
