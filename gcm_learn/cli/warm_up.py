"""``gcm-learn warm-up``: compile kernels now that would otherwise be compiled at the first plan."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from importlib.util import find_spec
from pathlib import Path
from pkgutil import resolve_name
from typing import Annotated, Any

from tyro.conf import arg

from gcm_learn.cli.failures import CommandFailure, say
from gcm_learn.cli.options import AllCores, given
from gcm_learn.cli.progress import Progress
from gcm_learn.registration import ENTRIES

EXAMPLES = (
    ("crossing-swarm-space", 3, 5),
    ("crossing-swarm", 3, 5),
    ("throw-chain", 3, 1),
    ("panda-crowded-accelerated", 3, 0),
    ("space-sequences", 3, 0),
    ("panda-sequences", 3, 0),
    ("panda-belt", 3, 0),
    ("falling-space", 5, 0),
    ("panda-crowded", 5, 0),
    ("panda-crowded", 5, 3),
)
"""Families or presets, seeds and numbers of situations that together run what planners run."""
ARENAS = ("CatchArm-v0", "CatchArm3D-v0", "CatchChain-v0")
LASTS = "once: five to ten minutes on two cores; what is compiled is kept if you stop it"
Task = tuple[str, Any]
"""A planner and an example, or nothing and an arena."""


@dataclass(frozen=True)
class WarmUp:
    """Compile what planners and arenas run, for every kind of arm; later commands start at once."""

    planners: Annotated[str, arg(metavar="A,B")] = "search,straight,straight-wait,gcm,recall,hybrid"
    """names of planners"""

    workers: AllCores = None
    """processes that compile side by side"""

    wheel: Annotated[Path | None, given("DIR", "none")] = None
    """write a wheel there, with which others compile nothing"""

    processor: Annotated[str | None, given("NAME", "by this machine")] = None
    """for which the wheel is: x86-64-v3, apple-m1 or generic"""

    def run(self) -> int:
        """Let planners answer an example for each kind of arm, and step each arena."""
        from gcm_learn.compiled import on_first_compiling
        from gcm_learn.errors import GcmError
        from gcm_learn.planners import check_name

        names = [name.strip() for name in self.planners.split(",") if name.strip()]
        if not names:
            raise CommandFailure("--planners: names no planner")
        try:
            for name in names:
                check_name(name)
        except GcmError as error:
            raise CommandFailure(f"--planners: {error}") from None
        if self.wheel is not None:
            return self._build(self.wheel)
        tasks: list[Task] = [("", arena) for arena in ARENAS if find_spec("gymnasium")]
        tasks += [(name, example) for name in names for example in EXAMPLES]
        on_first_compiling(partial(say, f"compiling for all arms, {LASTS}"))
        side_by_side(tasks, self.workers)
        print(f"compiled for {', '.join(names)}")
        return 0

    def _build(self, folder: Path) -> int:
        """Compile for the wheel's processor in another process, and write the wheel."""
        from gcm_learn.compiled import INSIDE, PROCESSORS, TESTED, build_wheel, usual_processor

        if not INSIDE:
            tested = " to ".join(f"{major}.{minor}" for major, minor in TESTED)
            raise CommandFailure(f"--wheel: needs numba {tested}, without GCM_LEARN_PLAIN")
        processor = self.processor or usual_processor()
        if processor not in PROCESSORS:
            raise CommandFailure(f"--processor {processor}: must be one of {', '.join(PROCESSORS)}")
        command = [sys.executable, "-m", "gcm_learn", "warm-up", "--planners", self.planners]
        command += ["--workers", str(self.workers)] if self.workers else []
        print(build_wheel(command, folder, processor))
        return 0


def side_by_side(tasks: Sequence[Task], workers: int | None = None) -> None:
    """Run tasks in several processes to compile their kernels; neighbours differ in their arm.

    Each kernel is kept at once, so that an interrupted command can go on.
    """
    from gcm_learn.processes import crew_of

    with crew_of(workers) as crew, Progress(len(tasks), "answers") as progress:
        for _ in crew.results(answered, tasks):
            progress.advance()


def answered(task: Task) -> bool:
    """Run a planner on an example, or step an arena; return whether the planner takes the arm."""
    from gcm_learn.errors import ArmKindError
    from gcm_learn.families import draw
    from gcm_learn.planners import solve
    from gcm_learn.situation import with_end

    name, example = task
    if not name:
        env: Any = resolve_name(ENTRIES[example][0])()
        env.reset(seed=0)
        env.step(env.action_space.sample())
        return True
    situation: Any = draw(*example)
    try:
        solve(situation, name)
    except ArmKindError:
        return False
    if name == "search" and getattr(situation.arm, "max_joint_acceleration", None) is not None:
        solve(with_end(situation, "rest"), name)
    return True
