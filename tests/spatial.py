"""Situations of arms in space, and an arm of two bones."""

from pathlib import Path

import numpy as np

from gcm_learn.arms import SpatialArm

EXAMPLES = Path(__file__).with_name("spatial.jsonl")
"""Fifty situations with two arms, six of them with limits of acceleration."""
TWO_BONES = SpatialArm(
    upper_arm=(1.0, 0.0, 0.0), forearm=(0.8, 0.0, 0.0), joints=(0.0, 0.0, 0.0, -0.9),
    joint_range=((-3.0, 3.0),) * 4, max_joint_speed=(9.0,) * 4, grasp=0.05, thickness=0.05,
)  # fmt: skip
TURNED = np.array((0.4, 0.3, 0.2, -0.7))
"""Another posture of the arm of two bones."""
