"""Timed movement: trajectories, timing under limits, interception, verification."""

from gcm_learn.motion.as_obstacles import as_obstacles as as_obstacles
from gcm_learn.motion.carrying import Carry as Carry
from gcm_learn.motion.failures import Failure as Failure, Reason as Reason
from gcm_learn.motion.interception import (
    anywhere as anywhere,
    first_catch as first_catch,
    first_interception as first_interception,
)
from gcm_learn.motion.joint_interception import fastest_hand as fastest_hand
from gcm_learn.motion.joint_trajectory import (
    joint_names as joint_names,
    to_csv as to_csv,
    to_joint_trajectory as to_joint_trajectory,
    to_yaml as to_yaml,
)
from gcm_learn.motion.movement import Movement as Movement, Wait as Wait
from gcm_learn.motion.overlaps import (
    collided_part as collided_part,
    collision_point as collision_point,
    why_blocked as why_blocked,
)
from gcm_learn.motion.rules import (
    Opening as Opening,
    Rules as Rules,
    opening as opening,
    rules_of as rules_of,
    start_clearance as start_clearance,
)
from gcm_learn.motion.smoothing import (
    ends_at_rest as ends_at_rest,
    half_width as half_width,
    rests_at_end as rests_at_end,
    smoothed as smoothed,
    start_before as start_before,
)
from gcm_learn.motion.stopping import braked as braked, with_stop as with_stop
from gcm_learn.motion.timing import (
    SPACING as SPACING,
    keep_limits as keep_limits,
    refine as refine,
    segment_times as segment_times,
    spread as spread,
    straight_path as straight_path,
)
from gcm_learn.motion.verification import (
    HOLE_MARGIN as HOLE_MARGIN,
    PARTS as PARTS,
    RESOLUTION as RESOLUTION,
    Ask as Ask,
    Verdict as Verdict,
    clearance as clearance,
    joint_turns as joint_turns,
    verify as verify,
)
