"""Arms that move in their joints: chains, and spatial arms as the chains that they are."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from gcm_learn.referee.arm_files import check_model
from gcm_learn.referee.carrying import Carry
from gcm_learn.referee.catching import Catch
from gcm_learn.referee.chain import ZERO, ChainMotion, Geometry, tree_of
from gcm_learn.referee.contact import Motion, Watched
from gcm_learn.referee.curves import Curve, curve_of
from gcm_learn.referee.holding import Grip
from gcm_learn.referee.limits import (
    Limits,
    hand_complaints,
    jerk_complaints,
    joint_complaints,
)
from gcm_learn.referee.motions import Body
from gcm_learn.referee.rotations import Array, angle_of, rotations, unit
from gcm_learn.referee.situations import UNIT
from gcm_learn.referee.tolerances import (
    AT_LIMIT,
    RESTING,
    TOLERANCES,
    Complaint,
    Tolerances,
    Unreadable,
)

SHIPPED = Path(__file__).parents[1] / "arms" / "models"


@cache
def shipped_model(name: str) -> dict[str, Any]:
    """Return the object of a shipped arm file."""
    known = {path.stem: path for path in SHIPPED.glob("*.json")}
    if name not in known:
        raise Unreadable(f'arm.model: "{name}" is not a known arm')
    return json.loads(known[name].read_text("utf-8"))


Columns = Mapping[str, Array]
Models = Mapping[str, Mapping[str, Any]]
UNTURNED = (1.0, 0.0, 0.0, 0.0)
UNLIMITED = 1e50


@dataclass(frozen=True)
class JointArm:
    """A chain in a situation."""

    granted: Tolerances
    geometry: Geometry
    limits: Limits
    points: Mapping[str, tuple[int, Array]]
    """Columns of places: the joint that carries the point, and the point in its frame."""
    axis: Array
    """Direction (3,) along which the hand reaches, in the frame of its joint."""
    posture: Array
    rates: Array
    accelerations: Array
    """Of the coordinates (n,) at t = 0."""
    grasp: float
    ignored: set[tuple[int, str]]
    ends_at_rest: bool = False

    @property
    def size(self) -> float:
        """Length of the arm, with which errors of distances are compared."""
        _, point = self.points["hand"]
        return float(self.geometry.lengths.sum() + np.linalg.norm(point))

    @property
    def columns(self) -> dict[str, int]:
        """Width of each column of a trajectory."""
        n = len(self.posture)
        rates = {} if self.limits.acceleration is None else {"rates": n}
        return {"joints": n, **rates, **dict.fromkeys(self.points, 3)}

    def readings(self, columns: Columns) -> list[Motion]:
        """Return the movement of the links."""
        return [ChainMotion(self.geometry, _curve(columns), self.size)]

    def carried(self, columns: Columns, body: Body, catch: Catch) -> list[Watched]:
        """Return the movement of a carried target, in parts with the obstacles ignored in each."""
        if catch.placed is None:
            return []
        joint = self.points["hand"][0]
        return Carry(self.geometry, _curve(columns), joint, body, catch).watched(self.size)

    def resting(self) -> Motion:
        """Return the links at t = 0."""
        curve = curve_of(np.zeros(1), self.posture[None])
        return ChainMotion(self.geometry, curve, self.size)

    def complaints(self, columns: Columns) -> list[Complaint]:
        """Return complaints about start, places and limits."""
        curve, granted = _curve(columns), self.granted
        complaints = [*self._start(columns), *self._places(columns)]
        followed = self.geometry.followed(curve)
        complaints += joint_complaints(self.limits, followed, granted)
        complaints += jerk_complaints(self.limits, curve, followed, self.accelerations)
        if self.ends_at_rest:
            complaints += self._restless(columns, columns["time"][-1])
        hand = self.points["hand"]
        limit = self.limits.hand_speed
        return complaints + hand_complaints(limit, self.geometry, curve, hand, granted.limit)

    def _start(self, columns: Columns) -> list[Complaint]:
        complaints = []
        for name, first in (("joints", self.posture), ("rates", self.rates)):
            if name in columns and not np.abs(columns[name][0] - first).max() <= self.granted.start:
                what = "does not start as the arm of the situation does"
                complaints.append(Complaint(f"trajectory.{name}", what, 0.0))
        return complaints

    def _places(self, columns: Columns) -> list[Complaint]:
        complaints = []
        for name, (joint, point) in self.points.items():
            found = self.geometry.point(columns["joints"], joint, point)
            apart = np.abs(found - columns[name]).max(axis=1)
            allowed = np.full(len(apart), self.granted.agreement)
            if self.granted.touch_absolute:
                allowed *= np.maximum(1.0, np.linalg.norm(found, axis=1))
            k = int((apart - allowed).argmax())
            if not apart[k] <= allowed[k]:
                what = f"is {apart[k]:g} off the place that follows from the joints"
                at = float(columns["time"][k])
                complaints.append(Complaint(f"trajectory.{name}", what, at))
        return complaints

    def missed(self, columns: Columns, body: Body, catch: Catch) -> list[Complaint]:
        """Return complaints about a catch of a body, its hold and its placing."""
        granted, curve = self.granted, _curve(columns)
        reach = self.size + float(np.linalg.norm(self.geometry.base[0]))
        slack = granted.grasp_absolute * max(1.0, self.grasp) or granted.grasp * reach
        grip = Grip(self.geometry, curve, self.points["hand"], self.axis, body)
        last = catch.time if catch.held_until is None else catch.held_until
        complaints = grip.complaints(self.grasp, slack, granted.grasp_absolute, catch.time, last)
        if catch.placed is None:
            return complaints
        carry = Carry(self.geometry, curve, self.points["hand"][0], body, catch)
        return [*complaints, *carry.misplaced(), *self._restless(columns, catch.placed)]

    def _restless(self, columns: Columns, time: float) -> list[Complaint]:
        """Return complaints if the arm does not rest at a sample."""
        k, limits = int(np.searchsorted(columns["time"], time)), self.limits
        tests = [("moves", columns["rates"][k], RESTING[0] * limits.speed[limits.own])]
        if limits.jerk is not None and limits.acceleration is not None:
            curve, last = _curve(columns), np.array([k - 1])
            found = curve.accelerations(last, curve.spans[last])[0] if k else self.accelerations
            most = RESTING[1] * limits.acceleration[limits.own]
            tests.append(("accelerates", found, most))
        return [
            Complaint("trajectory.rates", f"coordinate {j} {word} where the arm should rest", time)
            for word, values, most in tests
            for j in np.flatnonzero(~(np.abs(values) <= most))
        ]


def _curve(columns: Columns) -> Curve:
    return curve_of(columns["time"], columns["joints"], columns.get("rates"))


# --- reading ---------------------------------------------------------------------------------


def read_chain(arm: Mapping[str, Any], models: Models, version: int = 3) -> JointArm:
    """Return the chain of a situation.

    Parameters
    ----------
    arm : mapping
        Field ``arm`` of a situation.
    models : mapping
        Objects of arm files, by what situations call them; others are those that ship.
    """
    model = arm["model"]
    if isinstance(model, str):
        model = models[model] if model in models else shipped_model(model)
    check_model(model, arm)
    points = {"hand": (model["hand"]["joint"], model["hand"]["point"])}
    return _arm(version, model, arm, points)


def _ignored(pairs: Any, links: Any) -> list[tuple[int, str]]:
    """Return the pairs that are not checked, with links by their indices."""
    found = []
    for k, (link, body) in enumerate(pairs):
        same = [i for i, known in enumerate(links) if link in (i, known.get("name"))]
        if not same:
            raise Unreadable(f"arm.ignore[{k}]: {str(link)[:60]} is not a link")
        found += [(i, body) for i in same]
    return found


def read_spatial(version: int, arm: Mapping[str, Any]) -> JointArm:
    """Return a spatial arm as a chain: R_y, R_z at the shoulder, R_x, R_z at the elbow."""
    upper, fore = list(arm["upper_arm"]), list(arm["forearm"])
    axes = ([0, 1, 0], [0, 0, 1], [1, 0, 0], [0, 0, 1])
    joints = [
        {"axis": axis, "range": ends, "max_speed": fast}
        for axis, ends, fast in zip(axes, arm["joint_range"], arm["max_joint_speed"], strict=True)
    ]
    joints[2]["origin"] = upper
    thick = arm.get("thickness", 0.0)
    bones = ((2, upper), (4, fore))
    links = [{"joint": k, "from": ZERO, "to": bone, "radius": thick} for k, bone in bones]
    hand = {"joint": 4, "point": fore, "axis": fore}
    elbow = {"elbow": (2, upper)} if version == 2 else {}
    named = {
        "posture": "joints", "rates": "joint_rates", "accelerations": "joint_accelerations",
        "max_acceleration": "max_joint_acceleration", "max_jerk": "max_joint_jerk",
    }  # fmt: skip
    chain = {**arm, **{mine: arm.get(its) for mine, its in named.items()}}
    model = {"joints": joints, "links": links, "hand": hand}
    return _arm(version, model, chain, {"hand": (4, fore), **elbow})


def asked(situation: Mapping[str, Any], arm: JointArm) -> JointArm:
    """Return the arm of a version 4 situation; refuse holds or an end that need limits it lacks."""
    rests, limited = situation.get("end") == "rest", arm.limits.acceleration is not None
    if rests and not limited:
        raise Unreadable("end: rest needs limits of acceleration")
    for k, body in enumerate(situation["bodies"]):
        if "hold" in body and not limited:
            raise Unreadable(f"bodies[{k}].hold: needs limits of acceleration")
        approach = body.get("approach")
        if isinstance(approach, list) and len(approach) == 2:
            hands, axes = (
                [unit(each.get(name, arm.axis)) for each in approach] for name in ("hand", "axis")
            )
            apart = abs(angle_of(*hands) - angle_of(*axes))
            if apart > sum(each["within"] for each in approach) + UNIT:  # axes are rounded
                raise Unreadable(f"bodies[{k}].approach: no hand can keep both")
    return replace(arm, ends_at_rest=rests)


def _arm(
    version: int,
    model: Mapping[str, Any],
    arm: Mapping[str, Any],
    points: Mapping[str, tuple[int, Any]],
) -> JointArm:
    joints = model["joints"]
    own = [k for k, joint in enumerate(joints) if "follows" not in joint]
    first = _started(arm["posture"], [joints[k]["range"] for k in own])
    rest = np.zeros(len(own))
    rates, accelerations = (
        rest if arm.get(name) is None else np.array(arm[name], dtype=float)
        for name in ("rates", "accelerations")
    )
    geometry, limits = _geometry(model, arm.get("base") or {}), _limits(version, joints, arm, own)
    if limits.acceleration is not None:
        beyond = np.abs(geometry.lines[0] @ accelerations) - limits.acceleration
        if not (beyond <= 1e-6 * limits.acceleration).all():
            raise Unreadable("arm.accelerations: are beyond their limits")
    return JointArm(
        granted=TOLERANCES[version],
        geometry=geometry,
        limits=limits,
        points={name: (k, np.array(place, float)) for name, (k, place) in points.items()},
        axis=unit(model["hand"].get("axis", (0.0, 0.0, 1.0))),
        posture=first,
        rates=rates,
        accelerations=accelerations,
        grasp=arm["grasp"],
        ignored=set(_ignored(arm.get("ignore") or (), model["links"])),
    )


def _limits(version: int, joints: Any, arm: Mapping[str, Any], own: list[int]) -> Limits:
    low, high = np.array([joint["range"] for joint in joints], dtype=float).T
    acceleration = _of_all("max_acceleration", joints, arm, own)
    limited = version > 3 and acceleration is not None
    jerk = _of_all("max_jerk", joints, arm, own) if limited else None
    if acceleration is None and arm.get("max_jerk") is not None:
        raise Unreadable("arm.max_jerk: needs limits of acceleration")
    if version > 3 and jerk is None and arm.get("accelerations") is not None:
        raise Unreadable("arm.accelerations: needs limits of jerk")
    return Limits(
        low,
        high,
        speed=np.array([joint["max_speed"] for joint in joints], dtype=float),
        acceleration=acceleration,
        hand_speed=arm.get("max_hand_speed"),
        jerk=jerk,
        own=own,
    )


def _started(posture: Any, ranges: Any) -> Array:
    """Return the coordinates (n,) at t = 0, moved to their range's end if barely outside."""
    given = np.array(posture, dtype=float)
    bound = np.clip(given, *np.array(ranges, dtype=float).T)
    near = np.abs(given - bound) <= AT_LIMIT * np.maximum(1.0, np.abs(bound))
    return np.where(near, bound, given)


def _of_all(name: str, joints: Any, arm: Mapping[str, Any], own: list[int]) -> Array | None:
    """Return the limits (m,) of all joints; a situation gives limits of coordinates only."""
    given = arm.get(name, [joints[k].get(name) for k in own])
    if given is None or given[0] is None:
        return None
    limits = np.array([joint.get(name, UNLIMITED) for joint in joints], dtype=float)
    limits[own] = given
    return limits


def _geometry(model: Mapping[str, Any], base: Mapping[str, Any]) -> Geometry:
    links = model["links"]
    place = np.array(base.get("origin", ZERO), dtype=float)
    return Geometry(
        (place, rotations(base.get("rotation", UNTURNED))),
        *tree_of(model["joints"]),
        carriers=np.array([link["joint"] for link in links]),
        axes=np.array([[link["from"], link["to"]] for link in links], dtype=float),
        radii=np.array([link["radius"] for link in links], dtype=float),
        pairs=np.array(model.get("self_collision") or np.zeros((0, 2)), dtype=int),
    )
