"""The table of arms with mass: their rigid segments, units and touches, by kind of arm."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from gcm_learn import arms
from gcm_learn.situation import AnyArmBody, ArmBody, ChainBody, FrameMass, shipped_arm

HAND = 0.5
"""Radius of the hand's ball, as a share of the grasp; a link's radius at most."""
EQUAL = 1e-6
"""Tolerance of joints that are the same, in their origins, rotations and axes."""


class Inertia(NamedTuple):
    """Mass of a segment."""

    mass: float
    """[kg]"""
    centre: tuple[float, ...]
    """(3,) [m]"""
    turn: tuple[float, ...]
    """Principal axes in the segment's frame: a quaternion w, x, y, z."""
    moments: tuple[float, ...]
    """(3,) Principal moments [kg m^2]."""


class Turning(NamedTuple):
    """Joint before a segment."""

    type: str
    axis: tuple[float, ...]


class LinkCapsule(NamedTuple):
    """Link of a segment; in the arm's unit."""

    number: int
    """Index in the arm's own order."""
    start: tuple[float, ...]
    end: tuple[float, ...]
    radius: float


class Segment(NamedTuple):
    """Rigid part of an arm, attached to an earlier segment; in the arm's unit."""

    name: str
    parent: int
    """Index of the segment from which it hangs; -1 for the base."""
    place: tuple[float, ...]
    """(3,) In the frame of the parent."""
    turn: tuple[float, ...]
    """Quaternion w, x, y, z."""
    inertia: Inertia | None
    """None for a segment at rest."""
    joints: tuple[Turning, ...]
    links: tuple[LinkCapsule, ...]


@dataclass(frozen=True)
class Mechanics:
    """Functions of an arm that physics needs."""

    rested: Callable[[Any], Any]
    """Return an arm in the frame of its base, at rest at the low ends of its ranges."""
    segments: Callable[[Any, Any], list[Segment]]
    """Return the base and all segments: (arm, body)."""
    hand: Callable[[Any], tuple[int, tuple[float, ...], float]]
    """Return the segment that carries the hand, its place there and the radius of its ball."""
    metric: Callable[[Any, float], np.ndarray]
    """Return metres or radians per unit of each coordinate (n,): (arm, metres)."""
    lines: Callable[[Any, float], tuple[np.ndarray, np.ndarray]]
    """Return factors (m, n) and offsets (m,) of all joints by the coordinates: (arm, metres)."""
    leads: Callable[[Any], tuple[bool, ...]]
    """Return which of the joints (m,) have a coordinate, and so a motor."""
    pairs: Callable[[Any], tuple[tuple[int, int], ...]]
    """Return pairs of links that must not overlap."""
    ignored: Callable[[Any], tuple[tuple[int, str], ...]]
    """Return pairs of a link and the name of an obstacle that do not touch."""
    format: str
    """Format of the bodies."""
    stranger: Callable[[Any, str], str]
    """Say why an arm is not the shipped one that has a body of a name; empty if it may be."""
    points: Callable[[Any, np.ndarray], np.ndarray]
    """Return points (k, p, 3) at postures (k, n) that bound how far the limb strays; hand last."""


def _rested(arm: Any) -> Any:
    start: Any = tuple(low for low, _ in arm.joint_range)
    return replace(
        arm,
        base=arms.Base(),
        joints=start,
        joint_rates=None,
        max_joint_acceleration=None,
        max_joint_jerk=None,
        joint_accelerations=None,
    )


