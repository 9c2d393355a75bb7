"""Joints of a robot that move with a chain: its own, those that follow them, and their order."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from gcm_learn.arms.followers import Follows
from gcm_learn.arms.robots.tree import Robot, RobotJoint, motion
from gcm_learn.errors import RobotError

MOVING = ("revolute", "continuous", "prismatic")
SAME = 1e-9  # difference of values of a leader that are one


class Lead(NamedTuple):
    """Value of a joint by that of its leader: factor q + offset."""

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
    frames: dict[str, tuple[int, np.ndarray]]
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
    """Return the joints on a way and all that move with them; all others stand still.

    A leader comes before its followers; where that cannot be, the first of them leads.

    Parameters
    ----------
    robot : Robot
    base : str
        Link at the way's begin.
    way : sequence of RobotJoint
    at : dict of str to float
        Values of joints that stand still.
    """
    leads = leads_of(robot)
    on_way = {joint.name: k for k, joint in enumerate(way)}
    leaders = {leads[j.name].leader for j in way if j.type in MOVING and leads[j.name].factor}
    moved = {
        joint.name
        for joint in robot.joints
        if joint.type in MOVING and leads[joint.name].factor and leads[joint.name].leader in leaders
    }
    values = _standing(robot, leads, moved, on_way, at)
    made, first = Arrangement([], {base: (0, np.eye(4))}), dict[str, tuple[int, Lead]]()
    waiting = _spread(robot, base, moved, values, made.frames)
    while waiting:
        waiting.sort(key=lambda joint: on_way.get(joint.name, len(way)))
        ready = [j for j in waiting if leads[j.name].leader in {*first, j.name}]
        joint = (ready or waiting)[0]
        lead, number = leads[joint.name], len(made.placed) + 1
        number_of_first, known = first.setdefault(lead.leader, (number, lead))
        follows = None
        if number_of_first != number:
            factor = lead.factor / known.factor
            follows = Follows(number_of_first, factor, lead.offset - factor * known.offset)
        reached = _place(joint, follows, made)
        waiting += _spread(robot, reached, moved, values, made.frames)
        waiting = [j for j in waiting if not {j.parent, j.child} <= made.frames.keys()]
    _check_ties(robot, made, moved)
    return made


def _place(joint: RobotJoint, follows: Follows | None, made: Arrangement) -> str:
    """Append a joint; return the link that it moves, which may be its parent."""
    number, frames = len(made.placed) + 1, made.frames
    if joint.parent in frames:
        frame, pose = frames[joint.parent]
        frames[joint.child] = number, np.eye(4)
        made.placed.append(Placed(joint, frame, pose @ joint.origin, joint.axis, follows))
        return joint.child
    frame, pose = frames[joint.child]
    frames[joint.parent] = number, np.linalg.inv(joint.origin)
    back = tuple(-part for part in joint.axis)
    made.placed.append(Placed(joint, frame, pose, back, follows))
    return joint.parent


def _spread(
    robot: Robot,
    link: str,
    moved: set[str],
    values: Mapping[str, float],
    frames: dict[str, tuple[int, np.ndarray]],
) -> list[RobotJoint]:
    """Put what stands still behind a link on its frame; return the joints that move next."""
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
            step = step if there == joint.child else np.linalg.inv(step)
            frames[there] = number, pose @ step
            reached.append(there)
    return found


def _standing(
    robot: Robot,
    leads: Mapping[str, Lead],
    moved: set[str],
    on_way: Mapping[str, int],
    at: Mapping[str, float],
) -> dict[str, float]:
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
        given = (value - offset) / factor if factor else offset
        agrees = abs(led.get(leader, given) - given) <= SAME if factor else value == offset
        if not agrees:
            raise RobotError(f"at: joint {name!r} follows {leader!r}, which stands elsewhere")
        if factor:
            led[leader] = given
    for name, joint in known.items():
        if name == leads[name].leader and name not in led:
            followers = [j for j in robot.joints if leads[j.name].leader == name]
            low, high = joint.range or (-np.inf, np.inf)
            low, high = _common(followers, leads, (low, high)) or (low, high)
            led[name] = min(max(0.0, low), high)
    values = {n: lead.factor * led[lead.leader] + lead.offset for n, lead in leads.items()}
    for name, joint in known.items():
        low, high = joint.range or (-np.inf, np.inf)
        chosen = any(leads[given].leader == leads[name].leader for given in at)
        if chosen and not low - SAME <= values[name] <= high + SAME:
            raise RobotError(
                f"at: joint {name!r} stands from {low:g} to {high:g} (got {values[name]:g})"
            )
    return values


def _common(
    followers: Sequence[RobotJoint], leads: Mapping[str, Lead], ends: tuple[float, float]
) -> tuple[float, float] | None:
    """Return the range of a leader in which all followers are in theirs, if there is one."""
    low, high = ends
    for joint in followers:
        _, factor, offset = leads[joint.name]
        if joint.range is not None and factor:
            first, last = sorted((end - offset) / factor for end in joint.range)
            low, high = max(low, first), min(high, last)
    return (low, high) if low <= high else None


def _check_ties(robot: Robot, made: Arrangement, moved: set[str]) -> None:
    """Refuse bonds of parts that move with the chain."""
    for tie in robot.ties:
        numbers = {made.frames[link][0] for link in tie.links if link in made.frames}
        if len(numbers) > 1 or not moved.isdisjoint(tie.joints):
            raise RobotError(tie.reason)
