"""Plan of a training run: a hyperparameter file in the form of rl_zoo3, checked.

It has one entry, named after the environment. Fields of rl_zoo3 keep their meaning; ours are
`algo` (rl_zoo3 takes it from the file's name), `actions`, `situations`, `validation`, `settings`,
`demonstrations`, `start` and `seed`.
"""

from __future__ import annotations

import dataclasses
import inspect
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from gcm_learn.arms import PLANAR, ByKind, Kind
from gcm_learn.errors import (
    FileFormatError,
    GcmError,
    MissingExtraError,
    PolicyError,
    UnknownNameError,
    not_among,
    not_known,
)
from gcm_learn.execution import ARENAS, ArenaSettings, Settings, arena_named, arena_of, settings_of
from gcm_learn.planners import get_planner
from gcm_learn.policies import curves
from gcm_learn.policies.directions import choices_in

if TYPE_CHECKING:
    from stable_baselines3.common.base_class import BaseAlgorithm


ALGORITHMS = ("clone", "ppo", "sac", "tqc")
WHOLE = ("n_steps", "batch_size", "n_epochs", "buffer_size", "learning_starts", "train_freq",
         "gradient_steps", "epochs", "batch")  # fmt: skip
"""Hyperparameters that are whole numbers."""
_OURS = ("policy", "env", "seed", "tensorboard_log", "device", "policy_kwargs", "_init_setup_model")
"""Arguments of Stable-Baselines3 that a training run gives itself."""
_ADDED = ("policy", "net_arch", "log_std_init")
_OF_PPO = ("value_arch", "bfloat16")
"""Units of the value's layers, `net_arch` if absent, and whether layers are in bfloat16."""


def algorithm(name: str) -> type[BaseAlgorithm]:
    """Return the class of an algorithm; TQC comes from sb3-contrib."""
    if name == "tqc":
        try:
            from sb3_contrib import TQC
        except ImportError:
            raise MissingExtraError("tqc", "sb3-contrib", "rl") from None
        return TQC
    try:
        from stable_baselines3 import PPO, SAC
    except ImportError:
        raise MissingExtraError(name, "stable-baselines3", "rl") from None
    return {"ppo": PPO, "sac": SAC}[name]


def hyperparameters(name: str) -> set[str]:
    """Return the names of the hyperparameters that a file may give to an algorithm."""
    if name == "clone":
        from gcm_learn.policies.cloning import Cloning

        return {f.name for f in dataclasses.fields(Cloning)} - {"layers"} | {"net_arch"}
    added = (*_ADDED, *(_OF_PPO if name == "ppo" else ()))
    return set(inspect.signature(algorithm(name)).parameters) - set(_OURS) | set(added)


_DEFAULTS: ByKind[tuple[dict[str, Any], str]] = ByKind(
    {PLANAR: ({"fan": True}, "choice")}, default=({}, "velocity")
)
"""Settings and actions of a plan that says nothing of them."""


@dataclass(frozen=True)
class Share:
    """One source of the situations of a training run, and the choice of situations from it."""

    source: str
    """A family's name, a dataset's folder or a file of situations."""
    count: int = 2000
    """Number of situations that are drawn or read."""
    strata: tuple[str, ...] = ()
    """Of a dataset: only records of these strata are taken; by default of all."""
    families: tuple[str, ...] = ()
    """Of a dataset: only records of these families are taken; by default of all."""
    reachable: bool = False
    """Of a family or file: if true, only situations with a catch by `search` are taken."""
    caught_by: str = ""
    """Of a family or file: only situations with a catch by this planner, e.g. `straight`."""
    shown_by: str = "search"
    """Of a family or file: the planner whose catches are the demonstrations, e.g. `recall`."""
    split: str = "train"
    """Of a dataset: its split."""
    seed: int = 0
    """Of a family: seed of the draws."""


