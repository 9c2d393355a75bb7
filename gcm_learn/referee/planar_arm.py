"""Planar arms: their hand moves straight, their joints follow, solids are cut by their plane."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from gcm_learn.referee import tolerances
from gcm_learn.referee.catching import Catch
from gcm_learn.referee.chain import ChainMotion, Geometry, tree_of
from gcm_learn.referee.contact import Motion, Watched
from gcm_learn.referee.curves import curve_of
from gcm_learn.referee.motions import Body
from gcm_learn.referee.rotations import Array
from gcm_learn.referee.shapes import golden_minimum

INSTANTS = 33
"""Of a piece, ends included, and again around the highest rates."""


class Elbowed(Protocol):
    """An arm of two segments in the plane."""

    @property
    def rho(self) -> float:
        """Length of the upper arm [forearms]."""
        ...

    def elbows(self, hand: Array) -> Array:
        """Return elbows (k, 2) of hands (k, 2)."""
        ...


def joint_rates(arm: Elbowed, time: Array, hand: Array) -> Array:
    """Return the highest rates (n - 1, 2) of both joints in each piece [rad/s]."""
    span = np.diff(time)
    moves = (span > 0.0) & (np.diff(hand, axis=0) != 0.0).any(axis=1)
    out = np.zeros((len(span), 2))
    s = np.broadcast_to(np.linspace(0.0, 1.0, INSTANTS), (len(span), INSTANTS))
    for _ in range(2):
        rates = _rates(arm, span, hand, s)
        out = np.maximum(out, rates.max(axis=1))
        top = rates.max(axis=2).argmax(axis=1)
        rows = np.arange(len(span))
        low, high = s[rows, np.maximum(top - 1, 0)], s[rows, np.minimum(top + 1, INSTANTS - 1)]
        s = np.linspace(low, high, INSTANTS, axis=1)
    out = np.maximum(out, _rates(arm, span, hand, nearest_shares(hand)).max(axis=1))
    return np.where(moves[:, None], out, 0.0)


def nearest_shares(hand: Array) -> Array:
    """Return shares (n - 1, 1) of the pieces at which they are nearest to the shoulder.

    Rates peak there, as narrowly as the hand passes near.
    """
    step = np.diff(hand, axis=0)
    length2 = (step**2).sum(axis=1)
    s = -(hand[:-1] * step).sum(axis=1) / np.where(length2 > 0.0, length2, 1.0)
    return np.clip(s, 0.0, 1.0)[:, None]


def _rates(arm: Elbowed, span: Array, hand: Array, s: Array) -> Array:
    """Return absolute rates (n - 1, m, 2) at shares s (n - 1, m) of the pieces.

    With f the forearm's direction, u the upper arm's, and n the quarter turn, the hand's velocity
    is rho w1 (n u) + (w1 + w2) (n f).
    """
    step = np.diff(hand, axis=0)
    velocity = (step / np.where(span > 0.0, span, 1.0)[:, None])[:, None]
    place = hand[:-1, None] + s[:, :, None] * step[:, None]
    elbow = arm.elbows(place.reshape(-1, 2)).reshape(place.shape)
    u, f = elbow / arm.rho, place - elbow
    across = u[..., 0] * f[..., 1] - u[..., 1] * f[..., 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        first = (velocity * f).sum(axis=2) / (arm.rho * across)
        second = -(velocity * place).sum(axis=2) / (arm.rho * across)
    return np.nan_to_num(np.abs(np.stack([first, second], axis=2)), nan=0.0)


CHORDS = 33
ROUNDS = 14
"""In each of them chords are taken 16 times as closely around the best."""


def deepest(
    body: Body, time: float, origin: Array, axes: Array, hand: Array, grasp: float
) -> float:
    """Return the least signed distance to a solid within `grasp` of the hand (2,), in the plane.

    It is at most 0 exactly if the cut comes within `grasp`.  Distances to convex solids are convex,
    and so is the minimum over a chord of the disc as a function of the chord.
    """
    low, high, best = -grasp, grasp, np.inf
    for _ in range(ROUNDS):
        x = np.linspace(low, high, CHORDS)
        half = np.sqrt(np.maximum(grasp**2 - x**2, 0.0))

        def depth(share: Array, x: Array = x, half: Array = half) -> Array:
            points = hand + np.stack([x, (2.0 * share - 1.0) * half], axis=1)
            return body.gaps(time, origin + points @ axes)

        least = golden_minimum(depth, CHORDS)
        k = int(least.argmin())
        best = min(best, float(least[k]))
        if best <= 0.0 or high - low < 1e-12:
            break
        low, high = x[max(k - 1, 0)], x[min(k + 1, CHORDS - 1)]
    return best


Columns = Mapping[str, Array]
NO_PAIRS = np.zeros((0, 2), dtype=int)


@dataclass(frozen=True)
class Plane:
    """Frame of the arm's plane in the world."""

    origin: Array
    axes: Array
    """Directions (2, 3) of x and y."""

    def lift(self, points: Array) -> Array:
        """Return points (..., 3) of the world, of points (..., 2) of the plane."""
        return self.origin + points @ self.axes


