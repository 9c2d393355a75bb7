"""The engine: the FitzHugh-Nagumo wave of Eq. 10 and causal marching on the same charts."""

from gcm_learn.wave.front import Front
from gcm_learn.wave.kinds import engine_of, fastest, kappa_of
from gcm_learn.wave.params import MarchingParams, WaveParams
from gcm_learn.wave.solver import FrontSpeed, front_speed

__all__ = [
    "Front",
    "FrontSpeed",
    "MarchingParams",
    "WaveParams",
    "engine_of",
    "fastest",
    "front_speed",
    "kappa_of",
]
