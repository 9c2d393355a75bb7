"""The figure and the film of kinds in the plane and in space."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from kinds import Kinds
from matplotlib.axes import Axes

from gcm_learn.plots import style
from gcm_learn.plots.figures.film import painted, write_film
from gcm_learn.plots.figures.scenery import Scenery, draw_poses
from gcm_learn.plots.figures.workspace import draw_movement

WORLDS = {"plane": style.FAINT, "space": style.PATH}
FRAMES, SIDE, DPI = 22, 1.72, 80  # of the film; a panel's side [inches]


def examples(some: Any, kinds: Kinds, names: np.ndarray, wanted: Sequence[str]) -> list[int]:
    """The medoid of each kind."""
    places, out = kinds.scaled(some.features), []
    for name in wanted:
        mine = np.flatnonzero(names == name)
        rows = places[mine]
        apart = [np.linalg.norm(rows - row, axis=1).sum() for row in rows]
        out.append(int(mine[int(np.argmin(apart))]))
    return out


def write_figure(
    file: Path,
    worlds: Mapping[str, Any],
    found: Mapping[str, Kinds],
    names: Mapping[str, np.ndarray],
    shares: np.ndarray,
    order: list[str],
) -> None:
    """Medoids of the kinds in both worlds, how frequent they are, and what becomes of them."""
    figure = style.new_figure(11.0, 7.6)
    above, below = figure.subfigures(2, 1, height_ratios=(1.35, 1.0))
    panels = above.subplots(2, len(order))
    for row, (world, some) in zip(panels, worlds.items(), strict=True):
        chosen = examples(some, found[world], names[world], order)
        for ax, k, name in zip(row, chosen, order, strict=True):
            situation, moves = some.records[k].situation, some.plans[k].trajectory
            if world == "plane":
                style.frame(ax, situation.arm.upper_arm)
                draw_movement(ax, situation, some.plans[k])
                style.title(ax, name)
            else:
                draw_poses(ax, situation, moves, pixels=320)
                ax.axis("off")
        row[0].text(-0.08, 0.5, f"in the {world}" if world == "plane" else "in space",
                    transform=row[0].transAxes, rotation=90, va="center", ha="right",
                    fontsize=style.TITLE)  # fmt: skip
    left, right = below.subplots(1, 2, width_ratios=(1.0, 1.15))
    _draw_shares(left, names, order)
    _draw_moves(right, shares, order)
    figure.savefig(file, dpi=90, pil_kwargs={"optimize": True})


def _draw_shares(ax: Axes, names: Mapping[str, np.ndarray], order: list[str]) -> None:
    for k, (world, colour) in enumerate(WORLDS.items()):
        values = [100 * np.mean(names[world] == name) for name in order]
        at = np.arange(len(order)) + 0.4 * (k - 0.5)
        ax.barh(at, values, 0.38, color=colour, label="plane" if world == "plane" else "space")
        for y, value in zip(at, values, strict=True):
            ax.text(value + 0.4, y, f"{value:.0f}", va="center", fontsize=style.SMALL)
    ax.set_yticks(range(len(order)), order)
    ax.invert_yaxis()
    ax.set(xlabel="share of catches [%]")
    style.title(ax, "as frequent in space as in the plane?")
    ax.legend(frameon=False, fontsize=style.SMALL)
    ax.spines[["top", "right"]].set_visible(False)


def _draw_moves(ax: Axes, shares: np.ndarray, order: list[str]) -> None:
    ax.imshow(shares, cmap="Blues", vmin=0.0, vmax=1.0, aspect="auto")
    for i, row in enumerate(shares):
        for j, share in enumerate(row):
            ax.text(j, i, f"{100 * share:.0f}", ha="center", va="center", fontsize=style.SMALL,
                    color="white" if share > 0.55 else style.INK)  # fmt: skip
    ax.set_xticks(range(len(order)), [name.replace(" ", "\n", 1) for name in order], fontsize=8)
    ax.set_yticks(range(len(order)), order)
    ax.set(xlabel="kind when the arm may leave the plane", ylabel="kind in the plane")
    style.title(ax, "the same situations, in the plane and in space [%]")


def write_films(
    file: Path, some: Any, kinds: Kinds, names: np.ndarray, order: Sequence[str]
) -> None:
    """The medoids in space, side by side; each takes as long as the film does."""
    columns = (len(order) + 1) // 2
    figure = style.new_figure(SIDE * columns, 2 * (SIDE + 0.25))
    figure.set_dpi(DPI)
    panels = figure.subplots(2, columns).ravel()
    for ax in panels[len(order) :]:
        ax.axis("off")
    scenes = []
    for ax, k, name in zip(panels, examples(some, kinds, names, order), order, strict=False):
        scenery = Scenery(some.records[k].situation, some.plans[k].trajectory)
        left, right, bottom, top = scenery.window.extent
        ax.set(aspect="equal", xlim=(left, right), ylim=(bottom, top))
        ax.axis("off")
        ax.set_title(name, fontsize=style.LABEL, color=style.INK)
        scenes.append(_scene(scenery))
    shares = [(share, 0.0) for share in np.linspace(0.0, 1.0, FRAMES)]
    write_film(list(painted(figure, panels[: len(order)], scenes, shares)), file, frame_time=110)


def _scene(scenery: Scenery) -> Any:
    """Draw a panel at a share of its movement."""
    pixels = round(SIDE * DPI)
    return lambda ax, share, turn: scenery.show(ax, share * scenery.end, 0.0, pixels)
