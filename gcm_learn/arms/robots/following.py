"""Joints that move with a robot's chain: the chain's own, their followers, and their order."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from gcm_learn.arms.followers import Follows
from gcm_learn.arms.robots.tree import Robot, RobotJoint, motion
from gcm_learn.errors import RobotError

MOVING = ("revolute", "continuous", "prismatic")
Frames = dict[str, tuple[int, np.ndarray]]
SAME = 1e-9  # difference of values of a leader that are one


class Lead(NamedTuple):
    """Rule for a joint's value: factor q + offset at the leader's value q."""

    leader: str
    """Joint that follows no other; the joint itself if it does not."""
    factor: float = 1.0
    offset: float = 0.0


class Placed(NamedTuple):
    """A joint of the chain or of a branch that moves with it."""

    joint: RobotJoint
    parent: int
    """Number of the frame on which it stands."""
    pose: np.ndarray
    """(4, 4) Of the joint in that frame."""
    axis: tuple[float, ...]
    follows: Follows | None


class Arrangement(NamedTuple):
    """Joints in the order of an arm file, and the links on their frames."""

    placed: list[Placed]
    frames: Frames
    """Number of the frame that carries each link, and the link's pose in it."""


def leads_of(robot: Robot) -> dict[str, Lead]:
    """Return the leader of each joint, with followers of followers resolved."""
    known = {joint.name: joint for joint in robot.joints}

    def lead(name: str, behind: tuple[str, ...]) -> Lead:
        if name in behind:
            raise RobotError(f"joint {name!r}: follows itself")
        if known[name].follows is None or known[name].type not in MOVING:
            return Lead(name)
        leader, factor, offset = known[name].follows or ("", 0.0, 0.0)
        if factor == 0.0 or known[leader].type not in MOVING:
            return Lead(name, 0.0, offset)
        first = lead(leader, (*behind, name))
        return Lead(first.leader, factor * first.factor, factor * first.offset + offset)

    return {name: lead(name, ()) for name in known}


def arranged(
    robot: Robot, base: str, way: Sequence[RobotJoint], at: Mapping[str, float]
) -> Arrangement:
    """Return the joints on a way from a base and all that move with them; all others stand still.

    A leader comes before its followers; where that cannot be, the first of them leads.
    """
    leads, on_way = leads_of(robot), {joint.name: k for k, joint in enumerate(way)}
    move = {j.name for j in robot.joints if j.type in MOVING and leads[j.name].factor}
    leaders = {leads[name].leader for name in move.intersection(on_way)}
    moved = {name for name in move if leads[name].leader in leaders}
    values = _standing(robot, leads, moved, on_way, at)
    made, first = Arrangement([], {base: (0, np.eye(4))}), dict[str, tuple[int, Lead]]()
    waiting = _spread(robot, base, moved, values, made.frames)
    while waiting:
        waiting.sort(key=lambda joint: on_way.get(joint.name, len(way)))
        ready = [j for j in waiting if leads[j.name].leader in {*first, j.name}]
        joint = (ready or waiting)[0]
        lead, number = leads[joint.name], len(made.placed) + 1
        leader, known = first.setdefault(lead.leader, (number, lead))
        factor = lead.factor / known.factor
        follows = Follows(leader, factor, lead.offset - factor * known.offset)
        reached = _place(joint, None if leader == number else follows, made)
        waiting += _spread(robot, reached, moved, values, made.frames)
        waiting = [j for j in waiting if not {j.parent, j.child} <= made.frames.keys()]
    for tie in robot.ties:
        numbers = {made.frames[link][0] for link in tie.links if link in made.frames}
        if len(numbers) > 1 or not moved.isdisjoint(tie.joints):
            raise RobotError(tie.reason)
    return made


def _place(joint: RobotJoint, follows: Follows | None, made: Arrangement) -> str:
    """Append a joint; return the link that it moves: its child, or else its parent if farther."""
    ahead = joint.parent in made.frames
    known, moved = (joint.parent, joint.child) if ahead else (joint.child, joint.parent)
    frame, pose = made.frames[known]
    axis = joint.axis if ahead else tuple(-part for part in joint.axis)
    made.frames[moved] = len(made.placed) + 1, np.eye(4) if ahead else np.linalg.inv(joint.origin)
    made.placed.append(Placed(joint, frame, pose @ joint.origin if ahead else pose, axis, follows))
    return moved


def _spread(
    robot: Robot, link: str, moved: set[str], values: Mapping[str, float], frames: Frames
) -> list[RobotJoint]:
    """Give the links fixed to `link` its frame; return the moving joints that come next."""
    found, reached = [], [link]
    while reached:
        here = reached.pop()
        number, pose = frames[here]
        for joint in robot.joints:
            there = joint.child if joint.parent == here else joint.parent
            if here not in (joint.parent, joint.child) or there in frames:
                continue
            if joint.name in moved:
                found.append(joint)
                continue
            kind = joint.type if joint.type in MOVING else "fixed"
            step = joint.origin @ motion(kind, joint.axis, values[joint.name])
            frames[there] = number, pose @ (step if there == joint.child else np.linalg.inv(step))
            reached.append(there)
    return found


def _standing(
    robot: Robot, leads: Mapping[str, Lead], moved: set[str], on_way: Collection[str],
    at: Mapping[str, float],
) -> dict[str, float]:  # fmt: skip
    """Return the values at which joints stand that do not move."""
    known = {joint.name: joint for joint in robot.joints}
    led: dict[str, float] = {}
    for name, value in at.items():
        if name not in known or known[name].type not in MOVING:
            raise RobotError(f"at: there is no joint {name!r} that moves")
        leader, factor, offset = leads[name]
        if name in moved:
            what = "is one of the chain's" if name in on_way else "moves with the chain"
            raise RobotError(f"at: joint {name!r} {what}")
        given = (value - offset) / factor if factor else led.get(leader, 0.0)
        if abs(led.get(leader, given) - given) > SAME or (not factor and value != offset):
            raise RobotError(f"at: joint {name!r} follows {leader!r}, which stands elsewhere")
        if factor:
            led[leader] = given
    chosen = {leads[name].leader for name in at}
    for name in known.keys() - led.keys():
        alike = [(j.range, leads[j.name]) for j in robot.joints if leads[j.name].leader == name]
        ends = [
            sorted((end - lead.offset) / lead.factor for end in bounds)
            for bounds, lead in alike if bounds is not None and lead.factor
        ]  # fmt: skip
        low, high = max((e[0] for e in ends), default=0.0), min((e[1] for e in ends), default=0.0)
        if low > high:  # its followers cannot all stand in their ranges
            low, high = known[name].range or (0.0, 0.0)
        led[name] = min(max(0.0, low), high)
    values = {n: lead.factor * led[lead.leader] + lead.offset for n, lead in leads.items()}
    for name, joint in known.items():
        low, high = joint.range or (-np.inf, np.inf)
        if leads[name].leader in chosen and not low - SAME <= values[name] <= high + SAME:
            raise RobotError(
                f"at: joint {name!r} stands from {low:g} to {high:g} (got {values[name]:g})"
            )
    return values
