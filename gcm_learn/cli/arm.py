"""``gcm-learn arm``: arms that ship, and arms from files of robots."""

from __future__ import annotations

import contextlib
import json
import math
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from tyro.conf import Positional, UseAppendAction, arg

from gcm_learn.cli.failures import CommandFailure
from gcm_learn.cli.files import FORMATS, output, refuse_same, require_suffix, staged
from gcm_learn.cli.options import COUNT, Output, given

if TYPE_CHECKING:
    from gcm_learn.arms import ChainModel, Fitted, Robot

Numbers = tuple[float, ...]


@dataclass(frozen=True)
class Arm:
    """List the arms that ship, or make one of the joints between two links of a robot.

    Links are covered by capsules that hold their collision geometry. Pairs for self-collision are
    found by sampling postures. With --body the masses and motors go into a file for execute.
    """

    robot: Annotated[Positional[Path | None], given("FILE", "list the arms that ship")] = None
    """a URDF or MJCF file"""

    base: Annotated[str, given("LINK", "none, needed with FILE")] = ""
    """link that does not move; its frame is that of the arm's base"""

    tip: Annotated[str, given("LINK", "none, needed with FILE")] = ""
    """link that carries the hand"""

    point: Annotated[tuple[float, float, float], arg(metavar="X Y Z")] = (0.0, 0.0, 0.0)
    """the hand's place in the frame of the tip"""

    axis: Annotated[tuple[float, float, float], arg(metavar="X Y Z")] = (0.0, 0.0, 1.0)
    """direction in which the hand reaches, in the frame of the tip"""

    at: Annotated[UseAppendAction[tuple[str, ...]], given("JOINT=VALUE", "0; repeatable")] = ()
    """value at which a joint off the chain stands [rad or lengths]"""

    max_speed: Annotated[Numbers | None, given("V ...", "the file's")] = None
    """largest speeds of the joints [rad/s or lengths/s], one or all"""

    max_acceleration: Annotated[Numbers | None, given("A ...", "no limits")] = None
    """largest accelerations of the joints [rad/s^2 or lengths/s^2], one or all"""

    max_jerk: Annotated[Numbers | None, given("J ...", "no limits")] = None
    """with --max-acceleration: largest jerk of the joints [rad/s^3 or lengths/s^3], one or all"""

    torque: Annotated[Numbers | None, given("T ...", "the file's")] = None
    """with --body: largest torques of the motors [N m, or N of prismatic joints], one or all"""

    armature: Annotated[Numbers | None, given("J ...", "the file's; URDF: 0")] = None
    """with --body: inertias of the rotors as the joints feel them [kg m^2, or kg], one or all"""

    tool: Annotated[float | None, given("RADIUS", "no tool")] = None
    """radius of a tool, a capsule from the origin of the tip's frame to the hand's point"""

    capsules: Annotated[int | None, COUNT, given("N", "as many as help, 40 an arm")] = None
    """capsules that cover a link, at most"""

    packages: Annotated[
        UseAppendAction[tuple[Path, ...]], given("DIR", "folders above the file; repeatable")
    ] = ()
    """folder of packages, for package:// and model:// in the file"""

    visual: bool = False
    """let links without collision geometry have that of their looks"""

    name: Annotated[str | None, given("NAME", "the robot's")] = None
    """name of the arm"""

    source: str = ""
    """where the numbers come from, and their licence"""

    out: Output = None
    """where the arm goes"""

    body: Annotated[Path | None, given("FILE", "no body")] = None
    """where masses and motors go, in the format gcm-learn/body@2; lengths are metres"""

    plot: Annotated[Path | None, given("FILE", "no picture")] = None
    """picture of the arm and its capsules, as .png, .pdf or .svg"""

    def run(self) -> int:
        """List the shipped arms, or make an arm of a robot file, write it and print a report."""
        if self.robot is None:
            print("\n".join(shipped()))
            return 0
        from gcm_learn.arms import read_robot
        from gcm_learn.errors import RobotError, SituationError
        from gcm_learn.situation import arm_to_json

        self._check(self.robot)
        robot = read_robot(self.robot, self.packages, self.visual)
        try:
            fitted = self._fitted(robot)
            body = None if self.body is None else _body(fitted)
        except (RobotError, SituationError) as error:
            raise CommandFailure(f"{self.robot}: {error}") from None
        with contextlib.ExitStack() as stack:  # all files appear, or none
            stream = stack.enter_context(output(self.out))
            if self.body is not None:
                place = stack.enter_context(staged(self.body, option="--body"))
                place.write_text(json.dumps(body, indent=1) + "\n", "utf-8")
            if self.plot is not None:
                self._draw(fitted, stack.enter_context(staged(self.plot, option="--plot")))
            stream.write(json.dumps(arm_to_json(fitted.model), indent=1) + "\n")
        remarks = robot.remarks({joint.name for joint in fitted.model.joints})
        lines = [*report(fitted), *(f"  {remark}" for remark in remarks)]
        if self.tool is None:
            lines.append(
                f"  the hand is a point; --tool RADIUS covers the way to it from {self.tip}"
            )
        print("\n".join(lines), file=sys.stderr if self.out is None else sys.stdout)
        return 0

    def _check(self, robot: Path) -> None:
        if not self.base or not self.tip:
            raise CommandFailure("--base and --tip: are needed with FILE")
        if self.plot is not None:
            require_suffix(self.plot, FORMATS, "--plot")
        if self.body is None and (self.torque or self.armature):
            raise CommandFailure("--torque and --armature: are for --body")
        refuse_same({"FILE": robot, "--out": self.out, "--body": self.body, "--plot": self.plot})
        for folder in self.packages:
            if not folder.is_dir():
                raise CommandFailure(f"--packages {folder}: is no folder")
        for name, numbers in (("--point", self.point), ("--axis", self.axis)):
            if not all(map(math.isfinite, numbers)):
                raise CommandFailure(f"{name}: must be numbers")
        length = math.hypot(*self.axis)
        if abs(length - 1.0) > 1e-5:
            raise CommandFailure(f"--axis: must have length 1 (got {length:g})")

    def _fitted(self, robot: Robot) -> Fitted:
        from gcm_learn.arms import chain_of

        return chain_of(
            robot, self.base, self.tip,
            point=self.point, axis=self.axis, at=_values(self.at),
            max_speed=self.max_speed, max_acceleration=self.max_acceleration,
            max_jerk=self.max_jerk, torque=self.torque, armature=self.armature, tool=self.tool,
            capsules=self.capsules, name=self.name, source=self.source,
        )  # fmt: skip

    def _draw(self, fitted: Fitted, place: Path) -> None:
        from gcm_learn.plots import draw_arm

        parts = [[(h.centres, h.radii) for h in hulls] for hulls in fitted.parts]
        draw_arm(fitted.model, parts=parts).savefig(place)


