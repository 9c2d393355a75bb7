"""Commands of motors that follow a plan.

Torque = feed-forward + kp (wanted angle - angle) + kd (wanted rate - rate), cut at the motor's
limit.  MuJoCo evaluates it within each step; what is handed over is the part that does not depend
on the state.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any, Literal, get_args

import numpy as np

from gcm_learn.errors import PhysicsError
from gcm_learn.execution.body.kinds import rested
from gcm_learn.execution.body.motors import Dynamics, load_of
from gcm_learn.situation import AnyArmBody

Feedforward = Literal["computed-torque", "gravity"]


@dataclass(frozen=True)
class Controller:
    """Torques that follow a plan.

    Parameters
    ----------
    feedforward : {"computed-torque", "gravity"}
        Torques that the plan itself needs by the arm's inverse dynamics, or only what holds the
        arm's weight where the plan has it.
    bandwidth : float
        Of the feedback, which is critically damped; above zero [rad/s].
    """

    feedforward: Feedforward = "computed-torque"
    bandwidth: float = 60.0

    def __post_init__(self) -> None:
        if self.feedforward not in get_args(Feedforward):
            known = ", ".join(get_args(Feedforward))
            raise PhysicsError(f"feedforward: {self.feedforward!r} is not one of {known}")
        if not 0.0 < self.bandwidth <= 500.0:
            raise PhysicsError(
                f"bandwidth: must be above 0 and at most 500 rad/s (got {self.bandwidth!r})"
            )


class Following:
    """A controller made for an arm and its body.

    Parameters
    ----------
    controller : Controller
    arm : SpatialArm or Chain
    body : ArmBody or ChainBody
    """

    def __init__(self, controller: Controller, arm: Any, body: AnyArmBody) -> None:
        self._dynamics = Dynamics(arm, body)
        self._computed = controller.feedforward == "computed-torque"
        self.inertia = np.median(np.einsum("njj->nj", load_of(arm, body).inertia), axis=0)
        """Inertia that each joint feels alone (dof,) [kg m^2; N s^2 / length]."""
        self.kp = controller.bandwidth**2 * self.inertia
        """(dof,) [N m/rad]"""
        self.kd = 2.0 * controller.bandwidth * self.inertia
        """(dof,) [N m s]"""

    def holding(self, joints: np.ndarray) -> np.ndarray:
        """Torques (dof,) that hold the arm's weight at joints (dof,) [N m]."""
        still = np.zeros((1, len(joints)))
        return self._dynamics.torques(joints[None], still, still)[0]

    def commands(self, joints: np.ndarray, rates: np.ndarray, forces: np.ndarray) -> np.ndarray:
        """Commands of the motors (n, dof) [N m], from wanted angles, rates, accelerations."""
        if not self._computed:
            still = np.zeros_like(rates)
            torques = self._dynamics.torques(joints, still, still)
        else:
            torques = self._dynamics.torques(joints, rates, forces)
        return torques + self.kp * joints + self.kd * rates


def following(controller: Controller, arm: Any, body: AnyArmBody) -> Following:
    """A controller made for an arm, wherever that begins; kept for the next one like it."""
    return _kept(controller, *rested(arm, body))


@lru_cache(maxsize=64)
def _kept(controller: Controller, arm: Any, body: AnyArmBody) -> Following:
    return Following(controller, arm, body)
