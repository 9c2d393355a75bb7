"""``gcm-learn warm-up``: compile now what is compiled at the first plan otherwise."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any

from tyro.conf import arg

from gcm_learn.cli.failures import CommandFailure
from gcm_learn.cli.options import AllCores
from gcm_learn.cli.progress import Progress

EXAMPLES = {
    "spatial": ("crossing-swarm-space", 3, 5),
    "planar": ("crossing-swarm", 3, 5),
    "chain": ("throw-chain", 3, 1),
}
"""Family, seed and number of situations with an obstacle beside the straight line to the target."""


@dataclass(frozen=True)
class WarmUp:
    """Compile what planners run, for every kind of arm; later commands start at once."""

    planners: Annotated[str, arg(metavar="A,B")] = "search,straight,straight-wait,gcm,recall,hybrid"
    """names of planners"""

    workers: AllCores = None
    """processes that compile side by side"""

    def run(self) -> int:
        """Let planners answer an example for each kind of arm."""
        from gcm_learn.errors import GcmError
        from gcm_learn.planners import get_planner
        from gcm_learn.processes import crew_of

        names = [name.strip() for name in self.planners.split(",") if name.strip()]
        if not names:
            raise CommandFailure("--planners: names no planner")
        try:
            for name in names:
                get_planner(name)
        except GcmError as error:
            raise CommandFailure(f"--planners: {error}") from None
        tasks = [(name, kind) for kind in EXAMPLES for name in names]
        with crew_of(self.workers) as crew, Progress(len(tasks), "planners") as progress:
            for _ in crew.results(answered, tasks):
                progress.advance()
        print(f"compiled for {', '.join(names)}")
        return 0


def answered(task: tuple[str, str]) -> bool:
    """Let a planner answer the example of a kind of arm; return whether it takes the kind."""
    from gcm_learn.errors import ArmKindError
    from gcm_learn.families import draw
    from gcm_learn.planners import solve

    name, kind = task
    situation: Any = draw(*EXAMPLES[kind])
    try:
        solve(situation, name)
    except ArmKindError:
        return False
    return True
