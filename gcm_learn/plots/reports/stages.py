"""One picture of every family for chains: arm, bodies and the movement that catches."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure
from PIL import Image

from gcm_learn.arms import Chain
from gcm_learn.families import draw, family_names
from gcm_learn.planners import Plan, solve
from gcm_learn.plots.figures import style
from gcm_learn.plots.figures.film import palette_of
from gcm_learn.plots.figures.stage import Stage
from gcm_learn.situation import Situation

MOST = 100  # draws that are looked through for one worth showing
PIXELS = 330
DPI = 90


def write_chains(path: Path) -> None:
    """Write the picture of the families for chains as a small file."""
    whole = io.BytesIO()
    chains_figure().savefig(whole, format="png", dpi=DPI)
    with Image.open(whole) as image:
        shown = image.convert("RGB")
        kept = shown.quantize(palette=palette_of([shown]), dither=Image.Dither.NONE)
        kept.save(path, optimize=True)


def chains_figure(seed: int = 100, columns: int = 4) -> Figure:
    """Draw one situation of every family for chains, with the movement that catches.

    Parameters
    ----------
    seed : int
        Root of the random situations of the first family; the next one has the next seed.
    columns : int
        Panels in a row.

    Returns
    -------
    Figure
        Of each family the first situation in which the straight line fails and `search` catches.
    """
    names = family_names("chain")
    figure, panels = style.panel_grid(len(names), columns, (3.0, 2.6))
    for k, (ax, name) in enumerate(zip(panels, names, strict=True)):
        situation, plan = first_detour(name, seed + k)
        Stage(situation, plan).draw_movement(ax, PIXELS)
        style.title(ax, name)
    return figure


def first_detour(name: str, seed: int) -> tuple[Situation[Chain], Plan]:
    """The first situation of a family that `search` catches and the straight line does not."""
    for k in range(MOST):
        situation: Any = draw(name, seed, k)
        if solve(situation, "straight").caught:
            continue
        plan = solve(situation)
        if plan.caught:
            return situation, plan
    raise RuntimeError(f"nothing to show among {MOST} situations of {name}")
