"""Guide from a cognitive map: the time to go from every cell to the contact with the target.

The map makes the situation static: its effective obstacles stand where and when the hand would
meet the moving ones. In that static picture the way to go is the shortest path around them. So the
time to go solves the eikonal equation, here by fast sweeping (Zhao, Math. Comp. 74, 2005).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from gcm_learn.charts import hand_space
from gcm_learn.compiled import njit
from gcm_learn.maps import CognitiveMap, build_map
from gcm_learn.situation import Situation
from gcm_learn.wave import MarchingParams

CELLS = 40  # along a side of a field; maps have twice as many
_SWEEPS = 24  # in each of four directions at most
_FAR = 1e9


def fields_of(
    situations: Sequence[Situation], progress: Callable[[], object] | None = None
) -> np.ndarray:
    """Times to go (s, CELLS, CELLS) as shares of the horizon, at most 1.

    Parameters
    ----------
    situations : sequence of Situation
        In their canonical form.
    progress : callable, optional
        Called after each.
    """
    out = np.empty((len(situations), CELLS, CELLS), dtype=np.float32)
    for k, situation in enumerate(situations):
        out[k] = field_of(situation)
        if progress is not None:
            progress()
    return out


def field_of(situation: Situation) -> np.ndarray:
    """Time to go (CELLS, CELLS) as a share of the horizon, by the map of causal marching.

    If its front meets no target, the map of a front that may wait gives the contact, and the way
    there is straight. If that meets none either, every cell is as far as possible.
    """
    params = MarchingParams(n=2 * CELLS)
    cognitive_map = build_map(situation, params)
    walls = cognitive_map.effective_obstacles
    if cognitive_map.interception is None:
        cognitive_map, walls = build_map(situation, params, wait=True), np.zeros_like(walls)
    if cognitive_map.interception is None:
        return np.ones((CELLS, CELLS))
    seconds = time_to_go(cognitive_map, walls, situation.arm.max_hand_speed)
    share = np.minimum(seconds / situation.horizon, 1.0)
    return share.reshape(CELLS, 2, CELLS, 2).min(axis=(1, 3))


def time_to_go(cognitive_map: CognitiveMap, walls: np.ndarray, speed: float) -> np.ndarray:
    """Seconds (n, n) from every cell to the contact, around walls (n, n); 1e9 within them."""
    assert cognitive_map.interception is not None
    n, lattice = cognitive_map.lattice.n, cognitive_map.lattice
    open_cells = hand_space(lattice).inside.reshape(n, n) & ~walls
    open_cells[cognitive_map.interception.cell] = True
    cells = np.full((n, n), _FAR)
    cells[cognitive_map.interception.cell] = 0.0
    sweep(cells, open_cells)
    return np.where(cells < _FAR, cells * lattice.spacing / speed, _FAR)


@njit
def sweep(cells, open_cells):
    """Fill in distances [cells] to cells of value 0, by Godunov's scheme, until nothing changes."""
    n = cells.shape[0]
    for _ in range(_SWEEPS):
        changed = False
        for direction in range(4):
            for i in range(n):
                iy = i if direction < 2 else n - 1 - i
                for j in range(n):
                    ix = j if direction % 2 == 0 else n - 1 - j
                    if not open_cells[iy, ix]:
                        continue
                    a = min(
                        cells[iy, ix - 1] if ix > 0 else _FAR,
                        cells[iy, ix + 1] if ix < n - 1 else _FAR,
                    )
                    b = min(
                        cells[iy - 1, ix] if iy > 0 else _FAR,
                        cells[iy + 1, ix] if iy < n - 1 else _FAR,
                    )
                    if min(a, b) >= _FAR:
                        continue
                    d = min(a, b) + 1.0
                    if abs(a - b) < 1.0:
                        d = 0.5 * (a + b + np.sqrt(2.0 - (a - b) ** 2))
                    if d < cells[iy, ix] - 1e-9:
                        cells[iy, ix] = d
                        changed = True
        if not changed:
            return
