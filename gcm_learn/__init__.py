"""Memory for movement in a changing world: cognitive maps that turn dynamic scenes static.

>>> import gcm_learn
>>> plan = gcm_learn.solve(gcm_learn.paper_scene("fig4"))
>>> plan.status
'caught'
"""

import importlib.util
from typing import TYPE_CHECKING, Any

from gcm_learn import registration
from gcm_learn.late import late_names

if TYPE_CHECKING:
    from gcm_learn.arms import Arm, SpatialArm
    from gcm_learn.charts import Lattice
    from gcm_learn.errors import GcmError, SituationError
    from gcm_learn.families import paper_scene
    from gcm_learn.maps import CognitiveMap, build_map
    from gcm_learn.motion import Movement
    from gcm_learn.planners import Plan, get_planner, planner_names, solve
    from gcm_learn.seeding import rng
    from gcm_learn.situation import (
        Body,
        Disc,
        PlanarQuadratic,
        Polygon,
        Situation,
        SolidQuadratic,
        Sphere,
        read_situations,
        write_situations,
    )
    from gcm_learn.wave import MarchingParams, WaveParams

__version__ = "0.1.0"

registration.announce()  # so that gymnasium.make("gcm_learn:CatchArm-v0") finds it

# Loaded when they are asked for: compiled code takes most of a second to load, in which the
# command line could neither answer nor be stopped.
_late = late_names(__name__, {
    "arms": ("Arm", "SpatialArm"),
    "errors": ("GcmError", "SituationError"),
    "families": ("paper_scene",),
    "charts": ("Lattice",),
    "maps": ("CognitiveMap", "build_map"),
    "motion": ("Movement",),
    "planners": ("Plan", "get_planner", "planner_names", "solve"),
    "seeding": ("rng",),
    "situation": (
        "Body", "Disc", "PlanarQuadratic", "Polygon", "Situation", "SolidQuadratic", "Sphere",
        "read_situations", "write_situations",
    ),
    "wave": ("MarchingParams", "WaveParams"),
})  # fmt: skip


def __getattr__(name: str) -> Any:
    """Return a public name or a subpackage, imported at its first use."""
    if name in __all__ or name.startswith("_"):
        return _late(name)
    if importlib.util.find_spec(f"gcm_learn.{name}") is not None:
        return importlib.import_module(f"gcm_learn.{name}")
    raise AttributeError(f"module 'gcm_learn' has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})


__all__ = [
    "Arm",
    "Body",
    "CognitiveMap",
    "Disc",
    "GcmError",
    "Lattice",
    "MarchingParams",
    "PlanarQuadratic",
    "Plan",
    "Polygon",
    "Situation",
    "SituationError",
    "SolidQuadratic",
    "SpatialArm",
    "Sphere",
    "Movement",
    "WaveParams",
    "build_map",
    "get_planner",
    "paper_scene",
    "planner_names",
    "read_situations",
    "rng",
    "solve",
    "write_situations",
]
