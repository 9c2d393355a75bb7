"""Largest inner products: exactly by a matrix product or by faiss, or nearly, cell by cell."""

from __future__ import annotations

import importlib.util
from typing import Any

import numpy as np

from gcm_learn.compiled import njit
from gcm_learn.errors import MissingExtraError, RecallError

MANY = 100_000  # rows from which faiss is used if it is installed
SEARCHES = ("auto", "exact", "faiss", "cells")
CELLS = 256  # groups of rows that lie together
VISITED = 16  # of them that are searched
ROUNDS = 8  # of moving the cells' centres to their rows


def has_faiss() -> bool:
    """Return whether the extra `index` is installed."""
    return importlib.util.find_spec("faiss") is not None


@njit
def top(scores, k):
    """Return positions (min(k, n),) of the largest scores, largest first; ties by position."""
    k = min(k, scores.size)
    best = np.empty(k, dtype=np.int64)
    values = np.empty(k, dtype=scores.dtype)
    used = 0
    for i in range(scores.size):
        value = scores[i]
        if used == k and not value > values[k - 1]:
            continue
        j = used if used < k else k - 1
        while j > 0 and values[j - 1] < value:
            values[j], best[j] = values[j - 1], best[j - 1]
            j -= 1
        values[j], best[j] = value, i
        used = min(used + 1, k)
    return best


@njit(fastmath={"reassoc", "contract"})
def _top_of_cells(rows, ids, starts, near, query, k):
    """`top` over the rows of some cells: their ids."""
    count = 0
    for c in near:
        count += starts[c + 1] - starts[c]
    scores, found = np.empty(count, dtype=np.float32), np.empty(count, dtype=np.int64)
    n = 0
    for c in near:
        for i in range(starts[c], starts[c + 1]):
            total = np.float32(0.0)
            for j in range(query.size):
                total += rows[i, j] * query[j]
            scores[n], found[n] = total, ids[i]
            n += 1
    return found[top(scores, k)]


class Cells:
    """Rows in clusters; a search covers only the clusters with the best centres for a query.

    The result is nearly the best: these are the inverted lists of Sivic and Zisserman (ICCV 2003)
    and of faiss, with centres by k-means.
    """

    def __init__(self, rows: np.ndarray) -> None:
        count = min(CELLS, len(rows))
        centres = np.array(rows[np.linspace(0, len(rows) - 1, count).astype(int)])
        for _ in range(ROUNDS):
            cell = _nearest(rows, centres)
            sizes = np.bincount(cell, minlength=count)
            sums = np.stack([np.bincount(cell, column, count) for column in rows.T], axis=1)
            some = sizes > 0
            centres[some] = (sums[some] / sizes[some, None]).astype(np.float32)
        cell = _nearest(rows, centres)
        order = np.argsort(cell, kind="stable")
        self.centres, self.ids, self.rows = centres, order, np.ascontiguousarray(rows[order])
        self.starts = np.searchsorted(cell[order], np.arange(count + 1))

    def __call__(self, query: np.ndarray, k: int) -> np.ndarray:
        """Return the rows with nearly the largest inner products with a query (d,), in order."""
        near = top(self.centres @ query, VISITED)
        return np.asarray(_top_of_cells(self.rows, self.ids, self.starts, near, query, k))


def _nearest(rows: np.ndarray, centres: np.ndarray) -> np.ndarray:
    """Nearest centre of every row (n,)."""
    half = 0.5 * (centres**2).sum(axis=1)
    parts = [rows[k : k + 8192] @ centres.T - half for k in range(0, len(rows), 8192)]
    return np.concatenate([part.argmax(axis=1) for part in parts])


class Searcher:
    """Search in rows that do not change.

    Parameters
    ----------
    rows : (n, d) ndarray of float32
    how : {"auto", "exact", "faiss", "cells"}
        "cells" finds nearly the best, in a fraction of the time.
    """

    def __init__(self, rows: np.ndarray, how: str = "auto") -> None:
        if how not in SEARCHES:
            raise RecallError(f"search: {how!r} is not one of {', '.join(SEARCHES)}")
        if how == "faiss" and not has_faiss():
            raise MissingExtraError("search 'faiss'", "faiss-cpu", "index")
        self.rows = rows
        wanted = how == "faiss" or (how == "auto" and len(rows) >= MANY and has_faiss())
        self._faiss = _flat(rows) if wanted else None
        self._cells = Cells(rows) if how == "cells" and len(rows) > CELLS else None

    def __call__(self, query: np.ndarray, k: int) -> np.ndarray:
        """Return rows (min(k, n),) with the largest inner products with a query (d,), in order."""
        if self._cells is not None:
            return self._cells(query.astype(np.float32, copy=False), k)
        if self._faiss is not None:
            found = self._faiss.search(query[None].astype(np.float32), min(k, len(self.rows)))
            return np.asarray(found[1][0], dtype=np.int64)
        return top(self.rows @ query.astype(np.float32), k)


def _flat(rows: np.ndarray) -> Any:
    import faiss  # an extra; it also keeps a copy of the rows

    index = faiss.IndexFlatIP(rows.shape[1])
    index.add(np.ascontiguousarray(rows))
    return index
