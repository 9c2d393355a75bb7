"""Plans carried out by an arm with mass, their outcomes, and the width of their tube."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from gcm_learn.errors import PhysicsError
from gcm_learn.execution.arena.kernels.world import CAUGHT, COLLIDED
from gcm_learn.execution.arena.pool import Catch
from gcm_learn.execution.body.bodies import body_for
from gcm_learn.execution.body.gripper import Gripped, GrippingPlant
from gcm_learn.execution.body.kinds import MECHANICS
from gcm_learn.execution.body.model import STEP
from gcm_learn.execution.body.motors import FAINT, Controller, with_motor_limits
from gcm_learn.execution.body.plant import Contact, PhysicalPlant
from gcm_learn.execution.loop.closed_loop import ExactPlant, Loop, Mind, run_closed_loop
from gcm_learn.execution.loop.joint_leading import begun, gripped
from gcm_learn.motion import Movement, braked
from gcm_learn.planners import Plan, Tube
from gcm_learn.situation import AnyArmBody, Situation

FORMAT = "gcm-learn/execution@1"
STAYS = 0.2
"""Time for which a caught target has to remain within grasp to have stayed [s]."""

STATUS = {CAUGHT: "caught", COLLIDED: "collided"}
"""By outcome; all others are late."""
CARRY = 5.0
"""Time after the horizon and the hold in which a target has to be placed in the closed loop [s]."""
AT_REST = 0.05
"""Joints that are slower than this rest [rad/s]."""


@dataclass(frozen=True)
class Execution:
    """Result of a plan in physics; lengths in metres."""

    name: str
    """Of the situation."""
    planner: str
    status: str
    """"caught", "collided" or "late"; "no plan" where there was none to follow, "no body"
    where none fits the arm, "failed" where physics could not."""
    message: str = ""
    """Reason for a missing plan or a failure."""
    body: str = ""
    """Name of the body."""
    limits: tuple[float, ...] | None = None
    """Of accelerations, where they came from the motors [rad/s^2]."""
    planned: float | None = None
    """Catch time of the plan [s]."""
    catch_time: float | None = None
    """Time at which the hand first was within grasp of a target [s]."""
    catch_body: str | None = None
    """Target of the last catch, which is at `catch_time`."""
    catches: tuple[Catch, ...] = ()
    """Targets that were caught before any contact, in order, whatever came of the rest."""
    several: tuple[str, ...] = ()
    """Names of all targets, where the situation asks for several."""
    contact: Contact | None = None
    """Of limb and obstacle before the catch, with several before the last one."""
    error: tuple[float, float, float] | None = None
    """Distance of the hand from where the plan has it until the catch: median, largest, and at
    the end [m]."""
    torque: float | None = None
    """Largest share of a motor's torque until the catch."""
    stays: bool | None = None
    """True if the last target was within grasp for another `STAYS` seconds, with no fingers to
    hold it."""
    grip: Gripped | None = None
    """Of the last target that was gripped."""
    touch: Execution | None = None
    """The same without a hold and a place: a touch at which a gripper closes at once."""
    braked: float | None = None
    """Time from the catch until the arm rested [s]."""
    braked_into: Contact | None = None
    """Contact of the limb after the catch."""
    plan: Movement | None = None
    """Movement that was followed: the plan, and braking after it."""
    plant: PhysicalPlant | None = None
    """With its logs."""

    @property
    def movement(self) -> Movement:
        """Return the movement until the catch or the end; linear between steps.

        Raises
        ------
        PhysicsError
            If there was no plan to follow.
        """
        if self.plant is None and self.plan is not None:
            return self.plan
        if self.plant is None:
            raise PhysicsError(f"{self.name!r}: nothing was executed ({self.status})")
        return self.plant.movement_to(_ended(self.plant))

    @property
    def caught(self) -> bool:
        """Return whether the target was caught before any contact."""
        return self.status == "caught"


