"""The form of arm files, alone and in their situation."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from gcm_learn.referee.form import is_number
from gcm_learn.referee.situations import (
    BASE,
    V3,
    Fields,
    either,
    fields,
    index,
    is_object,
    list_of,
    pair_of_ends,
    positive,
    text,
    unit_of,
)
from gcm_learn.referee.tolerances import Unreadable

FOLLOWING = 1e-6
"""By which a follower may be outside its range at t = 0, relative and absolute; *contract*."""
JOINT: tuple[Fields, Fields] = (
    {"axis": unit_of(3), "range": pair_of_ends, "max_speed": positive},
    {"name": text, "type": either("revolute", "prismatic"), **BASE, "max_acceleration": positive},
)
LINK: Fields = {"joint": index, "from": V3, "to": V3, "radius": positive}
MODELS: dict[str, tuple[Fields, Fields]] = {
    "gcm-learn/arm@1": ({}, {}),
    "gcm-learn/arm@2": (
        {"max_jerk": positive, "parent": index, "follows": is_object},
        {"name": text},
    ),
}
"""Fields of joints and of links that formats of arm files add."""


def check_model(model: Any, arm: Mapping[str, Any]) -> None:
    """Refuse an arm file's object that is none, or that does not fit the arm of a situation."""
    path, objects = "arm.model", list_of(is_object)
    pair = list_of(index, 2)
    fields(
        model, path,
        {"format": either(*MODELS), "joints": objects, "links": objects, "hand": is_object},
        {
            "name": text, "source": text,
            "self_collision": lambda v: v == [] or list_of(pair)(v),
        },
    )  # fmt: skip
    n, (of_joints, of_links) = len(model["joints"]), MODELS[model["format"]]
    for k, joint in enumerate(model["joints"]):
        fields(joint, f"{path}.joints[{k}]", JOINT[0], {**JOINT[1], **of_joints})
        _check_tree(model["joints"], k, f"{path}.joints[{k}]")
    fields(model["hand"], f"{path}.hand", {"joint": index, "point": V3}, {"axis": unit_of(3)})
    for k, link in enumerate(model["links"]):
        fields(link, f"{path}.links[{k}]", LINK, of_links)
        if link["joint"] > n:
            raise Unreadable(f"{path}.links[{k}].joint: there are {n} joints")
    if not 1 <= model["hand"]["joint"] <= n:
        raise Unreadable(f"{path}.hand.joint: there are {n} joints")
    if any(i == j or max(i, j) >= len(model["links"]) for i, j in model.get("self_collision", [])):
        raise Unreadable(f"{path}.self_collision: not a pair of links")
    leaders = [joint for joint in model["joints"] if "follows" not in joint]
    for name in ("max_acceleration", "max_jerk"):
        if len({name in joint for joint in leaders}) > 1:
            raise Unreadable(f"{path}.joints: some have a {name}")
    if "max_jerk" in leaders[0] and "max_acceleration" not in leaders[0]:
        raise Unreadable(f"{path}.joints: max_jerk needs max_acceleration")
    n = len(leaders)
    for name in ("posture", "rates", "max_acceleration", "max_jerk", "accelerations"):
        if arm.get(name) is not None and len(arm[name]) != n:
            raise Unreadable(f"arm.{name}: has {len(arm[name])} numbers, there are {n} coordinates")
    _check_followers(model["joints"], arm["posture"])


def _check_tree(joints: Any, k: int, path: str) -> None:
    """Refuse a joint (from 0) whose parent or leader does not come before it."""
    if joints[k].get("parent", k) > k:
        raise Unreadable(f"{path}.parent: is not before the joint")
    if "follows" in joints[k]:
        follows = joints[k]["follows"]
        line: Fields = {"joint": index, "factor": is_number}
        fields(follows, f"{path}.follows", line, {"offset": is_number})
        if not 1 <= follows["joint"] <= k or "follows" in joints[follows["joint"] - 1]:
            raise Unreadable(f"{path}.follows.joint: is no leader before the joint")


def _check_followers(joints: Any, posture: Any) -> None:
    """Refuse a start at which a follower is outside its range."""
    leaders = [k for k, joint in enumerate(joints, 1) if "follows" not in joint]
    for k, joint in enumerate(joints):
        if "follows" in joint:
            line, (low, high) = joint["follows"], joint["range"]
            value = line["factor"] * posture[leaders.index(line["joint"])] + line.get("offset", 0.0)
            slack = [FOLLOWING * max(1.0, abs(end)) for end in (low, high)]
            if not low - slack[0] <= value <= high + slack[1]:
                raise Unreadable(f"arm.posture: puts joints[{k}] at {value:g}, out of its range")
