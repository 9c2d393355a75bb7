"""Streams of datasets for ``torch.utils.data.DataLoader``."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any

import torch
from torch.utils.data import IterableDataset, get_worker_info

from gcm_learn.dataset import WINDOW, Dataset, Example

Item = dict[str, Any]


def tensors_of(example: Example) -> Item:
    """The default item: ``image`` (3, n, n) float32, ``index``, and the labels as they are."""
    image = torch.from_numpy(example.image())
    return {"index": example.index, "image": image, **example.labels}


class TorchStream(IterableDataset):
    """Stream of the maps of a dataset; every pass has a new order.

    Each of a DataLoader's workers reads a part of its own. Passes are counted; workers, which may
    be started anew for every pass, add the number that the DataLoader draws for each. So an order
    repeats itself if `seed` and the DataLoader's generator (``torch.manual_seed``) do.

    Parameters
    ----------
    records : Dataset
    seed : int
    window : int
        Examples of the window shuffle, shared out among the workers.
    labels : sequence of str
    transform : callable
        Makes an item of an `Example`.
    """

    def __init__(
        self,
        records: Dataset,
        seed: int,
        *,
        window: int = WINDOW,
        labels: Sequence[str] = (),
        transform: Callable[[Example], Any] = tensors_of,
    ) -> None:
        self.records, self.seed, self.window = records, seed, window
        self.labels, self.transform, self.epoch = tuple(labels), transform, 0

    def __len__(self) -> int:
        return len(self.records)

    def __iter__(self) -> Iterator[Any]:
        """Return an iterator over one pass; in a worker of a DataLoader, over the worker's part."""
        worker = get_worker_info()
        part = (0, 1) if worker is None else (worker.id, worker.num_workers)
        drawn = 0 if worker is None else worker.seed - worker.id
        epoch, self.epoch = drawn + self.epoch, self.epoch + 1
        window = max(self.window // part[1], 1)
        examples = self.records.stream(
            self.seed, epoch, window=window, labels=self.labels, part=part
        )
        return map(self.transform, examples)
