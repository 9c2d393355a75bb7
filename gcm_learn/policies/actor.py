"""A trained policy as plain arrays: acts without torch, and plans by acting."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np

from gcm_learn import artifacts, execution, seeding
from gcm_learn.arms import PLANAR, SPATIAL, Arm, ByKind, Kind, check_kind
from gcm_learn.errors import PolicyError, UnknownNameError
from gcm_learn.execution import ARENAS, CAUGHT, OUTCOMES, Pool, pool_for, way_of
from gcm_learn.motion import Failure, Movement, refine
from gcm_learn.planners import Attempt, JointProblem, Problem, checked
from gcm_learn.policies.directions import chosen, moved
from gcm_learn.situation import AnySituation, situation_to_json
from gcm_learn.storage import content_number, whole_file

FORMAT = "gcm-learn/actor@1"
FILE = "actor.npz"
FILES = {
    "CatchArm-v0": FILE,
    "CatchArm3D-v0": "actor3d.npz",
    "CatchChain-v0": "actor-chain.npz",
    "CatchArmPhysics-v0": "actor-physics.npz",
    "CatchChainPhysics-v0": "actor-chain-physics.npz",
}
"""By the arena in which a policy acts."""
LEARNER = "model.zip"  # file of a training run's folder with what learns
MINDS = ByKind({SPATIAL: execution.Commanding}, who="an actor in the closed loop")
"""Agents of the closed loop that act as a policy does."""
CLIP = 10.0  # of normalised observations, as Stable-Baselines3 has it


class Acting:
    """A policy that acts in an arena: of actors, and of policies from outside."""

    settings: execution.ArenaSettings
    """Of the arms for which it was made."""

    @property
    def kind(self) -> Kind:
        """Kind of the arms that the policy moves."""
        return self.settings.kind

    def act(self, observations: np.ndarray, rng: np.random.Generator | None = None) -> np.ndarray:
        """Return actions (n, commands) for observations (n, width)."""
        raise NotImplementedError

    def play(
        self, pool: execution.Pool, places: np.ndarray, rng: np.random.Generator | None = None
    ) -> execution.Episodes:
        """Play an episode in each of the situations of a pool at indices `places` (n,).

        With a generator, actions are drawn; else they are the most likely ones.
        """
        plant = execution.plant_of(pool, len(places), self.settings)
        return execution.run_episode(_Agent(self, rng), plant, places)

    def mind(self) -> execution.Commanding:
        """Return an agent of the closed loop that takes the policy's most likely actions.

        Raises
        ------
        ArmKindError
            If the closed loop does not take the policy's kind of arm.
        PolicyError
            If its actions are torques of motors.
        """
        made = MINDS.of(self.kind)
        if self.settings.pushed:
            raise PolicyError("commands torques of motors; the closed loop leads joints")
        return made(self.act, self.settings)


@dataclass(frozen=True)
class Actor(Acting):
    """A multilayer perceptron, with the scaling of observations and the settings of its arms."""

    layers: tuple[tuple[np.ndarray, np.ndarray], ...]
    """Weights (out, in) and biases (out,) of each layer, float32."""
    mean: np.ndarray
    """Of observations (width,)."""
    deviation: np.ndarray
    """Of observations (width,)."""
    head: Literal["choice", "velocity"]
    """Meaning of the last layer: scores of choices, or a velocity; see `directions`."""
    activation: Literal["relu", "tanh"]
    squash: bool
    """If true, the velocity is the tanh of the last layer."""
    spread: np.ndarray
    """Logarithm of the deviations of sampled actions (commands,); of no use to choices."""
    settings: execution.ArenaSettings
    """Of the arms with which it was trained."""

    def scores(self, observations: np.ndarray) -> np.ndarray:
        """Last layer (n, out) for observations (n, width)."""
        x = np.clip((observations - self.mean) / self.deviation, -CLIP, CLIP).astype(np.float32)
        for weights, bias in self.layers[:-1]:
            x = x @ weights.T + bias
            x = np.maximum(x, 0.0) if self.activation == "relu" else np.tanh(x)
        weights, bias = self.layers[-1]
        return x @ weights.T + bias

    def act(self, observations: np.ndarray, rng: np.random.Generator | None = None) -> np.ndarray:
        """Actions (n, commands): the most likely, or drawn if there is a generator."""
        scores = self.scores(observations)
        if self.head == "choice":
            if rng is not None:  # Gumbel's trick draws from the softmax
                scores = scores - np.log(-np.log(rng.random(scores.shape)))
            return chosen(self.settings, observations, scores.argmax(axis=1))
        if rng is not None:
            scores = scores + np.exp(self.spread) * rng.standard_normal(scores.shape)
        aimed = np.tanh(scores) if self.squash else np.clip(scores, -1.0, 1.0)
        return moved(self.settings, observations, aimed)

    def save(self, folder: Path) -> Path:
        """Write the policy into a folder as arrays; return the file's path."""
        header = {
            "format": FORMAT,
            "head": self.head,
            "activation": self.activation,
            "squash": self.squash,
            "settings": asdict(self.settings),
            "encoder": _encoder_key(self.settings),
        }
        arrays: dict[str, Any] = {f"w{k}": w for k, (w, _) in enumerate(self.layers)}
        arrays |= {f"b{k}": b for k, (_, b) in enumerate(self.layers)}
        path = folder / file_of(self.settings)
        with whole_file(path) as place:
            np.savez_compressed(
                place, header=np.array(json.dumps(header)), mean=self.mean,
                deviation=self.deviation, spread=self.spread, **arrays,
            )  # fmt: skip
        return path

    @classmethod
    def load(cls, folder: Path) -> Actor:
        """Read the policy of a folder; the file's name gives the arena.

        Raises
        ------
        PolicyError
            If the folder has no trained policy.
        """
        there = [arena for arena, name in FILES.items() if (folder / name).exists()]
        if not there:
            raise PolicyError(f"{folder / FILE}: there is no trained policy")
        arena, path = execution.ARENAS[there[0]], folder / FILES[there[0]]
        with np.load(path, allow_pickle=False) as file:
            header = json.loads(str(file["header"]))
            if header.get("format") != FORMAT:
                raise PolicyError(f"{path}: is not {FORMAT} but {header.get('format')!r}")
            count = sum(name.startswith("w") for name in file.files)
            settings = execution.settings_of(arena.settings, header["settings"])
            _check_encoder(path, settings, header.get("encoder", ""))
            return cls(
                layers=tuple((file[f"w{k}"], file[f"b{k}"]) for k in range(count)),
                mean=file["mean"],
                deviation=file["deviation"],
                head=header["head"],
                activation=header["activation"],
                squash=header["squash"],
                spread=file["spread"],
                settings=settings,
            )


