"""Memory for movement in a changing world: cognitive maps that turn dynamic scenes static.

>>> import gcm_learn
>>> plan = gcm_learn.solve(gcm_learn.paper_scene("fig4"))
>>> plan.status
'caught'
"""

from gcm_learn import registration
from gcm_learn.errors import GcmError, SituationError
from gcm_learn.families import paper_scene
from gcm_learn.handspace import Lattice
from gcm_learn.maps import CognitiveMap, build_map
from gcm_learn.motion import Trajectory
from gcm_learn.planners import Plan, get_planner, planner_names, solve
from gcm_learn.seeding import rng
from gcm_learn.situation import (
    Arm,
    Body,
    Disc,
    PlanarQuadratic,
    Polygon,
    Situation,
    read_situations,
    write_situations,
)
from gcm_learn.wave import MarchingParams, WaveParams

__version__ = "0.1.0"

registration.announce()  # so that gymnasium.make("gcm_learn:CatchArm-v0") finds it

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
    "Trajectory",
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
