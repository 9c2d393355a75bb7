"""Queue by time: items in buckets; the last item put into a bucket comes out first."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gcm_learn.compiled import njit

USED, SPARE, LEFT = 0, 1, 2  # entries of a tally


class BucketQueue(NamedTuple):
    """Items in buckets, which are used in a circle."""

    entries: np.ndarray  # (m, 2) int32: item, and the next entry of its bucket
    heads: np.ndarray  # (buckets,): first entry of every bucket, -1 if it is empty
    tally: np.ndarray  # (3,): entries ever used, the first spare entry, the number of spare ones


@njit
def queue_of(size, buckets):
    """Make an empty queue for so many entries."""
    tally = np.zeros(3, dtype=np.int64)
    tally[SPARE] = -1
    heads = np.full(buckets, -1, dtype=np.int64)
    return BucketQueue(np.empty((size, 2), dtype=np.int32), heads, tally)


@njit
def grown(queue):
    """Return the same queue for twice as many entries."""
    entries = np.concatenate((queue.entries, np.empty_like(queue.entries)))
    return BucketQueue(entries, queue.heads, queue.tally)


@njit(_nrt=False, forceinline=True)
def left_in(queue):
    """Return the number of items that can still be put in."""
    return queue.tally[LEFT] + queue.entries.shape[0] - queue.tally[USED]


@njit(_nrt=False, forceinline=True)
def put(item, slot, queue):
    """Put an item into a bucket of a queue that is not full."""
    entries, tally = queue.entries, queue.tally
    entry = tally[SPARE]
    if entry >= 0:
        tally[SPARE] = entries[entry, 1]
        tally[LEFT] -= 1
    else:
        entry = tally[USED]
        tally[USED] = entry + 1
    entries[entry, 0], entries[entry, 1] = item, queue.heads[slot]
    queue.heads[slot] = entry


@njit(_nrt=False, forceinline=True)
def take(slot, queue):
    """Take an item out of a bucket that is not empty."""
    entries, tally = queue.entries, queue.tally
    entry = queue.heads[slot]
    item = entries[entry, 0]
    queue.heads[slot], entries[entry, 1] = entries[entry, 1], tally[SPARE]
    tally[SPARE], tally[LEFT] = entry, tally[LEFT] + 1
    return item
