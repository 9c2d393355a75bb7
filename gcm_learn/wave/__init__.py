"""The engine: the FitzHugh-Nagumo wave of Eq. 10 and causal marching on the same charts."""

from gcm_learn.wave.causal import march, march_layers
from gcm_learn.wave.front import Front
from gcm_learn.wave.limits import fastest
from gcm_learn.wave.params import MarchingParams, WaveParams
from gcm_learn.wave.solver import FrontSpeed, front_speed, kappa_of, propagate
from gcm_learn.wave.waiting import propagate_layers

__all__ = [
    "Front",
    "FrontSpeed",
    "MarchingParams",
    "WaveParams",
    "fastest",
    "front_speed",
    "kappa_of",
    "march",
    "march_layers",
    "propagate",
    "propagate_layers",
]
