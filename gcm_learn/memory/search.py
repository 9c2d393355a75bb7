"""Largest inner products: exactly by a matrix product, or by faiss where there are many rows."""

from __future__ import annotations

import importlib.util
from typing import Any

import numpy as np
from numba import njit

from gcm_learn.errors import MissingExtraError, RecallError

MANY = 100_000  # rows from which faiss is used if it is installed
SEARCHES = ("auto", "exact", "faiss")


def has_faiss() -> bool:
    """Whether the extra `index` is installed."""
    return importlib.util.find_spec("faiss") is not None


@njit(cache=True)
def top(scores, k):
    """Positions (min(k, n),) of the largest scores, largest first; of equal ones the first."""
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


class Searcher:
    """Search in rows that do not change.

    Parameters
    ----------
    rows : (n, d) ndarray of float32
    how : {"auto", "exact", "faiss"}
    """

    def __init__(self, rows: np.ndarray, how: str = "auto") -> None:
        if how not in SEARCHES:
            raise RecallError(f"search: {how!r} is not one of {', '.join(SEARCHES)}")
        if how == "faiss" and not has_faiss():
            raise MissingExtraError("search 'faiss'", "faiss-cpu", "index")
        self.rows = rows
        wanted = how == "faiss" or (how == "auto" and len(rows) >= MANY and has_faiss())
        self._faiss = _flat(rows) if wanted else None

    def __call__(self, query: np.ndarray, k: int) -> np.ndarray:
        """Rows (min(k, n),) whose inner products with a query (d,) are largest, in order."""
        if self._faiss is not None:
            found = self._faiss.search(query[None].astype(np.float32), min(k, len(self.rows)))
            return np.asarray(found[1][0], dtype=np.int64)
        return top(self.rows @ query.astype(np.float32), k)


def _flat(rows: np.ndarray) -> Any:
    import faiss  # an extra; it also keeps a copy of the rows

    index = faiss.IndexFlatIP(rows.shape[1])
    index.add(np.ascontiguousarray(rows))
    return index
