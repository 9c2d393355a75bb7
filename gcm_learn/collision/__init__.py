"""Collision queries on a scene: distance, clearance, free intervals, the sweep of a motion."""

from gcm_learn.collision.distance import arm_distance, limb_segment2, segment_distance
from gcm_learn.collision.intervals import NEVER
from gcm_learn.collision.occupancy import Postures, blocked_cells, first_touch, postures_of
from gcm_learn.collision.postures import UNLIMITED, WORK, desk_of
from gcm_learn.collision.sweep import DEEPEST, Sweep, least_distance

__all__ = [
    "DEEPEST",
    "NEVER",
    "UNLIMITED",
    "WORK",
    "Postures",
    "Sweep",
    "arm_distance",
    "blocked_cells",
    "desk_of",
    "first_touch",
    "least_distance",
    "limb_segment2",
    "postures_of",
    "segment_distance",
]
