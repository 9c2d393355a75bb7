"""``gcm-learn train-policy``: a policy from a hyperparameter file."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated

from tyro.conf import Positional, arg

from gcm_learn.cli.failures import CommandFailure
from gcm_learn.cli.files import made_folder
from gcm_learn.errors import MissingExtraError


@dataclass(frozen=True)
class TrainPolicy:
    """Train a policy in the arena, or go on where an earlier run of the same command stopped."""

    config: Annotated[Positional[Path], arg(metavar="CONFIG")]
    """a .yml file of hyperparameters in the form of rl_zoo3; `gcm-learn example ppo.yml` copies
    one, `gcm-learn example` lists others"""

    out: Annotated[Path, arg(metavar="DIR")]
    """folder for the policy, its checkpoints, its log and its card"""

    seed: Annotated[int | None, arg(metavar="N", help_behavior_hint="(default: the file's)")] = None
    """of everything random"""

    steps: Annotated[int | None, arg(metavar="N", help_behavior_hint="(default: the file's)")] = (
        None
    )
    """of all arms together; more than before goes on with a finished run"""

    def run(self) -> int:
        """Train, and say how good the policy is."""
        try:
            from gcm_learn.policies import read_plan, train
        except ModuleNotFoundError as error:
            raise MissingExtraError("train-policy", str(error.name), "rl") from None
        plan = read_plan(self.config)
        if self.seed is not None:
            if self.seed < 0:
                raise CommandFailure(f"--seed {self.seed}: must not be negative")
            plan = replace(plan, seed=self.seed)
        if self.steps is not None:
            if self.steps < 1:
                raise CommandFailure(f"--steps {self.steps}: must be at least 1")
            plan = replace(plan, n_timesteps=self.steps)
        scores = train(plan, made_folder(self.out, option="--out"), _say)
        print(f"{self.out}: {scores['caught']:.1%} caught, {scores['touched']:.1%} touched")
        return 0


def _say(text: str) -> None:
    print(text, flush=True)
