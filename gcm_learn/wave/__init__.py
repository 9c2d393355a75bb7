"""The engine: the FitzHugh-Nagumo wave of Eq. 10 and causal marching on the same charts."""

from gcm_learn.wave.front import Front as Front
from gcm_learn.wave.kinds import engine_of as engine_of, fastest as fastest, kappa_of as kappa_of
from gcm_learn.wave.params import MarchingParams as MarchingParams, WaveParams as WaveParams
from gcm_learn.wave.solver import FrontSpeed as FrontSpeed, front_speed as front_speed
