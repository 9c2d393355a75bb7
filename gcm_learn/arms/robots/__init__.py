"""Arms from files of robots: URDF and MJCF become chains that carry capsules."""

from gcm_learn.arms.robots.chains import (
    Cover as Cover,
    Fitted as Fitted,
    chain_of as chain_of,
    read_robot as read_robot,
)
from gcm_learn.arms.robots.pairs import frames_at as frames_at
from gcm_learn.arms.robots.tree import Drive as Drive, Inertial as Inertial, Robot as Robot
