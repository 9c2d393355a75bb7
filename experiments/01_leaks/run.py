"""Count the fronts that leak through walls, against the walls' speed; writes table.md.

python -m experiments 01_leaks                   about four minutes on one core
python -m experiments 01_leaks --scenes 4        a quick look
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

from walls import MOTIONS, PARTS, Walls, draw, leaked_cells, leaked_states

from experiments.common.tables import line, sections, table
from gcm_learn import seeding
from gcm_learn.wave import (
    MarchingParams,
    WaveParams,
    march,
    propagate,
    propagate_layers,
)

HERE = Path(__file__).resolve().parent
SPEEDS = (0.0, 0.25, 0.5, 1.0, 2.0, 4.0, 8.0)  # of walls [cells per tau]; the front has 0.17
WIDTHS = (0.0, 1.0, 2.0, 3.0)  # of walls [cells]
PLAIN = WaveParams(until="horizon")
# Fast walls sweep the ring before a single neuron has become a wave: a larger ring, a larger start.
QUICK = replace(PLAIN, n=160, start_radius=4.0)

Engine = Callable[[Walls, WaveParams], int]


@dataclass(frozen=True)
class Row:
    """A way to run a front and count the cells that it reaches behind a wall, with a name."""

    name: str
    engine: Engine
    width: float = 0.0


def wave(**changes: object) -> Engine:
    """Run the wave with some parameters changed."""

    def run(walls: Walls, params: WaveParams) -> int:
        return leaked_cells(walls, propagate(*walls.setting, replace(params, **changes)))  # type: ignore[arg-type]

    return run


def waiting(**changes: object) -> Engine:
    """Run the wave that may wait with some parameters changed."""

    def run(walls: Walls, params: WaveParams) -> int:
        return leaked_states(walls, propagate_layers(*walls.setting, replace(params, **changes)))  # type: ignore[arg-type]

    return run


def marching(**changes: object) -> Engine:
    """Run causal marching with some parameters changed."""
    bare = MarchingParams(until="horizon", **changes)  # type: ignore[arg-type]
    return lambda walls, params: leaked_cells(
        walls, march(*walls.setting, replace(bare, n=params.n))
    )


ENGINES = (
    Row("wave", wave()),
    Row("wave, 9 points", wave(laplacian=9)),
    Row("wave, held", wave(frozen="held")),
    Row("wave, held, 9 points", wave(frozen="held", laplacian=9)),
    Row("wave, step 0.8", wave(step=0.8)),
    Row("wave, diffusion 1", wave(diffusion=1.0)),
    Row("wave that waits", waiting()),
    Row("wave that waits, 9 points", waiting(laplacian=9)),
    Row("wave that waits, held", waiting(frozen="held")),
    Row("marching", marching()),
    Row("marching, no lookback", marching(lookback=0.0)),
)
PROMISE = tuple(
    Row(f"{row.name}, {width:.0f} cells", row.engine, width)
    for row in (ENGINES[0], ENGINES[2], ENGINES[6], ENGINES[9])
    for width in WIDTHS[1:]
)
BARE = tuple(
    Row(f"{name}, {width:.0f} cells", engine, width)
    for name, engine in (
        ("wave", wave(margin=0.0)),
        ("marching", marching(margin=0.0)),
        ("marching, no lookback", marching(margin=0.0, lookback=0.0)),
    )
    for width in WIDTHS
)


def leaks(row: Row, speed: float, scenes: int) -> str:
    """Share of fronts that leak, and the cells of the worst, as a table's entry."""
    leaked, fronts, worst = 0, 0, 0
    params = QUICK if speed > 1.0 else PLAIN
    for part in PARTS:
        for motion in MOTIONS:
            if (motion == "static") != (speed == 0.0) or (motion, part) == ("passing", "forearm"):
                continue
            for k in range(scenes):
                walls = draw(seeding.rng(71, k), part, motion, speed, row.width, params)
                cells = row.engine(walls, params)
                leaked, fronts, worst = leaked + (cells > 0), fronts + 1, max(worst, cells)
    return f"{100.0 * leaked / fronts:.0f} % ({worst})" if leaked else "0"


def measured(rows: tuple[Row, ...], scenes: int) -> str:
    """Return a table with one line for each way and one column for each speed."""
    lines = []
    for row in rows:
        lines.append([row.name, *(leaks(row, speed, scenes) for speed in SPEEDS)])
        print(line(lines[-1]), flush=True)
    return table(["", *(f"{speed:g}" for speed in SPEEDS)], lines)


def main() -> None:
    """Measure and write."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--scenes", type=int, default=25, help="of every part and motion")
    parser.add_argument("--out", type=Path, default=HERE / "table.md")
    arguments = parser.parse_args()
    rows = {
        "Walls without thickness, margin 1": ENGINES,
        "Thicker walls, margin 1": PROMISE,
        "Cells' centres only, margin 0": BARE,
    }
    text = (
        "# Fronts that leak through walls, by the walls' speed [cells per tau]\n\n"
        "Share of the fronts and, in parentheses, the cells that the worst one reached behind a"
        f" wall. {arguments.scenes} scenes of every part of the arm and kind of motion.\n\n"
    )
    tables = {title: measured(ways, arguments.scenes) for title, ways in rows.items()}
    arguments.out.write_text(text + sections(tables), encoding="utf-8")


if __name__ == "__main__":
    main()