def _bones(arm: arms.SpatialArm, body: ArmBody) -> list[Segment]:
    unturned, nowhere = (1.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
    made, place = [Segment("base", -1, nowhere, unturned, None, (), ())], nowhere
    for i, (name, end) in enumerate((("upper_arm", arm.upper_arm), ("forearm", arm.forearm))):
        bone = body.bones[i]
        inertia = Inertia(bone.mass, bone.centre, unturned, bone.inertia)
        joints = tuple(Turning("revolute", axis) for axis in arms.AXES[2 * i : 2 * i + 2])
        link = LinkCapsule(i, nowhere, end, arm.thickness)
        made.append(Segment(name, i, place, unturned, inertia, joints, (link,)))
        place = end
    return made


def _frames(arm: arms.Chain, body: ChainBody) -> list[Segment]:
    links = [
        (link.joint, LinkCapsule(i, link.start, link.end, link.radius))
        for i, link in enumerate(arm.model.links)
    ]
    count = len(arm.model.joints)
    carried = [tuple(link for k, link in links if k == at) for at in range(count + 1)]
    base = Segment("base", -1, (0.0, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0), None, (), carried[0])
    return [base] + [
        Segment(
            f"frame{k}", arm.model.parent(k - 1), joint.origin, joint.rotation,
            _principal(body.frames[k]), (Turning(joint.type, joint.axis),), carried[k],
        )
        for k, joint in enumerate(arm.model.joints, 1)
    ]  # fmt: skip


def _principal(carried: FrameMass) -> Inertia:
    """Return a mass in its principal axes, with moments that rounding cannot make unphysical."""
    moments, axes = np.linalg.eigh(np.array(carried.inertia))
    moments = np.maximum(moments, 0.0)
    moments[2] = min(moments[2], moments[0] + moments[1])
    axes[:, 2] *= np.sign(np.linalg.det(axes))
    turn = tuple(np.asarray(arms.quaternion_of(axes)).tolist())
    return Inertia(carried.mass, carried.centre, turn, tuple(moments.tolist()))


def _hand_of_chain(arm: arms.Chain) -> tuple[int, tuple[float, ...], float]:
    hand = arm.model.hand
    radii = [link.radius for link in arm.model.links]
    return hand.joint, hand.point, min(HAND * arm.grasp, *radii)


def _metric_of_chain(arm: arms.Chain, metres: float) -> np.ndarray:
    return _metric(arm.model.coordinates, metres)


def _metric(joints: Sequence[arms.ChainJoint], metres: float) -> np.ndarray:
    return np.array([metres if joint.type == "prismatic" else 1.0 for joint in joints])


def _lines_of_chain(arm: arms.Chain, metres: float) -> tuple[np.ndarray, np.ndarray]:
    every, offsets = _metric(arm.model.joints, metres), [line.offset for line in arm.model.lines]
    return arm.model.factors * every[:, None] / _metric_of_chain(arm, metres), every * offsets


def _ends_and_hand(arm: arms.Chain, joints: np.ndarray) -> np.ndarray:
    """Return link ends and hand (k, p, 3); a capsule strays no farther than its farther end."""
    ends, _ = arms.links_along(arm, joints)
    hand, _ = arms.hands_along(arm, joints)
    return np.concatenate([ends.reshape(len(joints), -1, 3), hand[:, None]], axis=1)


def _other_joints(arm: arms.Chain, name: str) -> str:
    same = same_joints(arm.model, shipped_arm(name))
    return "" if same else "joints: differ from the shipped arm's"


def same_joints(one: arms.ChainModel, other: arms.ChainModel) -> bool:
    """Return whether joints of two models move their frames alike, whatever their limits."""
    numbers = [
        np.array([[*joint.origin, *arms.rotation_of(joint.rotation).ravel(), *joint.axis]
                  for joint in model.joints])
        for model in (one, other)
    ]  # fmt: skip
    types = [
        [(joint.type, model.parent(k), model.lines[k]) for k, joint in enumerate(model.joints)]
        for model in (one, other)
    ]
    return types[0] == types[1] and bool(np.abs(numbers[0] - numbers[1]).max() <= EQUAL)


_CHAIN = Mechanics(
    rested=_rested,
    segments=_frames,
    hand=_hand_of_chain,
    metric=_metric_of_chain,
    lines=_lines_of_chain,
    leads=lambda arm: tuple(line.leads for line in arm.model.lines),
    pairs=lambda arm: arm.model.self_collision,
    ignored=lambda arm: arm.ignored,
    format=ChainBody.format,
    stranger=_other_joints,
    points=_ends_and_hand,
)
MECHANICS = arms.ByKind(
    {
        arms.CHAIN: _CHAIN,
        arms.SPATIAL: replace(
            _CHAIN,
            segments=_bones,
            hand=lambda arm: (2, *_hand_of_chain(arm)[1:]),
            format=ArmBody.format,
            stranger=lambda arm, name: "",
        ),
    },
    who="physics",
)
"""By kind of arm."""


def misfit(arm: Any, body: AnyArmBody) -> str:
    """Say in a sentence why a body does not fit an arm; empty if it fits."""
    wanted = MECHANICS.of(arm).format
    if body.format != wanted:
        return f"is of format {body.format}, and {arms.kind_of(arm).plural} need {wanted}"
    fitting: Any = body
    return str(fitting.misfit(arm))


def strongest(arm: Any, body: AnyArmBody) -> np.ndarray:
    """Return the largest torque of the motor of each coordinate (n,) [N m]."""
    both = zip(body.joints, MECHANICS.of(arm).leads(arm), strict=True)
    return np.array([motor.torque for motor, leads in both if leads])


def rested(arm: Any, body: AnyArmBody) -> tuple[Any, Any]:
    """Return arm and body in the frame of the base: at rest, gravity turned."""
    pull: Any = arms.rotation_of(arm.base.rotation).T @ np.array(body.gravity)
    still = MECHANICS.of(arm).rested(arm)
    return still, replace(body, gravity=tuple(pull.round(12).tolist()))
