"""The style of all pictures: the paper's colours, font sizes, axes and arrows."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Circle, FancyArrowPatch, Rectangle
from matplotlib.patheffects import withStroke

from gcm_learn.rendering import ARM, INK, OBSTACLE, PATH, TARGET

__all__ = ["ARM", "INK", "OBSTACLE", "PATH", "TARGET"]

EXTENDED = "#f6ad55"  # orange: what an obstacle forbids the hand
EFFECTIVE = "#c53030"  # red: where the front met an obstacle
EXPLORED = "#dbeaf5"  # behind the front
FRONT = "#3f7fb5"
GOOD = "#2f855a"  # what was caught
FAINT = "#a0aec0"  # rims and hints
FAULTS = {"broken": "#6b46c1", "error": "#2d3748"}  # of methods from outside

MAP_COLOURS = LinearSegmentedColormap.from_list(
    "arrival", ["#fbfdfe", "#d5e8ee", "#a3cdd6", "#6aa9b8", "#3d7f93"]
)

Panel = tuple[str, Callable[[Axes], object]]
"""Title of a panel, and a function that draws it."""
Scene = Callable[[Axes, float, float], None]
"""Function that draws a time [s], turned by an angle [degrees]."""

DPI = 100
TITLE, LABEL, SMALL = 11.0, 9.5, 8.5  # [pt]
HALO = withStroke(linewidth=2.5, foreground="white")


def new_figure(width: float, height: float) -> Figure:
    """Return an empty figure of a size in inches, outside matplotlib's global state."""
    return Figure(figsize=(width, height), dpi=DPI, layout="constrained")


