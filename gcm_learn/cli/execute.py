"""``gcm-learn execute``: plans carried out by an arm with mass."""

from __future__ import annotations

import contextlib
import json
import math
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, NamedTuple

from tyro.conf import Positional, arg

from gcm_learn.cli.failures import CommandFailure, one_line
from gcm_learn.cli.files import FileNames, made_folder, output, staged
from gcm_learn.cli.solve import plan_one, read

if TYPE_CHECKING:
    from gcm_learn.arms import Kind, SpatialArm
    from gcm_learn.execution import Execution, Mind
    from gcm_learn.situation import AnyArmBody, Situation

    Spatial = Situation[SpatialArm]
    Draw = Callable[[Spatial, Execution], None]

NO_BODY = "no body"
"""Status of a situation that cannot be executed; others go on."""
MILLI = 1e3  # [1/1000]
EXACT_LOOKS = 2  # after which a policy acts whose eyes are exact: they tell accelerations


class Who(NamedTuple):
    """A planner or a policy."""

    name: str
    takes: Callable[[Kind], bool]
    planner: Any
    """Absent for a policy."""
    mind: Mind | None
    """Mind of the closed loop; absent where everything is known and planned once."""


@dataclass(frozen=True)
class Execute:
    """Plan for the arms in space of a file, and let arms with mass and motors follow the plans.

    A line tells what came of each. Arms without limits of acceleration get those of their motors.
    """

    file: Annotated[Positional[str], arg(metavar="FILE")]
    """situations with spatial arms: a .json or .jsonl file, or - for standard input"""

    body: Annotated[
        str | None, arg(metavar="FILE", help_behavior_hint="(default: the shipped one that fits)")
    ] = None
    """masses and motors: a file of format gcm-learn/body@1, or `nao` or `human`"""

    planner: Annotated[str, arg(metavar="NAME")] = "layered"
    """who plans, or a trained actor by its folder in models/: it acts anew in every period, by what
    is seen 50 times a second; or your own, as solve takes them; an unknown name lists all"""

    plant: Literal["mujoco", "kinematic"] = "mujoco"
    """plant of the plans: physics, or an arm without mass that follows at once"""

    noise: Annotated[float, arg(metavar="S", help_behavior_hint="(default: all is known)")] = 0.0
    """standard deviation of the places that are seen, 50 times a second [m]; the arm plans again
    while it moves"""

    replan: Literal["once", "broken", "always"] = "broken"
    """with --noise: when plans are made; `broken` is when the present plan fails"""

    seed: int = 0
    """of the noise"""

    out: Annotated[
        Path | None, arg(metavar="FILE", help_behavior_hint="(default: lines for people only)")
    ] = None
    """where reports go as JSON, one a line; - is standard output, in place of lines for people"""

    film: Annotated[Path | None, arg(metavar="DIR", help_behavior_hint="(default: no films)")] = (
        None
    )
    """folder for one animated GIF of each movement"""

    def run(self) -> int:
        """Execute the file; 1 if the physics of any situation failed, 2 if no arm has a body."""
        from gcm_learn.execution import execution_to_json, read_body
        from gcm_learn.situation import spatial

        if not 0.0 <= self.noise < 1e6:
            raise CommandFailure(f"--noise {self.noise:g}: must be from 0 on")
        if self.film is not None and self.plant != "mujoco":
            raise CommandFailure("--film: is of arms with mass; animate shows plans")
        who: Any = self._who()
        situations = [spatial(item, "execute") for item in read(self.file, who)]
        body = None if self.body is None else read_body(self.body)
        draw = None if self.film is None else _films(made_folder(self.film, option="--film"))
        piped = self.out is not None and str(self.out) == "-"
        counts: Counter[str] = Counter()
        with contextlib.ExitStack() as stack:
            stream = None if self.out is None else stack.enter_context(output(self.out))
            for situation in situations:
                done = self._executed(who, situation, body)
                counts[done.status] += 1
                if not piped:
                    print(told(done), flush=True)
                if stream is not None:
                    stream.write(json.dumps(execution_to_json(done), allow_nan=False) + "\n")
                if draw is not None and done.plant is not None:
                    draw(situation, done)
        if not piped and len(situations) > 1:
            print(", ".join(f"{count} {status}" for status, count in counts.most_common()))
        if counts[NO_BODY] == len(situations):
            raise CommandFailure(f"{self.file}: no body fits any of the arms; see --body")
        return 1 if counts["failed"] else 0

    def _who(self) -> Who:
        """Return the planner or policy of a name."""
        from gcm_learn.errors import ArmKindError, PolicyError
        from gcm_learn.evaluation import ActorMethod, get_method
        from gcm_learn.execution import Planning

        method: Any = get_method(self.planner)
        if not isinstance(method, ActorMethod):
            mind = Planning(method.planner, self.replan) if self.noise else None
            return Who(method.planner.name, method.takes, method.planner, mind)
        if self.replan == "once":
            raise CommandFailure("--replan once: a policy acts anew in every period")
        try:
            return Who(method.name, method.takes, None, method.actor.mind())
        except (ArmKindError, PolicyError) as error:
            raise CommandFailure(f"--planner {self.planner}: {error}") from None

    def _executed(self, who: Who, situation: Spatial, body: AnyArmBody | None) -> Execution:
        """Execute a situation; a failure of physics becomes a status."""
        from gcm_learn.errors import BodyError, PhysicsError
        from gcm_learn.execution import Execution, body_for, with_motor_limits

        try:
            chosen = body_for(situation.arm, body)
            limited = with_motor_limits(situation, chosen)
            done = self._followed(who, limited, chosen)
        except PhysicsError as error:
            status = NO_BODY if isinstance(error, BodyError) else "failed"
            return Execution(situation.name, who.name, status, message=one_line(str(error)))
        if limited is situation:
            return done
        most = limited.arm.max_joint_acceleration
        return replace(done, limits=most, body=chosen.name)

    def _followed(self, who: Who, situation: Spatial, body: AnyArmBody) -> Execution:
        """Execute a situation under limits of acceleration."""
        from gcm_learn.execution import Loop, Perception, execute, execute_seen

        exact = self.plant == "kinematic"
        if who.mind is None:
            plan: Any = plan_one(who.planner, situation, self.file)
            return execute(plan, situation, body, kinematic=exact)
        forearm = body.metres * math.hypot(*situation.arm.forearm)
        looks = {} if self.noise else {"looks": EXACT_LOOKS}
        loop = Loop(Perception(self.noise / forearm), **looks)
        return execute_seen(
            who.mind, situation, loop, self.seed, name=who.name, body=body, kinematic=exact
        )