def file_of(settings: execution.ArenaSettings) -> str:
    """Return the file name of policies for the settings' arena."""
    return FILES[execution.arena_of(settings).name]


@dataclass(frozen=True)
class _Agent:
    """A policy as an agent of episodes."""

    policy: Acting
    rng: np.random.Generator | None

    def act(self, moment: execution.Moment) -> np.ndarray:
        """Return the policy's actions (n, commands) at a moment."""
        return self.policy.act(moment.observations, self.rng)


def _check_encoder(path: Path, settings: execution.ArenaSettings, key: str) -> None:
    """Refuse an actor that has learned from another encoder's embeddings."""
    if _encoder_key(settings) and key != _encoder_key(settings):
        raise PolicyError(f"{path}: was trained with another encoder than that of the models")


def _encoder_key(settings: execution.ArenaSettings) -> str:
    """Return the key of the encoder whose embeddings are observed, or an empty string."""
    if not getattr(settings, "embedding", False):
        return ""
    from gcm_learn.execution import encoder

    return encoder().key


TRIES = 20  # as many as paths are checked by planners that recall


_FILES = ByKind({a.kind: FILES[a.name] for a in ARENAS.values() if a.followed}, who="no policy")


def actor_names(kind: Kind = PLANAR) -> list[str]:
    """Return the folders of the models that hold an actor for a kind of arm."""
    return list(artifacts.models(_FILES.of(kind)))


def actor_folder(name: str) -> Path:
    """Return the folder of a trained actor; raise PolicyError if it is missing."""
    folder = next(filter(None, (artifacts.model(name, file) for file in _FILES.entries())), None)
    if folder is None:
        make = f"gcm-learn train policy CONFIG --out {artifacts.own('models') / name}"
        raise PolicyError(artifacts.missing("models", f"trained policy {name!r}", make))
    return folder


def shipped_actor(name: str) -> Actor:
    """Return a trained actor by its name among the models; raise PolicyError if it is missing."""
    return Actor.load(actor_folder(name))


def all_actor_names() -> list[str]:
    """Return the names of all trained actors."""
    return [name for kind in _FILES for name in actor_names(kind)]