@dataclass(frozen=True)
class PlanarArm:
    """Two segments of lengths rho and 1, whose shoulder is the origin of their plane."""

    rho: float
    side: float
    """1 if the elbow lies on the right, looking from shoulder to hand; else -1."""
    first: Array
    """Hand (2,) at t = 0."""
    hand_speed: float
    joint_speed: Array | None
    thickness: float
    grasp: float
    plane: Plane
    solid: bool
    """True if the bodies are solids, which the plane cuts."""
    granted = tolerances.TOLERANCES[1]
    columns = {"hand": 2, "joints": 2}  # noqa: RUF012 -- a constant of the class
    ignored: frozenset[tuple[int, str]] = frozenset()

    @property
    def size(self) -> float:
        """Unit with which errors of distances are compared: the forearm."""
        return 1.0

    @property
    def radii(self) -> Array:
        """Radii (2,) of both segments."""
        return np.full(2, self.thickness)

    def elbows(self, hand: Array) -> Array:
        """Return elbows (k, 2) of hands (k, 2), by the law of cosines at the shoulder."""
        angle = np.arctan2(hand[:, 1], hand[:, 0]) - self.side * self.bend(
            np.linalg.norm(hand, axis=1)
        )
        return self.rho * np.stack([np.cos(angle), np.sin(angle)], axis=1)

    def bend(self, radius: Array) -> Array:
        """Return angles (k,) at the shoulder between upper arm and hand, by the hand's distance."""
        radius = np.maximum(radius, 1e-12)
        cosine = (radius**2 + self.rho**2 - 1.0) / (2.0 * radius * self.rho)
        return np.arccos(np.clip(cosine, -1.0, 1.0))

    def forward(self, joints: Array) -> tuple[Array, Array]:
        """Return elbows and hands (k, 2) of joints (k, 2)."""
        total = joints.sum(axis=1)
        elbow = self.rho * np.stack([np.cos(joints[:, 0]), np.sin(joints[:, 0])], axis=1)
        return elbow, elbow + np.stack([np.cos(total), np.sin(total)], axis=1)

    def readings(self, columns: Columns) -> list[Motion]:
        """Return the movement with a straight hand, and with straight joints if that may differ."""
        return [HandMotion(self, columns["time"], columns["hand"]), self.by_joints(columns)]

    def by_joints(self, columns: Columns) -> ChainMotion:
        """Return the movement with joints that are linear between samples, as that of a chain."""
        turn = np.column_stack([*self.plane.axes, np.cross(*self.plane.axes)])
        hinge = {"axis": [0.0, 0.0, 1.0], "range": [0.0, 0.0]}
        tree = tree_of([hinge, hinge | {"origin": [self.rho, 0.0, 0.0]}])
        axes = np.zeros((2, 2, 3))
        axes[:, 1, 0] = self.rho, 1.0
        base = (self.plane.origin, turn)
        geometry = Geometry(base, *tree, np.array([1, 2]), axes, self.radii)
        return ChainMotion(geometry, curve_of(columns["time"], columns["joints"]), 1.0)

    def resting(self) -> Motion:
        """Return the limb at t = 0."""
        return HandMotion(self, np.zeros(1), self.first[None])

    def complaints(self, columns: Columns) -> list[tolerances.Complaint]:
        """Return complaints about start, joints and speeds."""
        complaints = [*self._start(columns), *self._ring(columns), *self._joints(columns)]
        return complaints + self._speeds(columns)

    def _start(self, columns: Columns) -> list[tolerances.Complaint]:
        if np.abs(columns["hand"][0] - self.first).max() <= self.granted.start:
            return []
        return [tolerances.Complaint("trajectory.hand", "does not start on arm.hand", 0.0)]

    def _ring(self, columns: Columns) -> list[tolerances.Complaint]:
        hand, slack = columns["hand"], self.granted.touch
        far = np.linalg.norm(hand, axis=1)
        near = far if len(hand) == 1 else _nearest_to_shoulder(hand)
        beyond = far > self.rho + 1.0 + slack
        inside = near < abs(self.rho - 1.0) - slack
        return [
            tolerances.Complaint(
                "trajectory.hand", "is out of reach", float(columns["time"][wrong.argmax()])
            )
            for wrong in (beyond, inside)
            if wrong.any()
        ]

    def _joints(self, columns: Columns) -> list[tolerances.Complaint]:
        """Return complaints about joints that do not fit the hand."""
        joints, time = columns["joints"], columns["time"]
        off = np.abs(self.forward(joints)[1] - columns["hand"]).max(axis=1)
        leaps = np.abs(np.diff(joints, axis=0)).max(axis=1, initial=0.0)
        turned = -self.side * np.sin(joints[:, 1])
        tests = (
            (off, self.granted.agreement, "do not lead to the hand"),
            (leaps, tolerances.LEAP, "jump"),
            (turned, tolerances.SIDE, "have the elbow on the other side"),
        )
        complaints = [
            tolerances.Complaint("trajectory.joints", words, float(time[values.argmax()]))
            for values, most, words in tests
            if not values.max(initial=0.0) <= most
        ]
        if not complaints and not self._astray(columns) <= tolerances.INTERPOLATION:
            what = f"lead the hand {self._astray(columns):g} astray between samples"
            complaints.append(tolerances.Complaint("trajectory.joints", what))
        return complaints

    def _astray(self, columns: Columns) -> float:
        """Return the largest distance of hands by `hand` and by `joints` between samples."""
        s = np.linspace(0.0, 1.0, 9)[:, None, None]
        joints, hand = (
            ((1.0 - s) * columns[name][:-1] + s * columns[name][1:]).reshape(-1, 2)
            for name in ("joints", "hand")
        )
        return float(np.linalg.norm(self.forward(joints)[1] - hand, axis=1).max(initial=0.0))

    def _speeds(self, columns: Columns) -> list[tolerances.Complaint]:
        time, hand, granted = columns["time"], columns["hand"], 1.0 + self.granted.limit
        span = np.diff(time)
        step = np.linalg.norm(np.diff(hand, axis=0), axis=1)
        over = step - (self.hand_speed * granted * span + tolerances.ROUNDING * (1.0 + time[1:]))
        complaints = []
        if len(span) and not over.max() <= 0.0:
            what = f"is too fast, limit {self.hand_speed:g}"
            complaints.append(
                tolerances.Complaint("trajectory.hand", what, float(time[over.argmax()]))
            )
        if self.joint_speed is None or not len(span):
            return complaints
        turned = np.abs(np.diff(columns["joints"], axis=0)) - 1e-12
        for values in (turned, joint_rates(self, time, hand) * span[:, None]):
            beyond = values - self.joint_speed * granted * span[:, None]
            for j in np.flatnonzero(~(beyond <= 0.0).all(axis=0)):
                at = float(time[beyond[:, j].argmax()])
                what = f"joint {j} moves too fast, limit {self.joint_speed[j]:g}"
                complaints.append(tolerances.Complaint("trajectory.joints", what, at))
        return complaints

    def missed(self, columns: Columns, body: Body, catch: Catch) -> list[tolerances.Complaint]:
        """Return complaints about a catch of a body: the distance in the plane."""
        words = self._missed(columns, body, catch.time)
        return [tolerances.Complaint("catch_body", what, catch.time) for what in words]

    def carried(self, columns: Columns, body: Body, catch: Catch) -> list[Watched]:
        """Return nothing: planar arms do not carry."""
        return []

    def _missed(self, columns: Columns, body: Body, time: float) -> list[str]:
        hand = np.array([[np.interp(time, columns["time"], x) for x in columns["hand"].T]])
        if self.solid:
            # Granted in the plane: where it cuts a solid flatly, a depth says little of the way.
            reach = self.grasp + self.granted.grasp
            away = deepest(body, time, self.plane.origin, self.plane.axes, hand[0], reach)
            caught = away <= tolerances.EDGE
            return [] if caught else [f"misses {body.name}: no point of its cut is within grasp"]
        away = float(body.gaps(time, self.plane.lift(hand))[0]) - self.grasp
        caught = away <= self.granted.grasp
        return [] if caught else [f"misses {body.name} by {away:.9g}, grasp {self.grasp:g}"]


