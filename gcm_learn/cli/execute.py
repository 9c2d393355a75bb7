"""``gcm-learn execute``: plans carried out by an arm with mass."""

from __future__ import annotations

import contextlib
import json
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, NamedTuple

from tyro.conf import Positional, arg

from gcm_learn.cli.failures import CommandFailure, one_line
from gcm_learn.cli.files import drawn_into, output, refuse_missing
from gcm_learn.cli.options import Number, given, ranged
from gcm_learn.cli.solve import plan_one, read

if TYPE_CHECKING:
    from gcm_learn.arms import Kind
    from gcm_learn.execution import Execution, Mind
    from gcm_learn.planners import Plan
    from gcm_learn.situation import AnyArmBody, Situation

    Bodied = Situation[Any]

LATENCY = ranged(lambda text: 1e-3 * float(text.removesuffix("ms")), "MS", 0, above=False)
NOISE = ranged(float, "METRES", 0, above=False)
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
    """Plan for the spatial arms and chains of a file, and let arms with mass follow the plans.

    One line reports each outcome. The motors set limits of acceleration where a situation has none.
    """

    file: Annotated[Positional[str], arg(metavar="FILE")]
    """situations with spatial arms or chains: a .json or .jsonl file, or - for standard input"""

    body: Annotated[str | None, given("FILE", "the shipped one that fits")] = None
    """masses and motors: a file of format gcm-learn/body@1 or gcm-learn/body@2, see gcm-learn arm
    --body, or the name of a shipped one: `nao`, `human`, `panda`, `iiwa14` or `ur5`"""

    planner: Annotated[str | None, given("NAME", "search")] = None
    """who plans, or a trained actor by its folder in models/: it acts anew in every period, by what
    is seen 50 times a second; or your own, as solve takes them; an unknown name lists all"""

    plant: Literal["mujoco", "kinematic"] = "mujoco"
    """plant of the plans: physics, or an arm without mass that follows at once"""

    noise: Annotated[float, NOISE, given("METRES", "all is known")] = 0.0
    """standard deviation of the places that are seen, 50 times a second; the arm plans again while
    it moves"""

    tube: bool = True
    """plan again with room for the error with which the arm follows its first plan; --no-tube
    follows the first plan; with --noise or --latency there is none"""

    latency: Annotated[float | None, LATENCY, given("MS", "everything is known")] = None
    """milliseconds by which percepts and commands come late, 0 too; the world is seen 50 times a
    second, exactly without --noise, and the arm plans while it moves"""

    replan: Literal["once", "broken", "always"] = "broken"
    """with --noise or --latency: when plans are made; `broken` is when the present plan fails"""

    seed: Number = 0
    """of the noise"""

    out: Annotated[Path | None, given("FILE", "lines for people only")] = None
    """where reports go as JSON, one a line; - is standard output, in place of lines for people"""

    film: Annotated[Path | None, given("DIR", "no films")] = None
    """folder for one animated GIF of each movement"""

    def run(self) -> int:
        """Execute the file; 1 if the physics of any situation failed, 2 if no arm has a body."""
        refuse_missing(self.file)
        from gcm_learn.execution import execution_to_json, read_body

        if self.film is not None and self.plant != "mujoco":
            raise CommandFailure("--film: is of arms with mass; solve --film shows plans")
        asked = self._asked()
        body = None if self.body is None else read_body(self.body)
        draw = None
        if self.film is not None:
            draw = drawn_into(self.film, "gif", _filmed, option="--film")
        piped = self.out is not None and str(self.out) == "-"
        counts: Counter[str] = Counter()
        with contextlib.ExitStack() as stack:
            stream = None if self.out is None else stack.enter_context(output(self.out))
            for situation, who in asked:
                done = self._executed(who, situation, body)
                counts[done.status] += 1
                if not piped:
                    print(told(done), flush=True)
                if stream is not None:
                    stream.write(json.dumps(execution_to_json(done), allow_nan=False) + "\n")
                if draw is not None and done.plant is not None:
                    draw(situation, done)
        if not piped and len(asked) > 1:
            print(", ".join(f"{count} {status}" for status, count in counts.most_common()))
        if counts[NO_BODY] == len(asked):
            raise CommandFailure(f"{self.file}: no body fits any of the arms; see --body")
        return 1 if counts["failed"] else 0

    def _asked(self) -> list[tuple[Bodied, Who]]:
        """Return each situation of the file with its planner or policy."""
        from gcm_learn.planners import check_name

        check_name(self.planner or "search")
        from gcm_learn.arms import kind_of
        from gcm_learn.execution import MECHANICS
        from gcm_learn.planners import taken

        chosen = {} if self.planner is None else {self.planner: self._who(self.planner)}
        asked: list[tuple[Bodied, Who]] = []
        for situation in read(self.file):
            kind = kind_of(situation)
            if not MECHANICS.takes(kind):
                text = f"{situation.name!r} has a {kind.name} arm, which has no mass; spatial arms"
                raise CommandFailure(f"{self.file}: {text} and chains are executed")
            name = self.planner or "search"
            if name not in chosen:
                chosen[name] = self._who(name)
            who: Any = chosen[name]
            asked.append((taken(who, situation), who))
        return asked

    def _who(self, name: str) -> Who:
        """Return the planner or policy of a name."""
        from gcm_learn.errors import ArmKindError, PolicyError
        from gcm_learn.evaluation import ActorMethod, get_method
        from gcm_learn.execution import Planning
        from gcm_learn.planners import takes

        method: Any = get_method(name)
        if not isinstance(method, ActorMethod):
            seen = self.noise or self.latency is not None
            mind = Planning(method.planner, self.replan) if seen else None
            taking = partial(takes, method.planner)
            return Who(method.planner.name, taking, method.planner, mind)
        if self.replan == "once":
            raise CommandFailure("--replan once: a policy acts anew in every period")
        try:
            return Who(method.name, method.takes, None, method.actor.mind())
        except (ArmKindError, PolicyError) as error:
            raise CommandFailure(f"--planner {name}: {error}") from None

    def _executed(self, who: Who, situation: Bodied, body: AnyArmBody | None) -> Execution:
        """Execute a situation; a failure of physics becomes a status."""
        from gcm_learn.errors import BodyError, PhysicsError
        from gcm_learn.execution import Execution, body_for, several_in, with_motor_limits

        try:
            chosen = body_for(situation.arm, body)
            limited = with_motor_limits(situation, chosen)
            done = self._followed(who, limited, chosen)
        except PhysicsError as error:
            status = NO_BODY if isinstance(error, BodyError) else "failed"
            why, several = one_line(str(error)), several_in(situation)
            return Execution(situation.name, who.name, status, why, several=several)
        if limited is situation:
            return done
        most = limited.arm.max_joint_acceleration
        return replace(done, limits=most, body=chosen.name)

    def _followed(self, who: Who, situation: Bodied, body: AnyArmBody) -> Execution:
        """Execute a situation under limits of acceleration."""
        from gcm_learn.execution import Loop, Perception, execute_seen, forearm_of

        exact = self.plant == "kinematic"
        if who.mind is None:
            return self._known(who, situation, body)
        forearm = body.metres * forearm_of(situation.arm)
        looks = {} if self.noise else {"looks": EXACT_LOOKS}
        late = self.latency or 0.0
        loop = Loop(Perception(self.noise / forearm, latency=late), latency=late, **looks)
        return execute_seen(
            who.mind, situation, loop, self.seed, name=who.name, body=body, kinematic=exact
        )

    def _known(self, who: Who, situation: Bodied, body: AnyArmBody) -> Execution:
        """Execute a plan for a known world; beside a hold also a plain touch."""
        from gcm_learn.execution import as_touch, execute

        exact = self.plant == "kinematic"
        done = execute(self._planned(who, situation, body), situation, body, kinematic=exact)
        if done.grip is None:
            return done
        touch = as_touch(situation)
        other = execute(self._planned(who, touch, body), touch, body, grips=True)
        return replace(done, touch=other)

    def _planned(self, who: Who, situation: Bodied, body: AnyArmBody) -> Plan:
        """Plan in the tube in which the arm follows a first plan."""
        from gcm_learn.execution import tube_about
        from gcm_learn.planners import InTube, as_ours

        plan = plan_one(who.planner, situation, self.file)
        if not self.tube or plan.trajectory is None or self.plant == "kinematic":
            return plan
        planner = as_ours(InTube(who.planner, tube_about(plan, situation, body)))
        return plan_one(planner, situation, self.file)


