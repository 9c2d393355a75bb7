"""``gcm-learn solve``: situations in, solutions out."""

from __future__ import annotations

import contextlib
import json
import sys
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, TextIO

from tyro.conf import Positional, arg

from gcm_learn.cli import files
from gcm_learn.cli.failures import CommandFailure, one_line, place_of
from gcm_learn.cli.options import FROM_NOTHING, RATE, WHOLE, Output, given
from gcm_learn.cli.progress import Progress
from gcm_learn.errors import GcmError, SituationError

if TYPE_CHECKING:
    from gcm_learn.motion import Movement
    from gcm_learn.planners import Plan, Planner
    from gcm_learn.situation import AnySituation

    Draw = Callable[[AnySituation, Plan], None]

Form = Literal["ros2", "csv"]
SUFFIXES: dict[Form, str] = {"ros2": ".yaml", "csv": ".csv"}


@dataclass(frozen=True)
class Solve:
    """Plan a catch for every situation of a file; write one solution a line, in input order.

    The whole file is checked before anything is planned.
    """

    file: Annotated[Positional[str], arg(metavar="FILE")]
    """situations: a .json or .jsonl file, or - for standard input"""

    planner: Annotated[str, arg(metavar="NAME")] = "search"
    """who plans: a name, an actor as clone@20, or your own: module:name, path.py:name, model.zip;
    an unknown name lists all"""

    memory: Annotated[Path | None, given("DIR", "its own")] = None
    """folder of a memory, see gcm-learn memory make, for a planner that recalls; of a cover, see
    gcm-learn cover, for the planner covered"""

    deadline: Annotated[float | None, FROM_NOTHING, given("TIME", "the first catch")] = None
    """processor time for each situation, such as 20ms; the planner answers with the best catch that
    it has then, late by a few ms at most"""

    index: Annotated[int | None, WHOLE, given("N", "all")] = None
    """only this situation of the file, counted from 0"""

    end: Literal["given", "free", "rest"] = "given"
    """how movements end, if not as the file says: rest asks for a stop, which takes limits of
    acceleration"""

    out: Output = None
    """where the solutions go"""

    plot: Annotated[Path | None, given("DIR", "no pictures")] = None
    """folder for one PNG picture per situation"""

    film: Annotated[Path | None, given("FILE", "no film")] = None
    """film of one situation's movement, a .gif file; of a spatial arm or a chain also an .html page
    on which it is turned (plotly, extra `plots`)"""

    trajectories: Annotated[Path | None, given("DIR", "no files")] = None
    """folder for one file per catch, each of a movement that ends at rest: under limits of
    acceleration planned so, else with a verified stop after the catch"""

    form: Annotated[Literal["ros2", "csv"], arg(name="as")] = "ros2"
    """of --trajectories: ROS 2 trajectory_msgs/JointTrajectory in YAML, or CSV"""

    rate: Annotated[float | None, RATE, given("HZ", "the samples of the plan")] = None
    """of --trajectories: even samples a second, 125 to 1000, and the last instant"""

    stop: bool = True
    """of --trajectories: end at rest; --no-stop writes the movements of the answers"""

    def run(self) -> int:
        """Solve the file; see `gcm_learn.cli.main` for the exit codes."""
        planner = self._planner()
        if self.deadline is not None and not getattr(planner, "anytime", False):
            raise CommandFailure(f"--deadline: planner {planner.name!r} takes no deadline")
        situations = _ended(read(self.file, planner, self.index), self.end, self.file)
        files.refuse_same({"FILE": Path(self.file), "--out": self.out, "--film": self.film})
        with contextlib.ExitStack() as stack:
            draws: list[Draw] = []
            if self.plot is not None:
                draws.append(files.drawn_into(self.plot, "png", _picture, option="--plot"))
            if self.film is not None:
                draws.append(_film(self.film, situations, stack))
            written = None
            if self.trajectories is not None:
                again = partial(plan_one, planner, file=self.file, deadline=self.deadline)
                stops = again if self.stop else None
                written = Trajectories(self.trajectories, self.form, self.rate, stops)
                draws.append(written.write)
            stream = stack.enter_context(files.output(self.out))
            _solve_all(self, situations, planner, stream, draws)
        return 1 if written is not None and written.refused else 0

    def _planner(self) -> Planner:
        """Return the planner, with the given memory."""
        from gcm_learn.planners import check_name

        check_name(self.planner)
        from gcm_learn.planners import get_planner

        if self.memory is None:
            return get_planner(self.planner)
        from gcm_learn.cover import NAME, with_cover

        if self.planner == NAME:
            return with_cover(self.memory)
        from gcm_learn.recall import Memory, with_memory

        return with_memory(self.planner, Memory.load(self.memory))


def read(file: str, planner: Planner | None = None, index: int | None = None) -> list[AnySituation]:
    """Return all situations of a file or of standard input (``-``), or only the one at `index`.

    Raises
    ------
    GcmError
        In one line: a situation is refused, or `planner` does not take it.
    """
    from gcm_learn.planners import taken
    from gcm_learn.situation import read_situations

    if file == "-" and sys.stdin is None:
        raise CommandFailure("standard input is closed")
    if planner is None:
        return read_situations(file)
    found = read_situations(file, None if index is not None else partial(_refuse_limits, planner))
    if index is not None:
        if index >= len(found):
            held = f"{file} holds {len(found)} situations, counted from 0"
            raise CommandFailure(f"--index {index}: {held}")
        found = [found[index]]
    return [taken(planner, situation) for situation in found]