def _nearest_to_shoulder(hand: Array) -> Array:
    """Return the least distances (n - 1,) of straight pieces of a hand path to the shoulder."""
    return np.linalg.norm(hand[:-1] + nearest_shares(hand) * np.diff(hand, axis=0), axis=1)


class HandMotion:
    """Both segments of a planar arm whose hand moves straight between samples."""

    pairs = NO_PAIRS
    size = 1.0

    def __init__(self, arm: PlanarArm, time: Array, hand: Array) -> None:
        self.arm, self.time, self.hand = arm, time, hand
        self.radii = arm.radii

    def starts(self) -> Array:
        """Return the samples' times: between two of them the hand moves straight."""
        return self.time if len(self.time) > 1 else np.repeat(self.time, 2)

    def hands(self, times: Array) -> Array:
        """Return hands (k, 2) in the plane at times (k,)."""
        return np.stack([np.interp(times, self.time, x) for x in self.hand.T], axis=1)

    def ends(self, times: Array) -> Array:
        """Return both ends (k, 2, 2, 3) of the segments at times (k,)."""
        hand = self.hands(times)
        elbow = self.arm.elbows(hand)
        flat = np.stack([np.zeros_like(elbow), elbow, elbow, hand], axis=1)
        return self.arm.plane.lift(flat).reshape(-1, 2, 2, 3)

    def ways(self, low: Array, middle: Array, high: Array) -> Array:
        """Return bounds (k, 2) of the segments' ways from the middles of intervals (k,)."""
        first, at, last = (self.hands(t) for t in (low, middle, high))
        elbow = self._elbow_way(first, at, last)
        hand = np.maximum(np.linalg.norm(first - at, axis=1), np.linalg.norm(last - at, axis=1))
        return np.stack([elbow, np.maximum(elbow, hand)], axis=1)

    def _elbow_way(self, first: Array, at: Array, last: Array) -> Array:
        """Return bounds (k,) of the elbow's way while the hand moves straight from first to last.

        The direction of the hand is monotone on a straight line.  Its distance falls, then rises,
        and the bend at the shoulder has one extremum as a function of it.
        """
        arm = self.arm
        near = _nearest_to_shoulder(np.stack([first, last], axis=1).reshape(-1, 2))[::2]
        far = np.maximum(np.linalg.norm(first, axis=1), np.linalg.norm(last, axis=1))
        turned = np.stack([_angle(at, first), _angle(at, last)])
        peak = np.clip(np.sqrt(abs(arm.rho**2 - 1.0)) if arm.rho > 1.0 else 0.0, near, far)
        bends = np.stack([arm.bend(r) for r in (near, far, peak)])
        bends = arm.side * (bends - arm.bend(np.linalg.norm(at, axis=1)))
        highest = turned.max(axis=0) - bends.min(axis=0)
        lowest = turned.min(axis=0) - bends.max(axis=0)
        most = np.maximum(np.abs(highest), np.abs(lowest))
        return arm.rho * np.minimum(most, 2.0)

    def pair_ways(self, low: Array, middle: Array, high: Array) -> Array:
        """Return nothing (k, 0): the segments are not checked against each other."""
        return np.zeros((len(middle), 0))


def _angle(a: Array, b: Array) -> Array:
    """Return angles (k,) by which vectors b (k, 2) are turned from a."""
    cross = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
    return np.arctan2(cross, (a * b).sum(axis=1))


def read_planar(situation: Mapping[str, Any]) -> PlanarArm:
    """Return the planar arm of a situation."""
    arm, plane = situation["arm"], situation.get("plane")
    speed = arm.get("max_joint_speed")
    frame = plane or {"origin": [0.0] * 3, "x": [1.0, 0.0, 0.0], "y": [0.0, 1.0, 0.0]}
    axes = np.array([frame["x"], frame["y"]], dtype=float)
    return PlanarArm(
        rho=float(arm.get("upper_arm", 1.0)),
        side={"right": 1.0, "left": -1.0}[arm.get("elbow", "right")],
        first=np.array(arm["hand"], dtype=float),
        hand_speed=float(arm["max_hand_speed"]),
        joint_speed=None if speed is None else np.array(speed, dtype=float),
        thickness=float(arm.get("thickness", 0.0)),
        grasp=float(arm.get("grasp", 0.05)),
        plane=Plane(np.array(frame["origin"], dtype=float), axes),
        solid=plane is not None,
    )