def panel_grid(
    count: int,
    columns: int,
    size: tuple[float, float],
    margin: tuple[float, float] = (0.0, 0.0),
    *,
    shared: bool = False,
) -> tuple[Figure, list[Axes]]:
    """Return a figure with `count` panels in rows; the rest of the last row stays empty.

    Parameters
    ----------
    count, columns : int
        Panels in all, and in a row.
    size : (float, float)
        Width and height of a panel [inches].
    margin : (float, float)
        What the figure is wider and higher than its panels [inches].
    shared : bool
        All panels have the same axes.
    """
    rows = -(-count // columns)
    figure = new_figure(size[0] * columns + margin[0], size[1] * rows + margin[1])
    grid = figure.subplots(rows, columns, sharex=shared, sharey=shared, squeeze=False)
    panels = list(grid.ravel())
    for ax in panels[count:]:
        ax.axis("off")
    return figure, panels[:count]


def fill_panels(axes: Sequence[Axes], panels: Sequence[Panel]) -> None:
    """Draw panels into axes, with their titles."""
    for ax, (name, draw) in zip(axes, panels, strict=True):
        draw(ax)
        title(ax, name)


def plain(ax: Axes) -> None:
    """Hide the top and right borders of a chart and make the numbers on its axes small."""
    ax.spines[["top", "right"]].set_visible(False)
    ax.tick_params(labelsize=SMALL, colors=INK)


def frame(ax: Axes, upper_arm: float = 1.0, *, annulus: bool = False) -> Axes:
    """Turn axes into a square view of the reachable ring, without ticks.

    Parameters
    ----------
    ax : Axes
    upper_arm : float
        Length of the upper arm, rho [forearms].
    annulus : bool
        Also draw the circle of radius rho: obstacles between the two meet only the forearm
        (Eq. 3).
    """
    reach = upper_arm + 1.0
    ax.set_aspect("equal", anchor="N")  # titles of a row stay level
    ax.set_xlim(-1.04 * reach, 1.04 * reach)
    ax.set_ylim(-1.04 * reach, 1.04 * reach)
    ax.set_xticks([])
    ax.set_yticks([])
    ax.spines[:].set_visible(False)
    inner = abs(upper_arm - 1.0)
    for radius in (reach, inner, *((upper_arm,) if annulus else ())):
        if radius > 0.0:
            ax.add_patch(Circle((0, 0), radius, fill=False, ec=FAINT, lw=1.0, ls=(0, (4, 3))))
    return ax


def view_frame(ax: Axes, extent: tuple[float, float, float, float], name: str = "") -> None:
    """Turn axes into a view of an extent (left, right, bottom, top) in a film, with a title."""
    left, right, bottom, top = extent
    ax.set(aspect="equal", xlim=(left, right), ylim=(bottom, top))
    ax.axis("off")
    title(ax, name)


def title(ax: Axes, text: str) -> None:
    """Write a panel's title."""
    ax.set_title(text, fontsize=TITLE, color=INK)


def panel_letter(ax: Axes, letter: str) -> None:
    """Write a letter, as in the paper, into the upper left corner of a panel."""
    ax.text(
        0.01, 0.99, letter, transform=ax.transAxes, fontsize=TITLE + 3, fontweight="bold",
        color=INK, ha="left", va="top", zorder=20,
    )  # fmt: skip


def note_in_corner(ax: Axes, text: str, *, top: bool = False) -> None:
    """Write into the lower (or upper) left corner, over everything."""
    ax.text(
        0.01, 0.99 if top else 0.01, text, transform=ax.transAxes, ha="left",
        va="top" if top else "bottom", fontsize=TITLE, color=INK, zorder=20,
        path_effects=[HALO],
    )  # fmt: skip


def label(ax: Axes, at: Sequence[float] | np.ndarray, text: str, colour: str = INK) -> None:
    """Write a word beside something, readable on any ground."""
    ax.text(
        at[0], at[1], text, fontsize=SMALL, color=colour, ha="center", va="center", zorder=15,
        path_effects=[HALO],
    )  # fmt: skip


def arrow(
    ax: Axes,
    start: Sequence[float] | np.ndarray,
    end: Sequence[float] | np.ndarray,
    colour: str,
    width: float = 1.4,
) -> None:
    """Draw a straight arrow between two points of the data."""
    ax.add_patch(
        FancyArrowPatch(
            (start[0], start[1]), (end[0], end[1]), arrowstyle="-|>", mutation_scale=11,
            lw=width, color=colour, shrinkA=0, shrinkB=0, zorder=9,
        )
    )  # fmt: skip


def draw_path(ax: Axes, path: np.ndarray, colour: str = PATH, heads: int = 3) -> None:
    """Draw a path with arrow heads along it.

    Parameters
    ----------
    ax : Axes
    path : (n, 2) ndarray
        Points in order, n at least 2.
    colour : str
    heads : int
        Number of arrow heads; the last one sits at the end.
    """
    ax.plot(path[:, 0], path[:, 1], color=colour, lw=2.0, zorder=8, solid_capstyle="round")
    run = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(path, axis=0), axis=1))])
    if run[-1] == 0.0:
        return
    step = min(0.06, 0.1 * run[-1])
    for share in np.linspace(1.0, 0.0, heads, endpoint=False):
        ends = [share * run[-1] - step, share * run[-1]]
        tail, tip = np.stack([np.interp(ends, run, path[:, k]) for k in (0, 1)], axis=1)
        arrow(ax, tail, tip, colour, 0.0)


def key(ax: Axes, entries: Sequence[tuple[str, str]]) -> None:
    """Fill axes with a list of colours and their meanings.

    Parameters
    ----------
    ax : Axes
    entries : sequence of (str, str)
        Colour and meaning; a meaning may have several lines.
    """
    ax.axis("off")
    ax.set_xlim(0, 1)
    ax.set_ylim(0, 1)
    step = min(0.13, 0.9 / len(entries))
    top = 0.5 + step * (len(entries) - 1) / 2
    for k, (colour, meaning) in enumerate(entries):
        y = top - k * step
        ax.add_patch(Rectangle((0.04, y - 0.028), 0.09, 0.056, fc=colour, ec="none"))
        ax.text(0.18, y, meaning, fontsize=LABEL, color=INK, va="center")


KEY = (
    (ARM, "arm"),
    (OBSTACLE, "obstacle"),
    (TARGET, "target"),
    (EXTENDED, "extended obstacle"),
    (EXPLORED, "explored by the wave"),
    (EFFECTIVE, "effective obstacle"),
    (PATH, "path of the hand"),
)
