"""The memory: catches filed under embeddings, found again by inner product."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from gcm_learn.arms import PLANAR, Kind
from gcm_learn.errors import RecallError
from gcm_learn.recall.files import packed, read_arrays, read_manifest, unpacked, write_memory
from gcm_learn.recall.index import Index, index_class
from gcm_learn.recall.kinds import MEMORIES, kind_of_format, same_kind
from gcm_learn.recall.search import Searcher
from gcm_learn.recall.waypoints import Waypoints
from gcm_learn.situation import AnySituation, canonical
from gcm_learn.storage import content_hash

SPARE = 1.5  # columns grow to this many times the entries that there are
MANY = 20_000  # learned entries from which nearly the best are good enough by default
_COLUMNS = ("embeddings", "traces", "goals", "labels", "lengths")


@dataclass(frozen=True)
class Entry:
    """A memory: situation, waypoints and labels."""

    situation: Any
    """In its canonical form."""
    waypoints: Any
    family: str
    stratum: str


class Memory:
    """Catches, filed by an index.

    Parameters
    ----------
    index : Index
        Files memories and asks for them. Its key is stamped into the memory.
    search : {"auto", "exact", "faiss", "cells"}
        "auto" takes cells where a learned index files many, else faiss from 100,000 entries on if
        it is installed.
    kind : Kind
        Kind of arm of the catches.

    Examples
    --------
    >>> memory = Memory(RawIndex.fit(situations))          # doctest: +SKIP
    >>> memory.add(situations, [waypoints_of(s, solve(s, "layered")) for s in situations])
    ... # doctest: +SKIP
    >>> memory.recall(memory.index.embed_query(other), 5)  # doctest: +SKIP
    """

    def __init__(self, index: Index, search: str = "auto", kind: Kind = PLANAR) -> None:
        self.index = index
        self.search = search
        self.kind = kind
        self._size, shape = 0, MEMORIES.of(kind)
        self._columns: dict[str, np.ndarray] = {
            "embeddings": np.zeros((0, index.dim), np.float32),
            "traces": np.zeros((0, *shape.knots), np.float32),
            "goals": np.zeros((0, shape.goal), np.float32),
            "labels": np.zeros((0, 2), np.int16),
            "lengths": np.zeros(0, np.int32),
        }
        self._texts: list[bytes] = []
        self._old_texts: np.ndarray = np.zeros(0, np.uint8)  # of entries that were loaded
        self._old_starts: np.ndarray = np.zeros(1, np.int64)
        self._words: list[str] = [""]
        self._searcher: Searcher | None = None

    def __len__(self) -> int:
        return self._size

    def __getitem__(self, k: int) -> Entry:
        """Return memory k; its situation is unpacked only now."""
        if not -self._size <= k < self._size:
            raise IndexError(f"memory {k} of {self._size}")
        k %= self._size
        family, stratum = (self._words[w] for w in self.labels[k])
        waypoints = Waypoints(np.array(self.knots[k]), np.array(self.goals[k]))
        return Entry(self.situation(k), waypoints, family, stratum)

    @property
    def embeddings(self) -> np.ndarray:
        """(n, dim) float32"""
        return self._columns["embeddings"][: self._size]

    @property
    def knots(self) -> np.ndarray:
        """(n, KNOTS, 4) float32: knots of `Waypoints`; of joints (n, KNOTS, joints + 2)."""
        return self._columns["traces"][: self._size]

    @property
    def columns(self) -> int:
        """Numbers of a knot, 0 while nothing is remembered."""
        return int(self.knots.shape[2]) if self._size else 0

    @property
    def goals(self) -> np.ndarray:
        """(n, 2) float32: goals of `Waypoints`; in space (n, 6)."""
        return self._columns["goals"][: self._size]

    @property
    def labels(self) -> np.ndarray:
        """(n, 2) int16: family and stratum as positions in the list of words."""
        return self._columns["labels"][: self._size]

    @property
    def families(self) -> list[str]:
        """Family of each memory, "" if unknown."""
        return [self._words[word] for word in self.labels[:, 0]]

    @property
    def strata(self) -> list[str]:
        """Stratum of each memory, "" if unknown."""
        return [self._words[word] for word in self.labels[:, 1]]

    def situation(self, k: int) -> Any:
        """Situation of memory k, canonical."""
        return unpacked(self._text(k))

    def situations(self) -> list[Any]:
        """All situations, canonical."""
        return [self.situation(k) for k in range(self._size)]

    def add(
        self,
        situations: Sequence[AnySituation],
        trajectories: Sequence[Waypoints],
        families: Sequence[str] | None = None,
        strata: Sequence[str] | None = None,
    ) -> None:
        """Remember catches.

        Parameters
        ----------
        situations : sequence of Situation
            In any frame; the canonical form is kept.
        trajectories : sequence of Waypoints
            As of `waypoints_of`.
        families, strata : sequence of str, optional
            Labels, which nothing depends on.
        """
        count = len(situations)
        if count == 0:
            return
        for situation in situations:
            same_kind(self.kind, situation, self.columns)
        turned = [canonical(s)[0] for s in situations]
        words = (families or [""] * count, strata or [""] * count)
        texts = [packed(s) for s in turned]
        fresh = {
            "embeddings": self.index.embed_memories(turned, trajectories).astype(np.float32),
            "traces": np.array([t.knots for t in trajectories], np.float32),
            "goals": np.array([t.goal for t in trajectories], np.float32),
            "labels": np.array([[self._word(w) for w in row] for row in zip(*words, strict=True)]),
            "lengths": np.array([len(t) for t in texts]),
        }
        if fresh["embeddings"].shape != (count, self.index.dim):
            got = fresh["embeddings"].shape
            raise RecallError(f"embeddings: shape {got}, expected {(count, self.index.dim)}")
        self._append(fresh, texts)

    def extend(self, other: Memory, embeddings: np.ndarray | None = None) -> None:
        """Add all entries of another memory, with its embeddings or the given ones (n, dim)."""
        fresh = {name: other._columns[name][: len(other)] for name in _COLUMNS}
        words = [[self._word(other._words[w]) for w in row] for row in other.labels.tolist()]
        fresh["labels"] = np.reshape(words, (-1, 2))
        fresh["embeddings"] = other.embeddings if embeddings is None else embeddings
        self._append(fresh, [other._text(k) for k in range(len(other))])

    def recall(self, query: np.ndarray, k: int = 20) -> np.ndarray:
        """Memories (min(k, n),) that fit an embedding (dim,) best, the best first."""
        if self._searcher is None or len(self._searcher.rows) != self._size:
            nearly = self.search == "auto" and self.index.name == "learned" and self._size >= MANY
            self._searcher = Searcher(self.embeddings, "cells" if nearly else self.search)
        return self._searcher(query, k)

    def forget(self, which: np.ndarray) -> None:
        """Forget memories by position or by truth value (n,)."""
        keep = np.ones(self._size, dtype=bool)
        keep[np.asarray(which)] = False
        texts = [self._text(k) for k in np.flatnonzero(keep).tolist()]
        self._columns = {name: self._columns[name][: self._size][keep] for name in _COLUMNS}
        self._size, self._texts = int(keep.sum()), texts
        self._old_texts, self._old_starts = np.zeros(0, np.uint8), np.zeros(1, np.int64)
        self._searcher = None

    @property
    def digest(self) -> str:
        """Short hash of the catches, however they are filed."""
        return content_hash(self.knots.tobytes(), self.goals.tobytes())[:16]

    def refiled(self, index: Index, keys: np.ndarray | None = None) -> Memory:
        """Return a copy filed by another index; `keys` (n, dim) are its embeddings, if known."""
        out = Memory(index, self.search, self.kind)
        if len(self) and keys is None:
            trajectories = [Waypoints(k, g) for k, g in zip(self.knots, self.goals, strict=True)]
            keys = index.embed_memories(self.situations(), trajectories)
        if len(self):
            out.extend(self, keys)
        return out

    def save(self, folder: str | os.PathLike[str]) -> None:
        """Write the memory and its index into a folder; an old memory stays until this is done."""
        arrays = {name: self._columns[name][: self._size] for name in _COLUMNS}
        text = b"".join(self._text(k) for k in range(self._size))
        arrays["situations"] = np.frombuffer(text, np.uint8)
        about = {
            "format": MEMORIES.of(self.kind).format,
            "size": self._size,
            "knots": MEMORIES.of(self.kind).knots[0],
            "words": self._words,
            "index": {"name": self.index.name, "key": self.index.key, "dim": self.index.dim},
        }
        write_memory(Path(folder), arrays, about, self.index.save)

    @classmethod
    def load(
        cls,
        folder: str | os.PathLike[str],
        index: Index | None = None,
        *,
        search: str = "auto",
        mmap: bool = True,
    ) -> Memory:
        """Read a memory.

        Parameters
        ----------
        folder : path-like
        index : Index, optional
            Index by which the memory must have been filed; by default the saved index.
        mmap : bool
            Leave arrays on disk until they are read.

        Raises
        ------
        RecallError
            In one line: the memory is missing, damaged, or filed by another index.
        """
        place = Path(folder)
        manifest = read_manifest(place)
        stamp: dict[str, Any] = manifest["index"]
        kind = kind_of_format(place, manifest["format"])
        found, expected = manifest["knots"], MEMORIES.of(kind).knots[0]
        if found != expected:
            raise RecallError(f"{place}: paths of {found} knots, expected {expected}")
        if index is None:
            index = index_class(stamp["name"]).load(place / manifest["data"])
        if stamp["key"] != index.key:
            raise RecallError(
                f"{place}: filed by an index with key {stamp['key']}, asked by {index.name!r} with "
                f"key {index.key}: file it anew (Memory.refiled)"
            )
        out = cls(index, search, kind)
        columns = read_arrays(place, manifest, mmap)
        out._columns = {name: columns[name] for name in _COLUMNS}
        out._size, out._words = int(manifest["size"]), list(manifest["words"])
        out._old_texts = columns["situations"]
        out._old_starts = np.concatenate([[0], np.cumsum(columns["lengths"], dtype=np.int64)])
        return out

    def _append(self, fresh: dict[str, np.ndarray], texts: list[bytes]) -> None:
        size = self._size + len(texts)
        for name in _COLUMNS:
            old = self._columns[name]
            if size > len(old) or not old.flags.writeable:
                rows = max(int(SPARE * size), 64)
                grown = np.zeros((rows, *fresh[name].shape[1:]), old.dtype)
                if self._size:
                    grown[: self._size] = old[: self._size]
                self._columns[name] = grown
            self._columns[name][self._size : size] = fresh[name]
        self._texts += texts
        self._size, self._searcher = size, None

    def _text(self, k: int) -> bytes:
        old = len(self._old_starts) - 1
        if k >= old:
            return self._texts[k - old]
        return self._old_texts[self._old_starts[k] : self._old_starts[k + 1]].tobytes()

    def _word(self, word: str) -> int:
        if word not in self._words:
            self._words.append(word)
        return self._words.index(word)
