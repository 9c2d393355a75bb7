"""Arms that move in their joints: chains, and spatial arms as the chains that they are."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from gcm_learn.referee.chain import ZERO, ChainMotion, Geometry, tree_of
from gcm_learn.referee.contact import Motion
from gcm_learn.referee.curves import Curve, curve_of
from gcm_learn.referee.limits import Limits, hand_complaints, joint_complaints
from gcm_learn.referee.motions import Body
from gcm_learn.referee.rotations import Array, rotations, unit
from gcm_learn.referee.situations import check_model
from gcm_learn.referee.tolerances import AT_LIMIT, TOLERANCES, Complaint, Tolerances, Unreadable

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
    grasp: float
    ignored: set[tuple[int, str]]
    signed = True

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

    def resting(self) -> Motion:
        """Return the links at t = 0."""
        curve = curve_of(np.zeros(1), self.posture[None])
        return ChainMotion(self.geometry, curve, self.size)

    def complaints(self, columns: Columns) -> list[Complaint]:
        """Return complaints about start, places and limits."""
        curve, granted = _curve(columns), self.granted
        complaints = [*self._start(columns), *self._places(columns)]
        complaints += joint_complaints(self.limits, self.geometry.followed(curve), granted)
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

    def missed(self, columns: Columns, body: Body, time: float) -> list[str]:
        """Return complaints about a catch of a body at a time."""
        joint, point = self.points["hand"]
        joints = _curve(columns).joints(np.array([time]))
        hand = self.geometry.point(joints, joint, point)
        away, granted = float(body.gaps(time, hand)[0]), self.granted
        slack = granted.grasp * max(self.size, float(np.abs(hand).max()))
        if granted.grasp_absolute:
            slack = granted.grasp_absolute * max(1.0, self.grasp)
        words = []
        if not away <= self.grasp + slack:
            words.append(f"misses {body.name}: {away:.9g} away, grasp {self.grasp:g}")
        if body.approach is not None:
            axis = self.geometry.direction(joints, joint, self.axis)[0]
            words += self._approached(body, body.poses(np.array([time]))[1][0], axis)
        return words

    def _approached(self, body: Body, turn: Array, axis: Array) -> list[str]:
        assert body.approach is not None
        wanted, within = turn @ unit(body.approach["axis"]), float(body.approach["within"])
        angle = float(np.arctan2(np.linalg.norm(np.cross(wanted, axis)), wanted @ axis))
        if angle <= within + self.granted.grasp_absolute * max(1.0, within):
            return []
        return [f"approaches {body.name} at an angle of {angle:.9g}, allowed {within:g}"]


def _curve(columns: Columns) -> Curve:
    return curve_of(columns["time"], columns["joints"], columns.get("rates"))


# --- reading ---------------------------------------------------------------------------------


def read_chain(arm: Mapping[str, Any], models: Models) -> JointArm:
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
    leaders = [joint for joint in model["joints"] if "follows" not in joint]
    own = [joint.get("max_acceleration") for joint in leaders]
    acceleration = arm.get("max_acceleration", None if own[0] is None else own)
    return _arm(
        3, model, arm.get("base"), arm["posture"], arm.get("rates"), acceleration,
        arm.get("max_hand_speed"), arm["grasp"], _ignored(arm.get("ignore") or (), model["links"]),
        {"hand": (model["hand"]["joint"], model["hand"]["point"])},
    )  # fmt: skip


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
    return _arm(
        version, {"joints": joints, "links": links, "hand": hand}, arm.get("base"), arm["joints"],
        arm.get("joint_rates"), arm.get("max_joint_acceleration"), arm.get("max_hand_speed"),
        arm["grasp"], (), {"hand": (4, fore), **elbow},
    )  # fmt: skip


def _arm(
    version: int,
    model: Mapping[str, Any],
    base: Mapping[str, Any] | None,
    posture: Any,
    rates: Any,
    acceleration: Any,
    hand_speed: float | None,
    grasp: float,
    ignored: Iterable[tuple[int, str]],
    points: Mapping[str, tuple[int, Any]],
) -> JointArm:
    joints = model["joints"]
    first = _started(posture, [joint["range"] for joint in joints if "follows" not in joint])
    low, high = np.array([joint["range"] for joint in joints], dtype=float).T
    limits = Limits(
        low,
        high,
        speed=np.array([joint["max_speed"] for joint in joints], dtype=float),
        acceleration=None if acceleration is None else _accelerations(joints, acceleration),
        hand_speed=hand_speed,
    )
    return JointArm(
        granted=TOLERANCES[version],
        geometry=_geometry(model, base or {}),
        limits=limits,
        points={name: (k, np.array(place, float)) for name, (k, place) in points.items()},
        axis=unit(model["hand"].get("axis", (0.0, 0.0, 1.0))),
        posture=first,
        rates=np.zeros(len(first)) if rates is None else np.array(rates, dtype=float),
        grasp=grasp,
        ignored=set(ignored),
    )


def _started(posture: Any, ranges: Any) -> Array:
    """Return the coordinates (n,) at t = 0; those that are nearly in their ranges are the bound."""
    given = np.array(posture, dtype=float)
    bound = np.clip(given, *np.array(ranges, dtype=float).T)
    near = np.abs(given - bound) <= AT_LIMIT * np.maximum(1.0, np.abs(bound))
    return np.where(near, bound, given)


def _accelerations(joints: Any, given: Any) -> Array:
    """Return the limits (m,) of all joints by the limits (n,) of the coordinates."""
    left = iter(given)
    limits = [
        joint.get("max_acceleration", UNLIMITED) if "follows" in joint else next(left)
        for joint in joints
    ]
    return np.array(limits, dtype=float)


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
