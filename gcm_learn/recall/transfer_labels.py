"""Labels for encoders: the memories that catch in a situation once they are adapted.

Memories are the catches of a dataset. Each situation of its
records comes once. Then the specification draws others, which need cheap labels only and no plan.
Most situations that a straight line catches are left out, since most memories catch there.
"""

from __future__ import annotations

import gc
import io
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from itertools import islice
from pathlib import Path
from typing import Any, NamedTuple, Protocol

import numpy as np

from gcm_learn import seeding
from gcm_learn.dataset import Dataset, Record, quantities_of, uncollected
from gcm_learn.errors import RecallError
from gcm_learn.processes import Crew, Here
from gcm_learn.recall.adaptation import DEFAULT
from gcm_learn.recall.features import FeatureBatch, Features, Sizes, batched
from gcm_learn.recall.growth import Source, source_of
from gcm_learn.recall.kinds import MEMORIES
from gcm_learn.scene import TOP_SPEED
from gcm_learn.situation import AnySituation
from gcm_learn.storage import write_whole

DEPTH = 600  # best memories from which a batch about the best chooses
EASY = 0.15  # share of situations that are kept although a straight line catches
READ, TRIED = 500, 32  # records that are read at once, situations that are
EXAMINED = 300  # situations of each stratum to validate with
PLACES = (1, 5, 20)  # up to which a valid memory is looked for then
_BATCH, _SAMPLE, _ORDER = 7, 8, 9  # purposes of random numbers

Picture = Callable[[Any], np.ndarray]
"""Features of the map of a record."""
Best = Callable[[FeatureBatch, int], np.ndarray]
"""From features of n situations and a number k, the memories (n, k) that fit best by what is known
so far, the best first."""


class ValidMemories(NamedTuple):
    """Situations, memories, and which of them are valid where."""

    features: FeatureBatch
    """Of n situations."""
    rows: np.ndarray
    """Memories that were tried: (m,) int64 on all situations, or (n, m) on each its own."""
    valid: np.ndarray
    """(n, m) bool"""
    own: np.ndarray
    """(n,) int64: column of a situation's own memory, -1 for those without."""

    def save(self, path: Path) -> None:
        """Write the labels into a file."""
        stream = io.BytesIO()
        features, *rest = self
        np.savez(stream, *features, *rest)
        write_whole(path, stream.getvalue())

    @classmethod
    def load(cls, path: Path) -> ValidMemories:
        """Read the labels from a file."""
        with np.load(path) as file:
            arrays = [file[f"arr_{k}"] for k in range(len(file.files))]
        size = len(FeatureBatch._fields)
        return cls(FeatureBatch(*arrays[:size]), *arrays[size:])


class TrainingData(Protocol):
    """Memories, and which of them are valid in which situations."""

    @property
    def path_features(self) -> np.ndarray:
        """Features (m, f) float32 of the memories' paths."""

    @property
    def map_features(self) -> np.ndarray | None:
        """Features (m, n) float32 of their maps, if wanted, else None."""

    @property
    def situation_counts(self) -> tuple[int, int]:
        """Features of a situation's context, and of an obstacle."""

    def labels(self, index: int, best: Best | None) -> ValidMemories:
        """Batch number `index`; on the memories that seem best if `best` is given."""

    def validate(self, best: Best) -> dict[str, float]:
        """Scores by name, on situations that no batch has."""