def told(done: Execution) -> str:
    """A line for people."""
    parts = [f"{done.name or 'situation'}: {_outcome(done)}"]
    if done.error is not None:
        median, most, end = (MILLI * error for error in done.error)
        parts.append(f"off by {median:.1f} mm (most {most:.1f}, at the end {end:.1f})")
    if done.torque is not None:
        parts.append(f"torque up to {100 * done.torque:.0f} %")
    if done.grip is not None:
        parts.append(f"gripped at {done.grip.closed:.3f} s{_blow(done)}")
    if done.touch is not None:
        parts.append("a touch" + (_blow(done.touch) or " fails"))
    if done.grip is not None and done.grip.off_place is not None:
        away = f"{MILLI * done.grip.off_place:.1f} mm from its place"
        parts.append(f"put down at {done.grip.opened:.3f} s, {away}")
    if done.braked is not None or done.stays is not None:
        parts.append(
            "not at rest after" if done.braked is None else f"at rest after {done.braked:.2f} s"
        )
    if done.stays is not None:
        parts[-1] += f", the target {'stays' if done.stays else 'bounces off'}"
    if done.braked_into is not None:
        parts.append(f"touches {done.braked_into.name!r} while it brakes")
    if done.limits is not None:
        limits = ", ".join(f"{limit:.3g}" for limit in done.limits)
        parts.append(f"accelerations up to {limits} rad/s^2 from the motors of {done.body!r}")
    return "; ".join(parts)


def _blow(done: Execution) -> str:
    if done.grip is None or done.grip.impulse is None:
        return ""
    torque = f"{done.grip.torque:.2g} N m at a joint"
    return f" with {MILLI * done.grip.impulse:.3g} mN s and {torque}"


def _outcome(done: Execution) -> str:
    planned = "" if done.planned is None else f" (planned {done.planned:.3f} s)"
    if done.status == "caught" and not done.several:
        what = "" if done.catch_body is None else f" {done.catch_body!r}"
        return f"caught{what} at {done.catch_time:.3f} s{planned}"
    if done.contact is not None:
        outcome = f"collided with {done.contact.name!r} at {done.contact.time:.3f} s"
    else:
        outcome = f"{done.status}{': ' if done.message else ''}{done.message}"
    if not done.several or done.status == "no plan":
        return outcome
    return f"{outcome}: {_caught_of(done)}{planned}"


def _caught_of(done: Execution) -> str:
    """Say which of several targets were caught."""
    events = ", ".join(f"{catch.body!r} at {catch.time:.3f} s" for catch in done.catches)
    return f"{len(done.catches)} of {len(done.several)} targets" + (f", {events}" if events else "")


def _filmed(situation: Bodied, done: Execution, place: Path) -> None:
    from gcm_learn import plots

    plots.animate_execution(situation, done, place)
