"""What a front has to explore."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gcm_learn.handspace.lattice import Lattice, cell_joints, hand_space
from gcm_learn.scene.bodies import Bodies
from gcm_learn.scene.limb import joint_angles


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
    widening: np.ndarray | None = None
    """(n * n,) margin of every cell beyond that of the front's parameters, in the same unit."""
    joint_speed: tuple[float, float] | None = None
    """Largest speeds of shoulder and elbow [rad/s]; None if only the hand's is limited."""

    def gaps(self, margin: float) -> np.ndarray:
        """Distance (n * n,) at which an obstacle occupies a cell [forearm lengths].

        `margin` is that of the front's parameters: 1 is what half a cell's step moves the limb.
        """
        wide = margin if self.widening is None else margin + self.widening
        return self.thickness + wide * hand_space(self.lattice).stride

    @property
    def fastest(self) -> float:
        """Speed that the hand nowhere exceeds, so that of the front [forearm lengths / s]."""
        if self.joint_speed is None:
            return self.speed
        shoulder, elbow = self.joint_speed
        return min(self.speed, (self.lattice.upper_arm + 1.0) * shoulder + elbow)

    def turns(self) -> tuple[np.ndarray, float]:
        """Joint angles in every cell, then the hand's (n * n + 1, 2), and a shoulder's full turn.

        As times that it takes to turn so far, in crossings of a cell at the fastest speed; no rows
        if the joints are not limited.
        """
        if self.joint_speed is None:
            return np.empty((0, 2)), 1.0
        unit = np.array(self.joint_speed) * self.lattice.spacing / self.fastest
        if unit.min() >= 2.0 * np.pi:  # no turn takes longer than the hand to the next cell
            return np.empty((0, 2)), 1.0
        arm = self.lattice.upper_arm, self.lattice.elbow
        joints = np.vstack([cell_joints(self.lattice), joint_angles(self.hand, *arm)])
        return joints / unit, float(2.0 * np.pi / unit[0])