class TransferLabels:
    """Labels from the training records of a dataset; its validation records serve for scores.

    Parameters
    ----------
    records : Dataset
    seed : int
        Decides which records are taken, and all labels.
    most : int, optional
        Records that are read at most; by default all.
    maps : bool
        Whether features of maps are wanted: of the records' maps, else of new maps.
    synthetic : bool
        Whether memories are synthetic movements in place of catches; see `recall.synthetic`.
    crew : Crew
        Processes that read the records and try memories; by default this process.
    progress : callable
        Called with the number of records read since the last call.
    sizes : Sizes, optional
        Sizes of batches; by default those of the kind of arm.
    """

    def __init__(
        self,
        records: Dataset,
        seed: int = 0,
        *,
        most: int | None = None,
        maps: bool = False,
        synthetic: bool = False,
        crew: Crew | None = None,
        progress: Callable[[int], None] = lambda done: None,
        sizes: Sizes | None = None,
    ) -> None:
        self.spec, self.seed, self.crew = records.spec, seed, crew or Here()
        self.kind = MEMORIES.of(records.spec.kind)
        self.sizes = self.kind.lesson if sizes is None else sizes
        train, self._held = records.where(split="train"), records.where(split="validation")
        order = np.arange(len(train))
        if most is not None and most < len(order):
            order = np.sort(seeding.rng(seed, _SAMPLE).permutation(len(order))[:most])
        self.situations: list[AnySituation] = []
        paths: list[Any] = []
        drawn, easy = [], []
        parts = [order[k : k + READ] for k in range(0, len(order), READ)]
        source = source_of(train, synthetic=synthetic, seed=seed)
        with uncollected():
            picture = picture_of if maps else None
            read = self.crew.map(partial(_lessons, picture, source), map(train.part, parts))
            for part, lessons in zip(parts, read, strict=True):
                progress(len(part))
                for lesson in lessons:
                    self.situations.append(lesson.situation)
                    paths.append(lesson.waypoints)
                    easy.append(lesson.easy)
                    drawn.append(lesson.map)
        if len(paths) < 2:
            raise RecallError("the dataset has no catches to learn from")
        columns = sorted({path.knots.shape[1] for path in paths})
        if len(columns) > 1:
            found = " and ".join(str(count - 2) for count in columns)
            raise RecallError(f"the dataset has arms of {found} joints; an encoder takes one kind")
        self.knots = np.array([path.knots for path in paths])
        self.goals = np.array([path.goal for path in paths])
        self.path_features = self.kind.path_features(self.knots, self.goals)
        self.map_features = np.array(drawn) if maps else None
        lots = seeding.rng(seed, _ORDER)
        kept = ~np.array(easy) | (lots.random(len(easy)) < EASY)
        gc.freeze()  # these objects stay: no need to look through them again and again
        self._order = lots.permutation(np.flatnonzero(kept))
        """Records whose situations labels are about, in this order."""
        self._exam = [(r.stratum, r.situation) for r in self._examined()]

    def _examined(self) -> Iterator:
        """Held-out records of each stratum that can be caught."""
        for stratum in ("L", "W", "Q"):
            some = self._held.where(stratum=stratum)
            yield from (some[k] for k in range(min(EXAMINED, len(some))))

    @property
    def situation_counts(self) -> tuple[int, int]:
        """Features of a situation's context, and of an obstacle."""
        seen = self._seen([self.kind.problem(self.situations[0], "labels")])
        return seen.context.shape[1], seen.cells.shape[1]

    def labels(self, index: int, best: Best | None) -> ValidMemories:
        """Label situations that are new in every batch once the records are used up."""
        rng, size, most = seeding.rng(self.seed, _BATCH, index), self.sizes.others, self.sizes.any
        own = self._order[index * size : (index + 1) * size]
        problems = [self.kind.problem(self.situations[k], "labels") for k in own.tolist()]
        if len(problems) < size:
            problems += islice(self._drawn(index, rng), size - len(problems))
        problems += self._alone(problems, rng)
        seen, column = self._seen(problems), np.full(len(problems), -1)
        if best is None:
            others = np.setdiff1d(rng.permutation(len(self.knots))[: 2 * most], own)
            rows = np.concatenate([own[: most // 2], rng.permutation(others)])[:most]
            each = np.broadcast_to(rows, (len(problems), len(rows)))
            mine = min(len(own), most // 2)
            column[:mine] = np.arange(mine)
        else:
            each = rows = self.sizes.hard(_without(best(seen, DEPTH), own), rng)
        return ValidMemories(seen, rows, self._valid(problems, each), column)

    def validate(self, best: Best) -> dict[str, float]:
        """Return shares of held-out situations with a valid memory among the first k, by name."""
        scores: dict[str, float] = {}
        if not self._exam:
            return scores
        problems = [self.kind.problem(situation, "validation") for _, situation in self._exam]
        strata = np.array([stratum for stratum, _ in self._exam])
        valid = self._valid(problems, best(self._seen(problems), max(PLACES)))
        for stratum in np.unique(strata):
            some = valid[strata == stratum]
            for k in PLACES:
                scores[f"{stratum}/first {k}"] = float(some[:, :k].any(axis=1).mean())
        return scores

    def _valid(self, problems: list[Any], rows: np.ndarray) -> np.ndarray:
        """Return which memories (n, m) are valid in situations (n): (n, m) bool."""
        firsts = range(0, len(problems), TRIED)
        tries = (self._try(problems[k : k + TRIED], rows[k : k + TRIED]) for k in firsts)
        return np.concatenate(list(self.crew.map(_tried, tries)))

    def _try(self, problems: list[Any], rows: np.ndarray) -> _Try:
        """Collect the memories to try, and their places."""
        asked, where = np.unique(rows, return_inverse=True)
        return _Try(problems, self.knots[asked], self.goals[asked], where.reshape(rows.shape))

    def _seen(self, problems: list[Any]) -> FeatureBatch:
        parts = (problems[k : k + TRIED] for k in range(0, len(problems), TRIED))
        return batched([one for some in self.crew.map(_looks, parts) for one in some])

    def _drawn(self, index: int, rng: np.random.Generator) -> Iterator[Any]:
        """Draw problems from the specification outside its holdouts, few of them easy."""
        k = 0
        while True:
            source = seeding.rng(self.seed, _BATCH, index, k)
            k += 1
            family = self.spec.choose(source)
            problem = self.kind.problem(family.draw(source, "drawn"), "labels")
            if self.kind.early_answer(problem) is not None or self._is_held_out(
                family.family, problem
            ):
                continue
            if rng.random() >= EASY and self.kind.straight(problem).caught:
                continue
            yield problem

    def _alone(self, problems: list[Any], rng: np.random.Generator) -> list[Any]:
        """Repeat some situations with a single obstacle, to show which obstacle a path fails at."""
        several = [p.situation for p in problems if len(p.situation.obstacles) > 1]
        out = []
        for k in rng.permutation(len(several))[: self.sizes.alone].tolist():
            situation = several[k]
            one = situation.obstacles[int(rng.integers(len(situation.obstacles)))]
            bare = {"place": None, "ignore": (), "ignore_for": None}  # may name other obstacles
            targets = (replace(target, **bare) for target in situation.targets)
            alone = replace(situation, bodies=(*targets, one))
            out.append(self.kind.problem(alone, "labels"))
        return out

    def _is_held_out(self, family: str, problem: Any) -> bool:
        situation = problem.situation
        top = float(problem.bodies.rows[:, TOP_SPEED].max())
        quantities = quantities_of(situation, top)
        return any(holdout.holds(family, quantities) for holdout in self.spec.holdouts)


class _Lesson(NamedTuple):
    """Lesson of a record."""

    situation: AnySituation
    waypoints: Any
    easy: bool
    map: np.ndarray | None


class _Try(NamedTuple):
    """Memories, and which of them are to be tried in which situations."""

    problems: list[Any]
    knots: np.ndarray
    goals: np.ndarray
    rows: np.ndarray


def picture_of(record: Record) -> np.ndarray:
    """Return features of a record's map, or of a new map if the record holds none."""
    kind, made = MEMORIES.of(record.situation), record.map
    return kind.map_features(kind.map_of(record.situation) if made is None else made)


def _lessons(picture: Picture | None, source: Source, records: Dataset) -> list[_Lesson]:
    """The movements of some records."""
    out = []
    for record in records:
        if (waypoints := source(record)) is not None:
            drawn = None if picture is None else picture(record)
            out.append(_Lesson(record.situation, waypoints, record.stratum == "L", drawn))
    return out


def _tried(ask: _Try) -> np.ndarray:
    """Return which memories are valid (n, m) bool."""
    pairs = zip(ask.problems, ask.rows, strict=True)
    return np.array([_valid_in(problem, ask, rows) for problem, rows in pairs])


def _valid_in(problem: Any, ask: _Try, rows: np.ndarray) -> np.ndarray:
    """Return a mask (m,) bool of the memories that are valid in a problem's situation."""
    tries = MEMORIES.of(problem.situation).tries(problem, DEFAULT)
    return tries.catch_times(ask.knots, ask.goals, np.ascontiguousarray(rows, np.int64)) >= 0.0


def _looks(problems: list[Any]) -> list[Features]:
    return [MEMORIES.of(p.situation).features(p.situation, p.scene) for p in problems]


def _without(found: np.ndarray, own: np.ndarray) -> np.ndarray:
    """Remove the first situations' own memories from lists (n, m); return (n, m - 1)."""
    mine = np.full((len(found), 1), -1)
    mine[: len(own), 0] = own
    order = np.argsort(found == mine, axis=1, kind="stable")
    return np.take_along_axis(found, order, axis=1)[:, :-1]
