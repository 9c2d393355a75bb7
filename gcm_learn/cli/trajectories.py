"""Trajectories of plans as files for robots and tables."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Literal

from gcm_learn.cli.failures import one_line
from gcm_learn.cli.files import FileNames, made_folder, output

if TYPE_CHECKING:
    from gcm_learn.motion import Movement
    from gcm_learn.planners import Plan
    from gcm_learn.situation import AnySituation

Form = Literal["ros2", "csv"]
SUFFIXES: dict[Form, str] = {"ros2": ".yaml", "csv": ".csv"}


class Trajectories:
    """Writer of one file for each catch.

    Parameters
    ----------
    folder : Path
        Made when it is missing.
    form : {"ros2", "csv"}
    stop : bool
        If true, movements end at rest; one without a verified stop is not written.
    """

    def __init__(self, folder: Path, form: Form, *, stop: bool) -> None:
        self._folder = made_folder(folder, option="--trajectories")
        self._form, self._stop, self._names = form, stop, FileNames()
        self.refused = 0
        """Number of catches without a file."""

    def write(self, situation: AnySituation, plan: Plan) -> None:
        """Write the trajectory of a catch, or say in one line why not."""
        from gcm_learn.errors import StopError
        from gcm_learn.motion import with_stop

        if plan.trajectory is None:
            return
        name = self._names.unused(situation.name)
        try:
            moves = with_stop(situation, plan.trajectory) if self._stop else plan.trajectory
        except StopError as error:
            self.refused += 1
            print(one_line(f"gcm-learn: {error}; see --no-stop"), file=sys.stderr)
            return
        with output(self._folder / f"{name}{SUFFIXES[self._form]}") as stream:
            stream.write(_text(self._form, moves))


def _text(form: Form, moves: Movement) -> str:
    from gcm_learn.motion import to_csv, to_joint_trajectory, to_yaml

    return to_csv(moves) if form == "csv" else to_yaml(to_joint_trajectory(moves))
