"""What can be asked of a scene: distance, clearance, free intervals, the sweep of a motion."""

from gcm_learn.collision.distance import arm_distance, limb_segment2
from gcm_learn.collision.occupancy import first_touch
from gcm_learn.collision.sweep import least_distance

__all__ = [
    "arm_distance",
    "first_touch",
    "least_distance",
    "limb_segment2",
]
