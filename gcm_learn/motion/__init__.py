"""Timed movement: trajectories, timing under limits, interception, verification."""

from gcm_learn.motion.clearance import clearance
from gcm_learn.motion.failures import Failure, Reason
from gcm_learn.motion.interception import anywhere, first_catch, first_interception, may_be_reached
from gcm_learn.motion.rules import Rules, opening, rules_of, start_clearance
from gcm_learn.motion.timing import keep_limits, refine, segment_times, straight_path
from gcm_learn.motion.trajectory import Trajectory, Wait
from gcm_learn.motion.verification import HOLE_MARGIN, Verdict, verify

__all__ = [
    "Failure",
    "HOLE_MARGIN",
    "Reason",
    "Rules",
    "Trajectory",
    "Verdict",
    "Wait",
    "anywhere",
    "clearance",
    "first_catch",
    "first_interception",
    "keep_limits",
    "may_be_reached",
    "opening",
    "refine",
    "rules_of",
    "segment_times",
    "start_clearance",
    "straight_path",
    "verify",
]
