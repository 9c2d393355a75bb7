"""A situation compiled: bodies and limb as arrays, their poses, bounds of their motion."""

from gcm_learn.scene.limb import elbow_position, forward, joint_angles

__all__ = ["elbow_position", "forward", "joint_angles"]
