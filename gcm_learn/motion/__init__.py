"""Timed movement: trajectories, timing under limits, interception, verification."""

from gcm_learn.motion.clearance import clearance
from gcm_learn.motion.trajectory import Trajectory

__all__ = ["Trajectory", "clearance"]
