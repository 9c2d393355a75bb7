"""What a front has to explore."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gcm_learn.arm.lattice import Lattice, joint_rates
from gcm_learn.situation.kernels import Bodies


@dataclass(frozen=True)
class Task:
    """What a front has to explore: the world, the arm and the lattice."""

    bodies: Bodies
    """Obstacles freeze the front (Eq. 11), targets are contacts."""
    lattice: Lattice
    hand: tuple[float, float]
    """Where the front starts [forearm lengths]."""
    speed: float
    """Largest hand speed [forearm lengths / s]; the front's fastest direction gets it."""
    horizon: float
    """When the front is stopped [s]."""
    thickness: float = 0.0
    """Radius of the limb [forearm lengths]."""
    grasp: float = 0.0
    """Distance at which the hand catches a target [forearm lengths]."""
    ignore: float = 0.0
    """Contacts before this time do not count [s]."""
    joint_speed: tuple[float, float] | None = None
    """Largest speeds of shoulder and elbow [rad/s]; None if only the hand's is limited."""

    @property
    def fastest(self) -> float:
        """Speed that the hand nowhere exceeds, so that of the front [forearm lengths / s]."""
        if self.joint_speed is None:
            return self.speed
        shoulder, elbow = self.joint_speed
        return min(self.speed, (self.lattice.upper_arm + 1.0) * shoulder + elbow)

    def rates(self) -> np.ndarray:
        """Joint speeds (n * n, 4) of a hand at the fastest speed in x and in y, over their limits.

        No rows if the joints are not limited.
        """
        if self.joint_speed is None:
            return np.empty((0, 4))
        limits = np.array(self.joint_speed)[:, None]
        return (joint_rates(self.lattice) * (self.fastest / limits)).reshape(-1, 4)
