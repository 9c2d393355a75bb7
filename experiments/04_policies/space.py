"""Compare policies in space with rules that do not learn: unseen situations, in pairs.

    python -m experiments 04_policies/space models/ppo-space [models/OTHER ...]

Situations are drawn from all families in space, or read (`--source`), under a seed that served
neither training nor choice. All are counted, whether or not there is a way to catch.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from gcm_learn.evaluation import Table, mcnemar, wilson
from gcm_learn.execution import (
    AIM,
    CAUGHT,
    COLLIDED,
    COMMANDS,
    Moment,
    commands_of,
    plant_of,
    pool_of,
    run_episode,
)
from gcm_learn.execution.arena.kernels.joints.fan import DIRECTIONS, FRAME, HALF, RAY, ROOM
from gcm_learn.families import family_names
from gcm_learn.policies import Actor


class Straight:
    """Always the command that leads straight to where the target can be met."""

    def __init__(self, settings: Any) -> None:
        self.at = settings.straight

    def act(self, moment: Moment) -> np.ndarray:
        """Return that command (n, 4), as it is observed."""
        return moment.observations[:, self.at : self.at + 4].astype(float)


class Fan:
    """A rule without learning: the ray that is free longest, has most clearance and turns least.

    A ray into the target comes first. Clearance counts half of a turn about. These weights were
    chosen on the validation situations.
    """

    def __init__(self, settings: Any) -> None:
        self.settings = settings

    def act(self, moment: Moment) -> np.ndarray:
        """The command (n, 4) of that ray."""
        told, at = moment.observations, self.settings.fan_at
        rays = told[:, at + FRAME : at + FRAME + RAY * COMMANDS].reshape(-1, COMMANDS, RAY)
        free, room, gap = np.moveaxis(rays.astype(float), 2, 0)
        turn = DIRECTIONS[:, 0].copy()
        turn[HALF] = 0.5
        worth = 10.0 * free + 0.5 * room / ROOM + turn + 100.0 * (gap <= 0.0)
        out = np.empty((len(told), 4))
        commands_of(told, AIM, at, worth.argmax(axis=1), out)
        return out


def interval(count: int, n: int) -> str:
    """A share with Wilson's 95 % interval [%]."""
    share, low, high = wilson(count, n)
    return f"{share:.1%} ({low:.1%} to {high:.1%})"


def main(arguments: Sequence[str] | None = None) -> None:
    """Play, and print a row for each family and one for all."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folders", nargs="+", type=Path)
    parser.add_argument("--source", action="append", help="family or file; all families if none")
    parser.add_argument("--count", type=int, default=200, help="of each")
    parser.add_argument("--seed", type=int, default=2)
    options = parser.parse_args(arguments)
    for folder in options.folders:
        actor, caught, touched = Actor.load(folder), [], []
        rules: list[Any] = [Straight(actor.settings)]
        if actor.settings.fan:
            rules.append(Fan(actor.settings))
        head = ["situations", "number", "caught", "touched"]
        for rule in rules:
            head += [type(rule).__name__.lower(), "won", "lost", "p"]
        print(f"\n{folder}\n\n{Table(head, [])}")
        for source in options.source or family_names("spatial"):
            pool = pool_of(source, options.count, options.seed, actor.settings)
            places = np.arange(len(pool))
            plant = plant_of(pool, len(pool), actor.settings)
            played = [actor.play(pool, places)]
            played += [run_episode(rule, plant, places) for rule in rules]
            caught.append(np.array([e.outcomes == CAUGHT for e in played]))
            touched.append(played[0].outcomes == COLLIDED)
            print(" | ".join(row(source, caught[-1], touched[-1])), flush=True)
        print(" | ".join(row("all", np.hstack(caught), np.hstack(touched))), flush=True)


def row(name: str, caught: np.ndarray, touched: np.ndarray) -> list[str]:
    """Return the cells of a row of the table."""
    n, mine = caught.shape[1], caught[0]
    cells = [name, str(n), interval(int(mine.sum()), n), f"{touched.mean():.1%}"]
    for other in caught[1:]:
        won, lost, p = mcnemar(mine, other)
        rare = f"{p:.1g}" if p > 1e-99 else "under 1e-99"
        cells += [interval(int(other.sum()), n), str(won), str(lost), rare]
    return cells


if __name__ == "__main__":
    main()