def _ended(situations: list[AnySituation], end: str, file: str) -> list[AnySituation]:
    """Return the situations, which end at rest or freely if `end` says so."""
    from gcm_learn.situation import ENDS, with_end

    if end not in ENDS:
        return situations
    try:
        return [with_end(situation, end) for situation in situations]
    except SituationError as error:
        raise CommandFailure(f"{file}: {error}") from error


def _refuse_limits(planner: Planner, situation: AnySituation) -> None:
    """Refuse an arm whose limits of acceleration a planner cannot keep."""
    from gcm_learn.arms import kind_of
    from gcm_learn.motion import Failure
    from gcm_learn.planners import keeps_limits, takes

    if takes(planner, kind_of(situation)) and not keeps_limits(planner, situation):
        reason = f"{Failure.ACCELERATION_UNTAKEN.value}; search, recall and hybrid keep them"
        raise SituationError("arm", reason)


def plan_one(
    planner: Planner, situation: AnySituation, file: str, deadline: float | None = None
) -> Plan:
    """Plan for one situation; any error ends the command and names the situation.

    A planner has a status for everything it cannot solve, so an exception is a defect, and a
    made-up solution in its place would be a false statement.
    """
    from gcm_learn.planners import plan_with

    try:
        _refuse_limits(planner, situation)  # `execute` adds those of the motors
        return plan_with(planner, situation, deadline)
    except GcmError as error:
        raise CommandFailure(f"{file}: situation {situation.name!r}: {error}") from error
    except Exception as error:
        message = f"{file}: situation {situation.name!r}: {place_of(error)}"
        raise CommandFailure(message, exit_code=1) from error


def _solve_all(
    asked: Solve,
    situations: list[AnySituation],
    planner: Planner,
    stream: TextIO,
    draws: list[Draw],
) -> None:
    file = asked.file
    scrolling = stream.isatty()  # the solutions themselves show how far it has come
    with Progress(len(situations), "situations", quiet=scrolling) as progress:
        if situations:  # once for nothing: planning_ms is not to count the loading of kernels
            plan_one(planner, situations[0], file)
        for situation in situations:
            plan = plan_one(planner, situation, file, asked.deadline)
            stream.write(_line(plan, situation, file))
            stream.flush()
            for draw in draws:
                draw(situation, plan)
            progress.advance()


def _line(plan: Plan, situation: AnySituation, file: str) -> str:
    from gcm_learn.planners import plan_to_json

    try:
        return json.dumps(plan_to_json(plan, situation), allow_nan=False) + "\n"
    except ValueError as error:
        message = f"{file}: situation {situation.name!r}: the solution is not JSON: {error}"
        raise CommandFailure(message, exit_code=1) from error


def _picture(situation: AnySituation, plan: Plan, place: Path) -> None:
    from gcm_learn import plots

    plots.plan_figure(situation, plan).savefig(place)


def _film(target: Path, situations: list[AnySituation], stack: contextlib.ExitStack) -> Draw:
    """Return a function that films a plan; `target` appears when the stack ends."""
    if len(situations) != 1:
        raise CommandFailure(f"--film: shows one of the {len(situations)} situations, see --index")
    from gcm_learn.plots import DRAWN, animate, write_film_page

    files.require_suffix(target, DRAWN.of(situations[0]).films, "--film")
    show: Any = animate if target.suffix.lower() == ".gif" else write_film_page
    place = stack.enter_context(files.staged(target, option="--film"))
    return lambda situation, plan: show(situation, plan, place)


class Trajectories:
    """Writer of one file for each catch.

    Parameters
    ----------
    folder : Path
        Made when it is missing.
    form : {"ros2", "csv"}
    rate : float or None
        Even samples a second [Hz]; None for those of the movement.
    again : callable or None
        Plans a situation that asks for another end, so that movements end at rest; one that cannot
        is not written. None writes movements as they are.
    """

    def __init__(
        self,
        folder: Path,
        form: Form,
        rate: float | None,
        again: Callable[[AnySituation], Plan] | None,
    ) -> None:
        self._folder = files.made_folder(folder, option="--trajectories")
        self._form, self._rate, self._again = form, rate, again
        self._names = files.FileNames()
        self.refused = 0
        """Number of catches without a file."""

    def write(self, situation: AnySituation, plan: Plan) -> None:
        """Write the trajectory of a catch, or print in one line why it cannot end with a stop."""
        from gcm_learn.errors import StopError

        if plan.trajectory is None:
            return
        name = self._names.unused(situation.name)
        try:
            moves = self._moves(situation, plan)
        except StopError as error:
            self.refused += 1
            print(one_line(f"gcm-learn: {error}; see --no-stop"), file=sys.stderr)
            return
        with files.output(self._folder / f"{name}{SUFFIXES[self._form]}") as stream:
            stream.write(_text(self._form, moves, self._rate))

    def _moves(self, situation: AnySituation, plan: Plan) -> Movement:
        """Return the movement of a plan, of another that ends at rest, or with a stop."""
        from gcm_learn.motion import ends_at_rest, with_stop
        from gcm_learn.situation import with_end

        moves = plan.trajectory
        assert moves is not None
        if self._again is None or (moves.rates is not None and ends_at_rest(moves)):
            return moves
        with contextlib.suppress(SituationError):  # without limits of acceleration none ends so
            other = self._again(with_end(situation, "rest"))
            if other.trajectory is not None and len(other.catches) >= len(plan.catches):
                return other.trajectory
        return with_stop(situation, moves)


def _text(form: Form, moves: Movement, rate: float | None) -> str:
    from gcm_learn.motion import to_csv, to_joint_trajectory, to_yaml

    if form == "csv":
        return to_csv(moves, rate=rate)
    return to_yaml(to_joint_trajectory(moves, rate=rate))
