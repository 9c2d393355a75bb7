"""Maps one after another in a random order, read from the shards as they come."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np
import pyarrow as pa

from gcm_learn.dataset.examples import Example
from gcm_learn.seeding import rng

if TYPE_CHECKING:
    from gcm_learn.dataset.reader import Dataset

WINDOW = 4000  # examples among which the next one is drawn
_MAP = ("index", "arrival", "effective_obstacles", "quantum", "horizon")


def stream(
    records: Dataset,
    seed: int,
    epoch: int = 0,
    *,
    window: int = WINDOW,
    labels: Sequence[str] = (),
    part: tuple[int, int] = (0, 1),
) -> Iterator[Example]:
    """All maps of a dataset once, in an order that seed, epoch and part decide.

    Row groups are read in a random order, and every example that is read takes the place of a
    random one in the window, which is given out. With a window as large as the dataset every order
    is equally likely.

    Parameters
    ----------
    records : Dataset
    seed, epoch : int
        Non-negative.
    window : int
        Examples that are held in memory, 13 KB each at 80 x 80 cells.
    labels : sequence of str
        Label columns that examples carry.
    part : (int, int)
        (i, n): the i-th of n parts, which together are the whole.

    Yields
    ------
    Example
    """
    source = rng(seed, epoch, 0)
    groups = records.groups()
    order = source.permutation(len(groups))  # the same in all parts, which share it out
    draw = rng(seed, epoch, 1, *part)
    held: list[Example] = []
    for k in order[part[0] :: part[1]]:
        for example in _examples(records.read_group(groups[k], [*_MAP, *labels]), labels):
            if len(held) < window:
                held.append(example)
                continue
            place = int(draw.integers(window))
            held[place], example = example, held[place]
            yield example
    for k in draw.permutation(len(held)):
        yield held[k]


def _examples(table: pa.Table, labels: Sequence[str]) -> Iterator[Example]:
    names = [*dict.fromkeys((*_MAP, *labels))]
    columns = {name: table[name].to_pylist() for name in names}
    for k in range(len(table)):
        arrival = np.frombuffer(columns["arrival"][k], "<u2")
        n = round(len(arrival) ** 0.5)
        yield Example(
            index=columns["index"][k],
            arrival=arrival.reshape(n, n),
            obstacles=np.frombuffer(columns["effective_obstacles"][k], np.uint8),
            quantum=columns["quantum"][k],
            horizon=columns["horizon"][k],
            labels={name: columns[name][k] for name in labels},
        )