def execute(
    plan: Plan,
    situation: Situation[Any],
    body: AnyArmBody | str | Path | None = None,
    controller: Controller | None = None,
    *,
    believed: AnyArmBody | None = None,
    kinematic: bool = False,
    grips: bool = False,
) -> Execution:
    """Carry out a plan with an arm that has mass and motors.

    After the plan's end the arm brakes. Targets that are held are gripped at the end of the hold.

    Parameters
    ----------
    plan : Plan
    situation : Situation
        The world as it is, whatever the plan was made for.
    body : ArmBody, ChainBody, str or Path, optional
        See `body_for`.
    controller : Controller, optional
    believed : ArmBody or ChainBody, optional
        What the controller takes the body for, if not for what it is.
    kinematic : bool
        Whether the arm does at once what it is told, and has no mass; no body is asked for then.
    grips : bool
        Whether touched targets are gripped, too, in the moment of the touch.

    Raises
    ------
    PhysicsError
        If the body does not fit, or the physics fails.
    """
    if kinematic:
        return _exactly(plan, situation)
    chosen = body_for(situation.arm, body)
    if plan.trajectory is None:
        why = plan.message
        return Execution(
            situation.name, plan.planner, "no plan", why, chosen.name, several=several_in(situation)
        )
    limits = with_motor_limits(situation, chosen).arm.max_joint_acceleration
    grips = grips or any("held_until" in one for one in plan.catches)
    moves, until = (gripped(plan), plan.trajectory.duration) if grips else (plan.trajectory, 0.0)
    whole, most = braked(moves, np.array(limits)), len(plan.catches)
    plant = (GrippingPlant if grips else PhysicalPlant)(
        situation, chosen, controller or Controller(), believed=believed, most=most,
        until=until + 2.0 * STEP * grips,
    )  # fmt: skip
    plant.follow(whole, max(situation.horizon, until + STEP * grips))
    ended = _ended(plant)
    if plant.outcome == CAUGHT:
        after = whole.duration - moves.duration
        plant.follow(whole, max(ended * STEP, until) + STAYS + after)
    return _report(plan, whole, plant, ended)


def execute_seen(
    mind: Mind,
    situation: Situation[Any],
    loop: Loop,
    seed: int,
    *,
    name: str = "",
    body: AnyArmBody | str | Path | None = None,
    controller: Controller | None = None,
    kinematic: bool = False,
) -> Execution:
    """Let an agent act that sees the world inexactly, and goes on thinking while the arm moves.

    Parameters
    ----------
    mind : Mind
    situation : Situation
        The world as it is.
    loop : Loop
    seed : int
        Of the errors of perception.
    name : str
        Of the agent.
    body, controller
        As for `execute`.
    kinematic : bool
        Whether the arm does at once what it is told, and has no mass.

    Raises
    ------
    PhysicsError
        If the body does not fit, or the physics fails.
    """
    if kinematic:
        exact = ExactPlant(situation)
        course = run_closed_loop(mind, exact, situation, loop, seed)
        return Execution(
            situation.name, name, STATUS.get(course.outcome, "late"), catch_time=exact.catch_time,
            catches=tuple(exact.catches), several=several_in(situation),
        )  # fmt: skip
    chosen = body_for(situation.arm, body)
    more = [t.hold.seconds + CARRY * (t.place is not None) for t in situation.targets if t.hold]
    plant = (GrippingPlant if more else PhysicalPlant)(
        situation, chosen, controller or Controller(), until=situation.horizon + sum(more)
    )
    run_closed_loop(mind, plant, situation, loop, seed)
    return _seen(plant, name, _ended(plant))


def _exactly(plan: Plan, situation: Situation[Any]) -> Execution:
    if plan.trajectory is None:
        several = several_in(situation)
        return Execution(situation.name, plan.planner, "no plan", plan.message, several=several)
    exact = ExactPlant(situation, len(plan.catches))
    exact.follow(begun(situation.arm, plan.trajectory, 0.0), situation.horizon)
    return Execution(
        situation.name, plan.planner, STATUS.get(exact.outcome, "late"),
        planned=plan.catch_time, catch_time=exact.catch_time, plan=plan.trajectory,
        catches=tuple(exact.catches), several=several_in(situation),
    )  # fmt: skip


def several_in(situation: Situation[Any]) -> tuple[str, ...]:
    """Return the names of all targets, if a situation asks for several catches."""
    several = () if situation.catch == "any" else situation.targets
    return tuple(target.name for target in several)


def _ended(plant: PhysicalPlant) -> int:
    """Return the step of the catch, with a gripper of its end; without a catch the last step."""
    if isinstance(plant, GrippingPlant) and plant.catch_time is not None:
        return plant.over
    return plant.steps if plant.catch_time is None else round(plant.catch_time / STEP)


