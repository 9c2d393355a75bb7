"""Registered indexes by name."""

from __future__ import annotations

from gcm_learn.errors import UnknownNameError
from gcm_learn.recall.change import ChangeIndex
from gcm_learn.recall.index import Index, LearnedIndex, PcaIndex, RandomIndex, RawIndex

_CLASSES: dict[str, type[Index]] = {
    made.name: made for made in (RawIndex, ChangeIndex, RandomIndex, PcaIndex, LearnedIndex)
}


def index_class(name: str) -> type[Index]:
    """The class of a registered index; raises UnknownNameError with the known names."""
    if name not in _CLASSES:
        raise UnknownNameError.among("index", name, _CLASSES)
    return _CLASSES[name]
