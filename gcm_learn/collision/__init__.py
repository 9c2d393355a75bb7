"""Collision queries on a scene: distance, clearance, free intervals, the sweep of a motion."""

from gcm_learn.collision.distance import (
    arm_distance as arm_distance,
    limb_segment2 as limb_segment2,
    segment_distance as segment_distance,
)
from gcm_learn.collision.intervals import NEVER as NEVER
from gcm_learn.collision.occupancy import (
    Postures as Postures,
    blocked_cells as blocked_cells,
    first_touch as first_touch,
    postures_of as postures_of,
)
from gcm_learn.collision.postures import UNLIMITED as UNLIMITED, WORK as WORK, desk_of as desk_of
from gcm_learn.collision.sweep import (
    DEEPEST as DEEPEST,
    Sweep as Sweep,
    least_distance as least_distance,
)