def acted(actor: Acting, situation: AnySituation) -> tuple[str, Movement, int]:
    """Play an episode; return its outcome, the movement, and the number of steps."""
    check_kind(situation, actor.kind, "the policy")
    pool = pool_for(actor.settings, [situation])
    episodes = actor.play(pool, np.zeros(1, np.int64))
    time, posture = episodes.path(0)
    way = _KINDS.of(actor.kind).way(situation.arm, time, pool.frames[0].original(posture))
    return OUTCOMES[int(episodes.outcomes[0])], way, int(episodes.steps[0])


def found_actor(given: str) -> Actor | None:
    """Return a trained actor by name, by its folder, or by the path of the folder's `model.zip`.

    Return None for anything else.
    """
    if given in all_actor_names():
        return shipped_actor(given)
    path = Path(given)
    folder = path.parent if path.name == LEARNER else path
    there = any((folder / file).is_file() for file in _FILES.entries())
    return Actor.load(folder) if there else None


def tried_out(name: str) -> ActorPlanner | None:
    """Return the planner ``clone@20``, an actor that is tried out so often; ``clone`` is once.

    Returns None for other names.

    Raises
    ------
    UnknownNameError
        If no number of tries comes after the @.
    """
    actor = found_actor(name)
    if actor is not None:
        return ActorPlanner(actor, name, 1)
    bare, _, tries = name.rpartition("@")
    actor = found_actor(bare) if bare else None
    if actor is None:
        return None
    if not tries.isdigit() or int(tries) < 1:
        raise UnknownNameError(f"policy {name!r}: after @ comes a number of tries")
    return ActorPlanner(actor, name, int(tries))


@dataclass(frozen=True)
class ActorPlanner:
    """Planner that tries an actor's most likely path and random ones; the earliest valid wins."""

    actor: Acting
    name: str
    tries: int = TRIES
    seed: int = 0

    def takes(self, kind: Kind) -> bool:
        """Return whether the actor moves arms of a kind."""
        return kind is self.actor.kind

    def plan(self, situation: AnySituation) -> Any:
        """Answer a situation with an arm of the actor's kind."""
        check_kind(situation, self.actor.kind, f"policy {self.name!r}")
        kind = _KINDS.of(situation)
        problem = kind.problem(situation, self.name)
        answer = problem.early_answer(**kind.promises)
        if answer is not None:
            return answer
        settings = self.actor.settings
        pool = settings.prepared(pool_for(settings, [situation]))
        targets = [i for i, body in enumerate(situation.bodies) if body.role == "target"]
        for time, posture in self._caught(pool, pool.situations[0]):
            way = kind.way(situation.arm, time, pool.frames[0].original(posture))
            for index in targets:
                plan, _ = checked(problem, Attempt(way, index))
                if plan is not None:
                    return plan
        return problem.answer(Failure.NO_VALID_ROLLOUT.with_numbers(count=self.tries))

    def _caught(
        self, pool: Pool, situation: AnySituation
    ) -> Iterator[tuple[np.ndarray, np.ndarray]]:
        """Yield the paths that catch in a pool's only situation, the earliest catch first."""
        found = [self.actor.play(pool, np.zeros(1, np.int64))]
        if self.tries > 1:
            text = json.dumps(situation_to_json(situation), sort_keys=True)
            source = seeding.rng(self.seed, content_number(text.encode(), 6))
            drawn = np.zeros(self.tries - 1, np.int64)
            found.append(self.actor.play(pool, drawn, source))
        paths = [
            (float(e.times[arm]), e, arm)
            for e in found
            for arm in np.flatnonzero(e.outcomes == CAUGHT)
        ]
        for _, episodes, arm in sorted(paths, key=lambda found: found[0]):
            yield episodes.path(int(arm))


def _refined_way(arm: Arm, time: np.ndarray, hand: np.ndarray) -> Movement:
    """Return the trajectory through hands (n, 2), with more samples, from the arm's hand on."""
    hand[0] = arm.hand
    time, hand = refine(arm, time, hand)
    return Movement.of_hand(arm, time, hand)


@dataclass(frozen=True)
class _ActorKind:
    """Parts of an actor's planning that differ by kind of arm."""

    problem: Callable[[Any, str], Any]
    promises: dict[str, bool]
    """Limits that the arena keeps, of which the problem should know."""
    way: Callable[[Any, np.ndarray, np.ndarray], Any]
    """Movement of an arm from times and postures."""


_KINDS = ByKind(
    {PLANAR: _ActorKind(Problem, {}, _refined_way)},
    default=_ActorKind(JointProblem, {"keeps_acceleration": True}, way_of),
)