@dataclass(frozen=True)
class TrainingPlan:
    """Settings that determine the result of a training run, up to the arithmetic of torch."""

    algo: Literal["clone", "ppo", "sac", "tqc"]
    situations: tuple[Share, ...]
    """Situations of the training."""
    validation: tuple[Share, ...]
    """Situations on which checkpoints are compared."""
    n_timesteps: int = 0
    """Steps of all arms together; clones need none."""
    n_envs: int = 64
    """Arms at once."""
    normalize: bool = True
    """If true, observations are scaled by their running mean and deviation."""
    actions: Literal["choice", "velocity"] = "choice"
    """Both as seen from the straight way to the target; see `directions`. In space
    choices need a fan."""
    seed: int = 0
    settings: ArenaSettings = field(default_factory=lambda: Settings(fan=True))
    """Of the arena."""
    demonstrations: bool = False
    """If true, the replay buffer begins with catches that are acted out (sac, tqc)."""
    start: str = ""
    """Folder of a trained policy whose network is the start, e.g. a clone."""
    evaluate_every: int = 250_000
    """Steps between evaluations, each of which leaves a checkpoint."""
    until_settled: int = 0
    """Learning ends once evaluations have stopped gaining, see `curves`; a quarter of these has
    at least this number. 0: learning does not end early."""
    hyperparameters: Mapping[str, Any] = field(default_factory=dict)
    """Of the algorithm, as Stable-Baselines3 or `Cloning` name them."""

    @property
    def kind(self) -> Kind:
        """Kind of the arms."""
        return self.settings.kind

    def __post_init__(self) -> None:
        if self.algo not in ALGORITHMS:
            raise PolicyError(f"algo: {not_among(self.algo, ALGORITHMS)}")
        if self.actions not in ("choice", "velocity"):
            raise PolicyError(f"actions: {self.actions!r} is not one of choice, velocity")
        if not arena_of(self.settings).followed and (self.algo == "clone" or self.demonstrations):
            raise PolicyError("algo: there are no demonstrations of arms with mass")
        if self.actions == "choice" and not choices_in(self.settings):
            raise PolicyError("actions: choices in space need a fan and rates of joints as actions")
        if self.algo in ("sac", "tqc") and self.actions == "choice":
            raise PolicyError(f"actions: {self.algo} needs velocity")
        if self.demonstrations and self.algo not in ("sac", "tqc"):
            raise PolicyError(f"demonstrations: {self.algo} has no replay buffer for them")
        if self.algo != "clone" and self.n_timesteps < 1:
            raise PolicyError(f"n_timesteps: must be at least 1 (got {self.n_timesteps})")
        gamma = self.hyperparameters.get("gamma", self.settings.discount)
        if self.settings.weights.guide != 0.0 and gamma != self.settings.discount:
            raise PolicyError(f"settings.discount: must be the learner's gamma ({gamma})")
        for name in ("n_envs", "evaluate_every"):
            if getattr(self, name) < 1:
                raise PolicyError(f"{name}: must be at least 1 (got {getattr(self, name)})")
        if 0 < self.until_settled < curves.CHECKS:
            raise PolicyError(f"until_settled: must be 0, or at least {curves.CHECKS} evaluations")
        for name in ("situations", "validation"):
            if not getattr(self, name):
                raise PolicyError(f"{name}: there is none")


def read_plan(path: Path) -> TrainingPlan:
    """Read a hyperparameter file.

    Raises
    ------
    FileFormatError
        One line that names file and field.
    """
    try:
        import yaml
    except ImportError:
        raise MissingExtraError("reading hyperparameters", "PyYAML", "rl") from None
    try:
        text = path.read_text("utf-8")
        content = yaml.safe_load(text)
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, "strerror", None) or "is not UTF-8 text"
        raise FileFormatError(f"{path}: cannot be read ({reason})") from None
    except yaml.YAMLError as error:
        mark = getattr(error, "problem_mark", None)
        line = 1 if mark is None else mark.line + 1
        raise FileFormatError(f"{path}:{line}: not valid YAML") from None
    try:
        name, entry = _entry(content)
    except GcmError as error:
        raise FileFormatError(f"{path}:1: {error}") from None
    try:
        return plan_of(entry, name)
    except MissingExtraError:
        raise
    except (GcmError, TypeError, ValueError) as error:
        line = _line_of(text, str(error).partition(":")[0])
        raise FileFormatError(f"{path}:{line}: {name}.{error}") from None


