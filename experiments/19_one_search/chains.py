"""Planar arms among solids as chains of two joints."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from gcm_learn.situation import situation_from_json, situation_to_json

TURN = 6.3  # range of the shoulder to either side [rad]
FAST = 40.0  # of joints whose speed only the hand's limit bounds [rad/s]
THIN = 1e-6  # radius of links without thickness


def as_chain(situation: Any) -> Any:
    """Return a planar situation of solids with its arm as a chain.

    Between samples the hand of a planar arm goes straight, the joints of a chain do.  The rest is
    the same: links, elbow side, limits of speed, bodies.
    """
    record = situation_to_json(situation)
    arm, plane = record["arm"], record["plane"]
    upper, left = arm.get("upper_arm", 1.0), arm.get("elbow", "right") == "left"
    shoulder, elbow = _joints(upper, arm["hand"], -1.0 if left else 1.0)
    radius = max(arm.get("thickness", 0.0), THIN)
    speeds = arm.get("max_joint_speed", (FAST, FAST))
    around = [-math.pi, 0.0] if left else [0.0, math.pi]
    model = {
        "format": "gcm-learn/arm@1",
        "name": "planar",
        "joints": [
            {"axis": [0, 0, 1], "range": [-TURN, TURN], "max_speed": speeds[0]},
            {"origin": [upper, 0, 0], "axis": [0, 0, 1], "range": around, "max_speed": speeds[1]},
        ],
        "links": [
            {"joint": 1, "from": [0, 0, 0], "to": [upper, 0, 0], "radius": radius},
            {"joint": 2, "from": [0, 0, 0], "to": [1, 0, 0], "radius": radius},
        ],
        "hand": {"joint": 2, "point": [1, 0, 0], "axis": [1, 0, 0]},
    }
    base = {"origin": plane["origin"], "rotation": _rotation(plane["x"], plane["y"])}
    chain = {"kind": "chain", "model": model, "base": base, "posture": [shoulder, elbow]}
    limits = {"grasp": arm["grasp"], "max_hand_speed": arm["max_hand_speed"]}
    given = {key: record[key] for key in ("name", "horizon", "bodies")}
    return situation_from_json({"format": "gcm-learn/situation@3", "arm": chain | limits, **given})


def _joints(upper: float, hand: list[float], side: float) -> tuple[float, float]:
    """Angles of shoulder and elbow that hold the hand [rad]."""
    x, y = hand
    cosine = (x * x + y * y - upper * upper - 1.0) / (2.0 * upper)
    elbow = side * math.acos(min(max(cosine, -1.0), 1.0))
    shoulder = math.atan2(y, x) - math.atan2(math.sin(elbow), upper + math.cos(elbow))
    return shoulder, elbow


def _rotation(x: list[float], y: list[float]) -> list[float]:
    """Quaternion (w, x, y, z) of the frame with these two axes."""
    found = Rotation.from_matrix(np.array([x, y, np.cross(x, y)]).T).as_quat()
    return [float(found[3]), *map(float, found[:3])]