def _seen(plant: PhysicalPlant, planner: str, ended: int) -> Execution:
    """Return the measures of any movement."""
    weakest = np.maximum(plant.strongest, FAINT)
    used = np.abs(plant.torques_log[: max(ended, 1)]) / weakest
    return Execution(
        plant.situation.name,
        planner,
        STATUS.get(plant.outcome, "late"),
        body=plant.body.name,
        catch_time=plant.catch_time,
        catch_body=plant.catch_body,
        contact=plant.contact,
        torque=float(used.max()),
        plant=plant,
        catches=tuple(plant.catches),
        several=several_in(plant.situation),
        grip=plant.gripped if isinstance(plant, GrippingPlant) else None,
    )


def _report(plan: Plan, whole: Movement, plant: PhysicalPlant, ended: int) -> Execution:
    """Return the measures of a movement that followed a plan."""
    out = replace(
        _seen(plant, plan.planner, ended),
        planned=plan.catch_time,
        error=_errors(whole, plant, np.arange(ended + 1)),
        plan=whole,
    )
    if plant.catch_time is None:
        return out
    stayed = ended == plant.ended and not (out.grip and out.grip.opened)
    return replace(
        out,
        stays=plant.holds(str(plant.catch_body), ended, ended + round(STAYS / STEP))
        if stayed
        else None,
        braked=_rested(plant, ended),
        braked_into=plant.later_contact,
    )


def _errors(plan: Movement, plant: PhysicalPlant, steps: np.ndarray) -> tuple[float, float, float]:
    there = Movement(plan.arm, steps * STEP, plant.joints_log[steps]).hand
    wanted = Movement(plan.arm, steps * STEP, plan.states_at(steps * STEP)[0]).hand
    off = np.linalg.norm(there - wanted, axis=1) * plant.body.metres
    return float(np.median(off)), float(off.max()), float(off[-1])


def _rested(plant: PhysicalPlant, since: int) -> float | None:
    """Return the time after a step from which the arm rests [s]."""
    moving = np.abs(plant.rates_log[since : plant.steps + 1]).max(axis=1) > AT_REST
    if moving[-1]:
        return None
    return float(np.flatnonzero(moving)[-1] + 1) * STEP if moving.any() else 0.0


def as_touch(situation: Situation[Any]) -> Situation[Any]:
    """Return a situation without holds and places, in which a touch ends the movement."""
    loose: Any = {"hold": None, "place": None, "ignore": (), "ignore_for": None}
    bodies = tuple(replace(b, **loose) if b.role == "target" else b for b in situation.bodies)
    return replace(situation, bodies=bodies, end="free")


def execution_to_json(done: Execution) -> dict[str, Any]:
    """Return the report as ``gcm-learn/execution@1``; fields that do not apply are null.

    Situations that ask for several catches have the field ``catches`` as well.
    """
    error = done.error or (None, None, None)
    grip, touch = (of.grip._asdict() if of and of.grip else {} for of in (done, done.touch))
    caught = [catch._asdict() for catch in done.catches]
    return {
        "format": FORMAT,
        "name": done.name,
        "planner": done.planner,
        "status": done.status,
        "message": done.message,
        "body": done.body,
        "limits": None if done.limits is None else list(done.limits),
        "planned_catch_time": done.planned,
        "catch_time": done.catch_time,
        "catch_body": done.catch_body,
        **({"catches": caught} if done.several else {}),
        "contact": _contact(done.contact),
        "error_median": error[0],
        "error_max": error[1],
        "error_at_end": error[2],
        "torque": done.torque,
        "stays": done.stays,
        "held_until": grip.get("closed"),
        "impulse": grip.get("impulse"),
        "impact_torque": grip.get("torque"),
        "touch_impulse": touch.get("impulse"),
        "touch_impact_torque": touch.get("torque"),
        "placed": grip.get("opened"),
        "off_place": grip.get("off_place"),
        "braked": done.braked,
        "braked_into": _contact(done.braked_into),
    }


def _contact(contact: Contact | None) -> dict[str, Any] | None:
    return None if contact is None else {"name": contact.name, "time": contact.time}


def tube_about(plan: Plan, situation: Situation[Any], body: AnyArmBody) -> Tube:
    """Return the tube in which the limb of an arm stays that follows a plan, in the arm's unit."""
    done = execute(plan, situation, body)
    moves, plan_moves = done.movement, done.plan or done.movement
    both = moves.joints, plan_moves.joints_at(moves.time)
    there, wanted = (MECHANICS.of(situation.arm).points(situation.arm, joints) for joints in both)
    return Tube(float(np.linalg.norm(there - wanted, axis=2).max()))
