"""Parts of a memory that comparisons ask for."""

from __future__ import annotations

import numpy as np

from gcm_learn.recall import Memory, index_class


def random_by_family(memory: Memory) -> dict[str, Memory]:
    """Memories of each family, filed at random; the empty name has all of them."""
    families = np.array([memory[k].family for k in range(len(memory))])
    whole = memory.refiled(index_class("random").fit([], 0))
    made = {"": whole}
    for family in sorted(set(families.tolist())):
        made[family] = Memory(whole.index, kind=whole.kind)
        made[family].extend(whole)
        made[family].forget(families != family)
    return made
