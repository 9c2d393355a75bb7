"""Timed movement: trajectories, timing under limits, interception, verification."""

from gcm_learn.motion.clearance import clearance
from gcm_learn.motion.failures import Failure, Reason
from gcm_learn.motion.interception import anywhere, first_catch, first_interception
from gcm_learn.motion.rules import Opening, Rules, opening, rules_of, start_clearance
from gcm_learn.motion.timing import keep_limits, refine, segment_times, straight_path
from gcm_learn.motion.trajectory import Trajectory, Wait
from gcm_learn.motion.verification import HOLE_MARGIN, Verdict, verify

__all__ = [
    "Failure",
    "HOLE_MARGIN",
    "Reason",
    "Opening",
    "Rules",
    "Trajectory",
    "Verdict",
    "Wait",
    "anywhere",
    "clearance",
    "first_catch",
    "first_interception",
    "keep_limits",
    "opening",
    "refine",
    "rules_of",
    "segment_times",
    "start_clearance",
    "straight_path",
    "verify",
]
