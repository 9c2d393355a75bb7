"""Arms from files of robots: URDF and MJCF become chains that carry capsules."""

from gcm_learn.arms.robots.chains import Cover, Fitted, chain_of, read_robot
from gcm_learn.arms.robots.pairs import frames_at
from gcm_learn.arms.robots.tree import Drive, Inertial, Robot

__all__ = [
    "Cover",
    "Drive",
    "Fitted",
    "Inertial",
    "Robot",
    "chain_of",
    "frames_at",
    "read_robot",
]
