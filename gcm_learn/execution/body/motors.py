"""Motors: the inertias that they feel, the accelerations that they give, commands for a plan.

Torque = feed-forward + kp (wanted angle - angle) + kd (wanted rate - rate), cut at the motor's
limit.  MuJoCo evaluates it within each step; what is handed over is the part that does not depend
on the state.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any, Literal, get_args

import numpy as np

from gcm_learn import seeding
from gcm_learn.errors import PhysicsError
from gcm_learn.execution.body.kinds import MECHANICS, rested, strongest
from gcm_learn.execution.body.model import compiled, coupling_of, model_xml, mujoco
from gcm_learn.situation import AnyArmBody, Situation

SAMPLES = 400
"""Postures at which motors are asked."""
SHARE = 0.8
"""Of the torque that a plan may use; the rest is for feedback."""
QUANTILE = 0.1
"""Share of postures and rates at which the limits ask for more than that."""


FAINT = 1e-12
"""Torques below this count as zero [N m]."""


@dataclass(frozen=True)
class Load:
    """Load of an arm's motors at n postures."""

    inertia: np.ndarray
    """(n, dof, dof): mass matrices [kg m^2]."""
    bias: np.ndarray
    """(n, dof): torques against gravity, damping and what rotation adds [N m]."""
    gravity: np.ndarray
    """(n, dof): against gravity alone [N m]."""


class Dynamics:
    """Inverse dynamics of an arm alone, without limits and contacts.

    Motors move followers, too: their torques count by the factors of their lines.

    Joints and torques are in the arm's units: of a prismatic joint lengths and N.

    Parameters
    ----------
    arm : SpatialArm or Chain
    body : ArmBody or ChainBody
    """

    def __init__(self, arm: Any, body: AnyArmBody) -> None:
        self._model = compiled(model_xml(arm, body))
        self._data = mujoco().MjData(self._model)
        self._metric = MECHANICS.of(arm).metric(arm, body.metres)
        self._coupling = coupling_of(self._model, arm, body.metres)

    def torques(self, joints: np.ndarray, rates: np.ndarray, forces: np.ndarray) -> np.ndarray:
        """Torques (n, dof) [N m] that give accelerations.

        Parameters
        ----------
        joints, rates, forces : (n, dof) ndarray
            Angles, rates and accelerations.
        """
        model, data, inverse = self._model, self._data, mujoco().mj_inverse
        factors, offsets, _ = self._coupling
        states = [(values * self._metric) @ factors.T for values in (joints, rates, forces)]
        states[0] += offsets
        qpos, qvel, qacc, force = data.qpos, data.qvel, data.qacc, data.qfrc_inverse
        out = np.empty(np.shape(joints))
        for at, moving, asked, row in zip(*states, out, strict=True):
            qpos[:], qvel[:], qacc[:] = at, moving, asked
            inverse(model, data)
            row[:] = force @ factors
        return out

    def inertia(self, joints: np.ndarray) -> np.ndarray:
        """Mass matrix (dof, dof) at joints (dof,) [kg m^2]."""
        dof = len(joints)
        rest = np.zeros((dof, dof))
        here = np.broadcast_to(joints, rest.shape)
        weight = self.torques(here[:1], rest[:1], rest[:1])
        return self.torques(here, rest, np.eye(dof)) - weight


def load_of(arm: Any, body: AnyArmBody) -> Load:
    """Return the load of the motors at postures and rates spread over the arm's ranges."""
    rng = seeding.rng(0, SAMPLES)
    low, high = np.array(arm.joint_range).T
    shape = SAMPLES, len(low)
    joints = rng.uniform(low, high, shape)
    top = np.array(arm.max_joint_speed)
    rates = rng.uniform(-top, top, shape)
    dynamics, still = Dynamics(arm, body), np.zeros(shape)
    return Load(
        np.array([dynamics.inertia(q) for q in joints]),
        dynamics.torques(joints, rates, still),
        dynamics.torques(joints, still, still),
    )


def motor_accelerations(arm: Any, body: AnyArmBody) -> np.ndarray:
    """Limits of the joints' accelerations (dof,) that come from the motors [rad/s^2].

    Each joint gets the same share of the acceleration that its motor gives to its own inertia. It
    is the largest share with which motors need at most `SHARE` of their torques, gravity included,
    at nine tenths of postures and rates, whatever joints accelerate.

    Raises
    ------
    PhysicsError
        If a motor cannot hold the arm.
    """
    return np.array(_limits(*rested(arm, body)))


@lru_cache(maxsize=64)
def _limits(arm: Any, body: AnyArmBody) -> tuple[float, ...]:
    load, torque = load_of(arm, body), strongest(arm, body)
    alone = torque / np.median(np.einsum("njj->nj", load.inertia), axis=0)
    asked = np.maximum(np.abs(load.inertia) @ alone, FAINT)
    share = ((SHARE * torque - np.abs(load.bias)) / asked).min(axis=1)
    least = float(np.quantile(share, QUANTILE))
    if least <= 0.0 or not torque.all():
        weak = int(np.argmax((np.abs(load.gravity) / np.maximum(torque, FAINT)).max(axis=0)))
        weak = weak if torque.all() else int(np.argmin(torque))
        need = float(np.abs(load.gravity[:, weak]).max())
        raise PhysicsError(
            f"body {body.name!r}: joints[{weak}].torque of {torque[weak]:g} N m leaves nothing to "
            f"accelerate with (the arm's weight asks for up to {need:.3g} N m)"
        )
    return tuple((least * alone).tolist())


def with_motor_limits(situation: Situation[Any], body: AnyArmBody) -> Situation[Any]:
    """Return a situation under its own limits of acceleration, or else under the motors'."""
    arm = situation.arm
    if arm.max_joint_acceleration is not None:
        return situation
    most: Any = tuple(motor_accelerations(arm, body).tolist())
    return replace(situation, arm=replace(arm, max_joint_acceleration=most))


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
    """Return the controller of an arm, cached for equal arms wherever they begin."""
    return _kept(controller, *rested(arm, body))


@lru_cache(maxsize=64)
def _kept(controller: Controller, arm: Any, body: AnyArmBody) -> Following:
    return Following(controller, arm, body)
