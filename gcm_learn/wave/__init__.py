"""The engine: the FitzHugh-Nagumo wave of Eq. 10 and causal marching on the same lattice."""

from gcm_learn.wave.params import WaveParams
from gcm_learn.wave.solver import (
    Front,
    FrontSpeed,
    LayeredFront,
    MarchingParams,
    front_speed,
    kappa_of,
    march,
    march_layers,
    propagate,
)
from gcm_learn.wave.task import Task
from gcm_learn.wave.waiting import propagate_layers

__all__ = [
    "Front",
    "FrontSpeed",
    "LayeredFront",
    "MarchingParams",
    "Task",
    "WaveParams",
    "front_speed",
    "kappa_of",
    "march",
    "march_layers",
    "propagate",
    "propagate_layers",
]
