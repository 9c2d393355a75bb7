"""Timed movement: trajectories, timing under limits, interception, verification."""

from gcm_learn.motion.acceleration import braked
from gcm_learn.motion.as_obstacles import as_obstacles
from gcm_learn.motion.clearance import RESOLUTION, clearance
from gcm_learn.motion.failures import Failure, Reason
from gcm_learn.motion.interception import anywhere, first_catch, first_interception
from gcm_learn.motion.joint_interception import fastest_hand, resting_in_space
from gcm_learn.motion.joint_trajectory import (
    joint_names,
    to_csv,
    to_joint_trajectory,
    to_yaml,
)
from gcm_learn.motion.movement import Movement, Wait
from gcm_learn.motion.overlaps import why_blocked
from gcm_learn.motion.rules import Opening, Rules, opening, rules_of, start_clearance
from gcm_learn.motion.stopping import with_stop
from gcm_learn.motion.timing import (
    SPACING,
    keep_limits,
    refine,
    segment_times,
    spread,
    straight_path,
)
from gcm_learn.motion.touching import collided_part, collision_point
from gcm_learn.motion.verification import HOLE_MARGIN, PARTS, Verdict, joint_turns, verify

__all__ = [
    "Failure",
    "HOLE_MARGIN",
    "Opening",
    "PARTS",
    "RESOLUTION",
    "Reason",
    "Rules",
    "SPACING",
    "Movement",
    "Verdict",
    "Wait",
    "anywhere",
    "as_obstacles",
    "braked",
    "clearance",
    "collided_part",
    "collision_point",
    "fastest_hand",
    "first_catch",
    "first_interception",
    "joint_names",
    "joint_turns",
    "keep_limits",
    "opening",
    "refine",
    "resting_in_space",
    "rules_of",
    "segment_times",
    "spread",
    "start_clearance",
    "straight_path",
    "to_csv",
    "to_joint_trajectory",
    "to_yaml",
    "verify",
    "why_blocked",
    "with_stop",
]