def told(done: Execution) -> str:
    """A line for people."""
    parts = [f"{done.name or 'situation'}: {_outcome(done)}"]
    if done.error is not None:
        median, most, end = (MILLI * error for error in done.error)
        parts.append(f"off by {median:.1f} mm (most {most:.1f}, at the end {end:.1f})")
    if done.torque is not None:
        parts.append(f"torque up to {100 * done.torque:.0f} %")
    if done.stays is not None:
        braked = (
            "not at rest after" if done.braked is None else f"at rest after {done.braked:.2f} s"
        )
        parts.append(f"{braked}, the target {'stays' if done.stays else 'bounces off'}")
    if done.braked_into is not None:
        parts.append(f"touches {done.braked_into.name!r} while it brakes")
    if done.limits is not None:
        limits = ", ".join(f"{limit:.3g}" for limit in done.limits)
        parts.append(f"accelerations up to {limits} rad/s^2 from the motors of {done.body!r}")
    return "; ".join(parts)


def _outcome(done: Execution) -> str:
    if done.status == "caught":
        what = "" if done.catch_body is None else f" {done.catch_body!r}"
        planned = "" if done.planned is None else f" (planned {done.planned:.3f} s)"
        return f"caught{what} at {done.catch_time:.3f} s{planned}"
    if done.contact is not None:
        return f"collided with {done.contact.name!r} at {done.contact.time:.3f} s"
    return f"{done.status}{': ' if done.message else ''}{done.message}"


def _films(folder: Path) -> Draw:
    """A function that writes the film of a movement into `folder`."""
    from gcm_learn import plots

    names = FileNames()

    def draw(situation: Spatial, done: Execution) -> None:
        with staged(folder / f"{names.unused(situation.name)}.gif", option="--film") as place:
            plots.animate_execution(situation, done, place)

    return draw