def shipped() -> list[str]:
    """Return a line for each shipped arm, beginning with its name as a model in situations."""
    from gcm_learn.situation import arm_names, shipped_arm

    models = {name: shipped_arm(name) for name in arm_names()}
    width = max(map(len, models))
    return [
        f"{name:<{width}}  {counts(model)}; {model.source or 'no source'}"
        for name, model in models.items()
    ]


def counts(model: ChainModel) -> str:
    """Return how many joints, capsules and pairs a model has."""
    pairs, behind = len(model.self_collision), len(model.joints) - model.dof
    followers = f"{behind} that follow, " if behind else ""
    links = f"{len(model.links)} capsules, {pairs} pairs for self-collision"
    return f"{model.dof} joints, {followers}{links}"


def report(fitted: Fitted) -> list[str]:
    """Return lines on an arm for the user to check: capsules of its links, self-collisions."""
    lines = [f"{fitted.model.name}: {counts(fitted.model)}"]
    width = max(len(cover.link) for cover in fitted.covers)
    for cover in fitted.covers:
        carried = "the base" if cover.joint == 0 else f"joint {cover.joint}"
        many = f"{cover.capsules} capsule{'s' if cover.capsules > 1 else ''}"
        lines.append(
            f"  {cover.link:<{width}}  on {carried}, {many}, up to {cover.overhang:.3g} wider"
        )
    free = fitted.freedom
    lines.append(
        f"  free of self-collision in {free.capsules:.1%} of random postures; "
        f"in {free.parts:.1%} by the file's parts"
    )
    for clash in free.worst[:5]:
        pair = " and ".join(clash.links)
        lines.append(f"    {pair} overlap in {clash.capsules:.1%}; parts in {clash.parts:.1%}")
    return lines


def _body(fitted: Fitted) -> dict[str, Any]:
    """Return the JSON object of the robot's body."""
    from gcm_learn.execution import body_of_robot
    from gcm_learn.situation import arm_body_to_json

    return arm_body_to_json(body_of_robot(fitted))


def _values(given: Sequence[str]) -> dict[str, float]:
    """Return the values of joints off the chain, each given once."""
    values: dict[str, float] = {}
    for option in given:
        name, value = _value(option)
        if name in values:
            raise CommandFailure(f"--at {option}: joint {name!r} is given twice")
        values[name] = value
    return values


def _value(given: str) -> tuple[str, float]:
    """Return the joint and number of an option."""
    name, sign, value = given.rpartition("=")
    try:
        if not sign or not math.isfinite(float(value)):
            raise ValueError
    except ValueError:
        raise CommandFailure(f"--at {given}: must be JOINT=VALUE, with a number") from None
    return name, float(value)
