"""Book of a memory: an even sample of its situations, and which memories catch in each.

With it a memory of bounded size drops entries that others cover. The sample is Vitter's reservoir
(ACM Transactions on Mathematical Software 11, 1985), so that old situations count like new ones.
Entries go one after the other, each time the one whose loss leaves the fewest situations without a
memory. It is the greedy way to a maximal cover (Nemhauser, Wolsey and Fisher, Mathematical
Programming 14, 1978), backwards.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from gcm_learn import seeding
from gcm_learn.recall.files import packed, unpacked
from gcm_learn.situation import AnySituation

PAGES = 4000  # situations that are kept
WORKS = 16  # memories that are noted of one
THIN = 2  # situations with fewer memories than this may need another one


class Book:
    """Situations, how they ask a memory, and which of its entries catch in them.

    Parameters
    ----------
    dim : int
        Numbers of an embedding.
    """

    def __init__(self, dim: int) -> None:
        self.met = 0
        """Situations that were offered to it."""
        self.queries: np.ndarray = np.zeros((0, dim), np.float32)
        """(n, dim): how they ask."""
        self.works: np.ndarray = np.zeros((0, WORKS), np.int32)
        """(n, WORKS): positions of memories that catch in them, -1 where there are no more."""
        self._texts: list[bytes] = []

    def __len__(self) -> int:
        return len(self._texts)

    def situation(self, page: int) -> Any:
        """Situation of a page, canonical."""
        return unpacked(self._texts[page])

    def offered(self) -> int | None:
        """Return the page of the next situation; None if it is dropped."""
        self.met += 1
        if self.met <= PAGES:
            return len(self)
        page = int(seeding.rng(0, self.met).integers(self.met))
        return page if page < PAGES else None

    def write(
        self, page: int, situation: AnySituation, query: np.ndarray, works: np.ndarray
    ) -> None:
        """Keep a situation on a page, in place of what is there.

        Parameters
        ----------
        page : int
            As of `offered`.
        situation : Situation
            In its canonical form.
        query : (dim,) ndarray
        works : (m,) ndarray of int
            Memories that catch in it, the first `WORKS` of which are noted.
        """
        if page == len(self):
            self._texts.append(b"")
            self.queries = np.concatenate([self.queries, query[None]])
            self.works = np.concatenate([self.works, np.full((1, WORKS), -1, np.int32)])
        self._texts[page] = packed(situation)
        self.queries[page], self.works[page] = query, -1
        self.works[page, : min(len(works), WORKS)] = works[:WORKS]

    def thin(self, place: np.ndarray, most: int) -> np.ndarray:
        """Pages (m,) with few memories, whose situations ask the most for one that is filed at a
        place (dim,): the `most` first.
        """
        pages = np.flatnonzero((self.works >= 0).sum(axis=1) < THIN)
        order = np.argsort(-(self.queries[pages] @ place), kind="stable")
        return pages[order[:most]]

    def note(self, page: int, memory: int) -> None:
        """Note that one more memory catches in a situation that is thinly covered."""
        row = self.works[page]
        if memory not in row:
            row[np.flatnonzero(row < 0)[0]] = memory

    def superfluous(self, count: int, uses: np.ndarray) -> np.ndarray:
        """Memories (count,) to be forgotten: time and again the one whose loss leaves the fewest
        situations without a memory.

        Of equal ones that which catches in the fewest situations, then the least used, then the
        oldest.

        Parameters
        ----------
        count : int
        uses : (n,) ndarray of int
            How often each memory was the valid one.
        """
        works, ages, out = self.works.copy(), np.arange(len(uses)), np.zeros(len(uses), bool)
        for _ in range(count):
            alone = works.max(axis=1)[(works >= 0).sum(axis=1) == 1]
            needed = np.bincount(alone, minlength=len(uses))
            helpful = np.bincount(works[works >= 0], minlength=len(uses))
            worst = np.lexsort((ages, uses, helpful, needed, out))[0]
            out[worst] = True
            works[works == worst] = -1
        return np.flatnonzero(out)

    def keep(self, which: np.ndarray) -> None:
        """Follow a memory that kept some of its entries, by truth value (n,)."""
        new = np.append(np.where(which, np.cumsum(which) - 1, -1), -1).astype(np.int32)
        self.works = new[self.works]

    def asked_by(self, embed: Callable[[Any], np.ndarray], dim: int) -> Book:
        """Return a copy with other queries (dim,), made by a function of situations."""
        out = Book.of(self.arrays(), dim)
        out.queries = np.zeros((len(self), dim), np.float32)
        for page in range(len(self)):
            out.queries[page] = embed(self.situation(page))
        return out

    def arrays(self) -> dict[str, np.ndarray]:
        """All of it, by the names of columns in a memory's folder."""
        return {
            "book_queries": self.queries,
            "book_works": self.works,
            "book_lengths": np.array([len(text) for text in self._texts], np.int32),
            "book_situations": np.frombuffer(b"".join(self._texts), np.uint8),
            "book_met": np.array([self.met]),
        }

    @classmethod
    def of(cls, arrays: Mapping[str, np.ndarray], dim: int) -> Book:
        """Make a book of such arrays; an empty one without arrays."""
        out = cls(dim)
        if "book_met" in arrays:
            out.met = int(arrays["book_met"][0])
            out.queries, out.works = (
                np.array(arrays["book_queries"]),
                np.array(arrays["book_works"]),
            )
            text, at = arrays["book_situations"].tobytes(), 0
            for length in arrays["book_lengths"].tolist():
                out._texts.append(text[at : at + length])
                at += length
        return out
