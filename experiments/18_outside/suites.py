"""Situations of others' suites: which are drawn, and what is known of them.

A part of two suites serves for development and is never drawn.  It holds the problems of
MotionBenchMaker up to number 20 of each set, and the first 500 balls of a file.
"""

from __future__ import annotations

import json
import re
import tarfile
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from gcm_learn import seeding
from gcm_learn.outside import (
    MotionBenchMaker,
    SiRrt,
    TableTennis,
    goal_of,
    json_nodes,
    yaml_node,
)
from gcm_learn.outside.converted import goal_is_blocked, is_blocked
from gcm_learn.scene import later

EACH = 8  # problems of each set of MotionBenchMaker, at rest and in motion
BALLS = 40
STARTS = 4  # instants of each scene of SI-RRT at which a situation begins
DEVELOPED = {"problems": 20, "balls": 500}
"""Problems and balls that were looked at before; they come first in their sets and files."""
MOVING = 18
"""Seed with which MotionBenchMaker is set in motion."""
RESTING, IN_MOTION, BOXES, TENNIS = (
    "MotionBenchMaker", "MotionBenchMaker in motion", "SI-RRT", "table tennis",
)  # fmt: skip
SUITES = (RESTING, IN_MOTION, BOXES, TENNIS)


@dataclass(frozen=True)
class Question:
    """A situation of a suite.

    Parameters
    ----------
    suite, family, name : str
        The family is the set of problems or the scene.
    situation : Situation
    goal : (n,) tuple of float, optional
        The suite's own goal posture; balls have none.
    start_blocked, goal_blocked : bool
        Whether our capsules touch there; of a scene in motion, the goal at t = 0 or as at rest.
    """

    suite: str
    family: str
    name: str
    situation: Any
    goal: tuple[float, ...] | None
    start_blocked: bool
    goal_blocked: bool


def problems(
    archive: Path, seed: int, each: int = EACH, development: bool = False
) -> Iterator[Question]:
    """Yield problems of MotionBenchMaker at rest, `each` of every set, then all in motion."""
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        _unpack(archive, seed, each, development, folder)
        goals: dict[str, tuple[tuple[float, ...], bool]] = {}
        for suite, moving in ((RESTING, None), (IN_MOTION, MOVING)):
            for situation in MotionBenchMaker(moving=moving).convert([folder]).situations:
                family, _, number = situation.name.rpartition("-")
                if moving is None:
                    goal = _goal(folder / family / f"request{number}.yaml", situation)
                    goals[situation.name] = goal, goal_is_blocked(situation, goal)
                yield Question(
                    suite,
                    family,
                    situation.name,
                    situation,
                    goals[situation.name][0],
                    is_blocked(situation),
                    goals[situation.name][1],
                )


def _unpack(archive: Path, seed: int, each: int, development: bool, folder: Path) -> None:
    """Extract the problems that are drawn."""
    with tarfile.open(archive) as packed:
        found: dict[str, dict[int, list[tarfile.TarInfo]]] = {}
        for member in packed:
            match = re.fullmatch(r"(?:.*/)?([^/]+)/(?:scene|request)(\d+)\.yaml", member.name)
            if match is not None:
                found.setdefault(match[1], {}).setdefault(int(match[2]), []).append(member)
        for k, name in enumerate(sorted(found)):
            numbers = [n for n in sorted(found[name]) if _is_new(n, development)]
            drawn = seeding.rng(seed, k).choice(numbers, min(each, len(numbers)), replace=False)
            (folder / name).mkdir()
            for member in (one for n in sorted(drawn.tolist()) for one in found[name][n]):
                content = packed.extractfile(member)
                assert content is not None
                (folder / name / Path(member.name).name).write_bytes(content.read())


def _is_new(number: int, development: bool) -> bool:
    return (number <= DEVELOPED["problems"]) == development


def _goal(request: Path, situation: Any) -> tuple[float, ...]:
    node = yaml_node(str(request), request.read_text("utf-8"))
    return goal_of(node, situation.arm.model, "panda")


def scenes(files: Sequence[Path], starts: int = STARTS) -> Iterator[Question]:
    """Yield situations of SI-RRT's scenes, from their begin and from later frames."""
    for situation, node in zip(
        SiRrt().convert(list(files)).situations, json_nodes(files, r".+\.json"), strict=True
    ):
        ends = node.at("end_configuration").numbers(len(situation.arm.joints))
        order = [row.text() for row in node.at("robot_joints_order").rows()]
        goal = tuple(ends[order.index(joint.name)] for joint in situation.arm.model.joints)
        for k in range(starts):
            begun = later(situation, k * situation.horizon / starts)
            blocked = is_blocked(begun), goal_is_blocked(begun, goal)
            name = f"{situation.name} from {k}/{starts}"
            yield Question(BOXES, situation.name, name, begun, goal, *blocked)


def balls(
    file: Path, seed: int, count: int = BALLS, development: bool = False
) -> Iterator[Question]:
    """Yield balls that a Panda at the end of the table may reach."""
    (node,) = json_nodes([file], r".+")
    rows, first = node.value, DEVELOPED["balls"]
    numbers = range(first) if development else range(first, len(rows))
    drawn = sorted(seeding.rng(seed, 1000).choice(numbers, count, replace=False).tolist())
    with tempfile.TemporaryDirectory() as place:
        part = Path(place) / "balls.json"
        part.write_text(json.dumps([rows[k] for k in drawn]), "utf-8")
        for situation in TableTennis().convert([part]).situations:
            blocked = is_blocked(situation)
            yield Question(TENNIS, file.stem, situation.name, situation, None, blocked, False)
