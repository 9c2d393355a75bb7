"""Presets: named sets of configurations of several families."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

Config = Mapping[str, Any]


class Preset(NamedTuple):
    """Configurations of families that take turns."""

    summary: str
    """Description in one line."""
    families: tuple[Config, ...]
    """As `family_from_dict` reads them; item k is drawn from number k modulo their count."""


_PANDA = {"model": "panda", "floor_height": [0.014, 0.014]}
_ACCELERATIONS = [15.0, 7.5, 10.0, 12.5, 15.0, 20.0, 20.0]  # [rad/s^2]
_LIMITED_PANDA = {**_PANDA, "accelerations": _ACCELERATIONS}
_LIMITED = {"human": 0.3, "nao": 0.3, "ramp": [0.03, 0.15], "horizon": [1.6, 2.8]}
_COMMON = {"target": [0.007, 0.007], "when": [0.5, 0.95]}
_EASY = {**_COMMON, "takes": [0.15, 0.6], "directed": 0.0}
_CROWDED = {**_COMMON, "takes": [0.3, 0.8], "directed": 1.0}
_THROW = {"level": [0.5, 1.4], "rise": [-1.0, 0.7], "speed": [0.2, 1.0]}
_EASY_RANGES: dict[str, Config] = {
    "throw-chain": {**_THROW, "strays": [3, 6], "resting": [0, 2]},
    "conveyor-chain": {
        "parts": [1, 1], "posts": [5, 5], "gap": [0.078, 0.11], "strays": [0, 1],
    },
    "window-chain": {"opening": [0.12, 0.15], "strays": [0, 0]},
    "pendulum-chain": {"cords": 0.0, "boxes": [2, 2], "heavy": [1, 3], "strays": [0, 0]},
    "swarm-chain": {"strays": [6, 10]},
    "shelf-chain": {
        "depth": [0.12, 0.16], "wide": [0.12, 0.18], "high": [0.11, 0.13], "doors": 0.2,
        "strays": [0, 1],
    },
}  # fmt: skip
_CROWDED_RANGES: dict[str, Config] = {
    "throw-chain": {**_THROW, "strays": [6, 10], "resting": [1, 3]},
    "conveyor-chain": {
        "parts": [1, 1], "posts": [7, 7], "gap": [0.078, 0.085], "strays": [1, 2],
    },
    "window-chain": {"opening": [0.08, 0.1], "strays": [3, 3]},
    "pendulum-chain": {"cords": 0.0, "boxes": [4, 4], "heavy": [4, 7], "strays": [0, 0]},
    "swarm-chain": {"strays": [10, 15]},
    "shelf-chain": {
        "depth": [0.1, 0.15], "wide": [0.1, 0.135], "high": [0.082, 0.108], "doors": 0.8,
        "strays": [1, 2],
    },
}  # fmt: skip


_SMOOTH_PANDA = {**_LIMITED_PANDA, "jerks": [500.0 * limit for limit in _ACCELERATIONS]}
_HOLDS = {"share": 1.0, "growth": [0.0, 0.01]}
_BINS = {"share": 1.0}
_BELT = {"parts": [1, 1], "sides": [0.015, 0.03], "pace": [0.08, 0.25], "posts": [2, 4]}
_PICKS: dict[str, Config] = {
    "conveyor-chain": {**_BELT, "bins": _BINS},
    "throw-chain": {"level": [0.3, 0.8], "rise": [-1.5, 0.5], "strays": [1, 3]},
    "turntable-chain": {"directed": 1.0, "strays": [1, 2], "bins": {"share": 0.5}},
    "pendulum-chain": {"amplitude": [0.2, 0.5], "heavy": [3, 5]},
    "handover-chain": {"drift": [0.05, 0.2], "strays": [2, 4]},
    "drawer-chain": {"takes": [0.2, 0.7], "strays": [1, 2], "bins": _BINS},
    "shelf-chain": {"takes": [0.2, 0.6], "strays": [1, 2], "bins": _BINS},
}
_BRIEF = {"share": 1.0, "seconds": [0.05, 0.05], "relative_speed": [0.42, 0.42]}  # 0.6 m/s
_UR5 = {"model": "ur5", "accelerations": [10.0] * 6}
_SLOW = {"share": 1.0, "relative_speed": [0.2, 0.4]}
_OF_HOLDS = ("tray-space", "bench-space", "pendulum-space", "crossing-swarm-space")


def _picks(*names: str, arm: Config = _SMOOTH_PANDA, holds: Config = _HOLDS) -> tuple[Config, ...]:
    return tuple({"family": name, **_PICKS[name], "arm": arm, "holds": holds} for name in names)


def _drawn_as(arm: Config, measured: Config, *names: str) -> tuple[Config, ...]:
    return tuple(
        {"family": name, **_EASY, **_EASY_RANGES.get(name, {}), "arm": arm, "measured": measured}
        for name in names
    )


def _sixths(common: Config, ranges: Mapping[str, Config], arm: Config) -> tuple[Config, ...]:
    return tuple({"family": name, **common, **own, "arm": arm} for name, own in ranges.items())


PRESETS: dict[str, Preset] = {
    "panda-easy": Preset(
        "a Panda before few bodies, six families in turns", _sixths(_EASY, _EASY_RANGES, _PANDA)
    ),
    "panda-crowded": Preset(
        "a Panda before many bodies, six families in turns, approaches prescribed",
        _sixths(_CROWDED, _CROWDED_RANGES, _PANDA),
    ),
    "panda-crowded-accelerated": Preset(
        "the same as panda-crowded, with limits of the joints' accelerations",
        _sixths(_CROWDED, _CROWDED_RANGES, _LIMITED_PANDA),
    ),
    "space-sequences": Preset(
        "several balls fly by arms of four joints, with limits of the joints' accelerations",
        ({"family": "sequence-space", "arm": _LIMITED},),
    ),
    "panda-sequences": Preset(
        "several balls drift by a Panda, with limits of the joints' accelerations",
        ({"family": "sequence-chain", "arm": {**_LIMITED_PANDA, "horizon": [1.6, 2.8]}},),
    ),
    "panda-belt": Preset(
        "a Panda picks a box from a belt and puts it into a bin, under limits of jerk",
        _picks("conveyor-chain"),
    ),
    "panda-throw": Preset("a Panda goes with a thrown ball", _picks("throw-chain", holds=_BRIEF)),
    "panda-turntable": Preset("a Panda picks a part off a turntable", _picks("turntable-chain")),
    "panda-pendulum": Preset("a Panda takes hold of a ball on a cord", _picks("pendulum-chain")),
    "panda-handover": Preset("a Panda takes a part from a moving hand", _picks("handover-chain")),
    "panda-bin": Preset(
        "a Panda puts parts from furniture into bins", _picks("drawer-chain", "shelf-chain")
    ),
    "ur5-belt": Preset(
        "a UR5 picks a box from a belt and puts it into a bin", _picks("conveyor-chain", arm=_UR5)
    ),
    "panda-shelf-mesh": Preset(
        "a Panda reaches into shelves that are meshes",
        _drawn_as(_PANDA, {"meshes": 1.0}, "shelf-chain"),
    ),
    "panda-room-cloud": Preset(
        "a Panda among furniture and flying things that are clouds of points",
        _drawn_as(_PANDA, {"clouds": 1.0}, "shelf-chain", "window-chain", "drawer-chain"),
    ),
    "panda-person": Preset(
        "a Panda takes a part while persons walk past, whose margins grow",
        ({"family": "person-chain", "arm": _LIMITED_PANDA, "holds": {"share": 1.0}},),
    ),
    "space-hold": Preset(
        "arms of four joints hold balls, four families in turns",
        tuple({"family": name, "arm": _LIMITED, "holds": _SLOW} for name in _OF_HOLDS),
    ),
}
"""Presets by name."""