def _entry(content: object) -> tuple[str, Mapping[str, Any]]:
    """Return name and fields of the only entry for an arena; other entries are ignored.

    Raises
    ------
    PolicyError, UnknownNameError
    """
    names = [str(name) for name in content] if isinstance(content, Mapping) else []
    ours = [name for name in names if name.rpartition("/")[2] in ARENAS]
    if names and not ours:
        arena_named(names[0])
    if len(ours) != 1:
        raise PolicyError(f"must hold an entry {' or '.join(ARENAS)}")
    entry = dict(content)[ours[0]]  # type: ignore[call-overload]
    if not isinstance(entry, Mapping):
        raise PolicyError(f"{ours[0]}: must hold fields of a training run")
    return ours[0], entry


def _line_of(text: str, field: str) -> int:
    """Return the first line of a YAML text with the last part of a field, or 1."""
    key = re.escape(field.rpartition(".")[2])
    found = re.search(rf"^[\s-]*{key}\s*:", text, re.MULTILINE)
    return text.count("\n", 0, found.end()) + 1 if found else 1


def plan_of(entry: Mapping[str, Any], environment: str = "CatchArm-v0") -> TrainingPlan:
    """A plan from the entry of a hyperparameter file; numbers may be written as 1e6."""
    values = dict(entry)
    known = {f.name for f in dataclasses.fields(TrainingPlan)} - {"hyperparameters"}
    given = {name: values.pop(name) for name in list(values) if name in known}
    if "algo" not in given:
        raise PolicyError(f"algo: is missing (one of {', '.join(ALGORITHMS)})")
    for name in ("situations", "validation"):
        given[name] = tuple(_share(item, name) for item in given.get(name, ()))
    for name in ("n_timesteps", "n_envs", "seed", "evaluate_every", "until_settled"):
        if name in given:
            given[name] = _whole(given[name], name)
    arena = arena_named(environment)
    settings, actions = _DEFAULTS.of(arena.kind)
    given["settings"] = settings_of(arena.settings, given.get("settings", settings))
    given.setdefault("actions", actions)
    rest = {
        k: v if k in ("net_arch", "value_arch") else _number(v) for k, v in values.items()
    }  # "64" is a list
    plan = TrainingPlan(**given, hyperparameters=rest)
    _check_hyperparameters(plan, known)
    return plan


def _check_hyperparameters(plan: TrainingPlan, fields: set[str]) -> None:
    """Refuse names that are no hyperparameters of the algorithm, and counts with fractions."""
    taken = hyperparameters(plan.algo)
    for name, value in plan.hyperparameters.items():
        if name not in taken:
            raise PolicyError(f"{name}: {not_known(name, sorted(taken | fields))} of {plan.algo}")
        if name in WHOLE:
            _whole(value, name)


def _whole(value: Any, field: str) -> int:
    """Return a whole number, which may be written as 1e6."""
    try:
        return int(float(value))
    except (TypeError, ValueError, OverflowError):
        raise PolicyError(f"{field}: must be a whole number (got {value!r})") from None


def _share(item: Mapping[str, Any], name: str) -> Share:
    known = {f.name for f in dataclasses.fields(Share)}
    if not isinstance(item, Mapping) or "source" not in item:
        raise PolicyError(f"{name}: each must have source, and may have {', '.join(sorted(known))}")
    for key in set(item) - known:
        raise PolicyError(f"{name}.{key}: {not_known(key, known)}")
    values = dict(item)
    for whole in ("count", "seed"):
        if whole in values:
            values[whole] = _whole(values[whole], f"{name}.{whole}")
    for names in ("strata", "families"):
        values[names] = tuple(values.get(names, ()))
    for role in ("caught_by", "shown_by"):
        if values.get(role):
            _known_planner(values[role], f"{name}.{role}")
    return Share(**values)


def _known_planner(planner: Any, field: str) -> None:
    """Fail with the field's name if there is no such planner."""
    try:
        get_planner(planner)
    except UnknownNameError as error:
        raise PolicyError(f"{field}: {str(error).removeprefix('planner: ')}") from None


def _number(value: Any) -> Any:
    """YAML reads 3e-4 as text."""
    if isinstance(value, str):
        try:
            return float(value)
        except ValueError:
            return value
    return value
