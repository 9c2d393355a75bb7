"""A catch as a film: the work-space beside hand-space, or beside a view from above."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import IO, TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import to_hex, to_rgb
from matplotlib.figure import Figure
from PIL import Image

from gcm_learn.plots.figures import style
from gcm_learn.plots.figures.kinds import pictures_of
from gcm_learn.plots.figures.scenery import TIME_COLOURS
from gcm_learn.plots.figures.style import Scene
from gcm_learn.situation import AnySituation

if TYPE_CHECKING:
    from gcm_learn.planners import Plan

FRAMES = 40
ROUND = 16  # frames of a look around
FRAME_TIME, HOLD_TIME = 90, 2500  # [ms]
WIDTH, HEIGHT, FILM_DPI = 6.6, 3.6, 80
COLOURS = 128  # besides those of the style
PALETTE = (
    style.ARM,
    style.OBSTACLE,
    style.TARGET,
    style.EXTENDED,
    style.EXPLORED,
    style.EFFECTIVE,
    style.FRONT,
    style.PATH,
    style.INK,
    style.GOOD,
    "black",
    *(to_hex(TIME_COLOURS(share)) for share in (0.0, 0.25, 0.5, 0.75)),
)
NEARLY_WHITE = 247  # of 255


def animate(situation: AnySituation, plan: Plan, path: str | Path, *, frames: int = FRAMES) -> None:
    """Write an animated GIF of a plan, of an arm in space with a look around the catch.

    Parameters
    ----------
    situation : Situation
    plan : Plan
        Of this situation. When it caught nothing, the arm rests and the world goes on.
    path : str or Path
        File to write.

    Other Parameters
    ----------------
    frames : int
        Number of instants, from the start to the catch.
    """
    write_film(list(_frames(situation, plan, frames)), path)


def write_film(
    frames: Sequence[Image.Image],
    target: str | Path | IO[bytes],
    frame_time: int = FRAME_TIME,
    hold_time: int = HOLD_TIME,
) -> None:
    """Write frames as a GIF that loops; each lasts `frame_time`, the last `hold_time` [ms]."""
    palette = palette_of(frames[:: max(1, len(frames) // 8)])
    films = [frame.quantize(palette=palette, dither=Image.Dither.NONE) for frame in frames]
    films[0].save(
        target, format="GIF", save_all=True, append_images=films[1:], loop=0,
        duration=[frame_time] * (len(films) - 1) + [hold_time],
    )  # fmt: skip


def pixels(canvas: FigureCanvasAgg) -> Image.Image:
    """Return the canvas as an image, with a copy of its pixels."""
    return Image.fromarray(np.asarray(canvas.buffer_rgba())[..., :3].copy())


def _frames(situation: AnySituation, plan: Plan, frames: int) -> Iterator[Image.Image]:
    """Yield the frames of a film, drawn over one unchanging background."""
    figure = style.new_figure(WIDTH, HEIGHT)
    figure.set_dpi(FILM_DPI)
    panels = figure.subplots(1, 2)
    pictures = pictures_of(situation, plan)
    scenes = pictures.scenes(panels, round(WIDTH / 2 * FILM_DPI))
    last = situation.horizon if plan.trajectory is None else plan.trajectory.duration
    moments = [(t, 0.0) for t in np.linspace(0.0, last, frames)]
    if pictures.turns and plan.caught:
        moments += [(last, turn) for turn in np.linspace(0.0, 360.0, ROUND + 1)[1:]]
    yield from painted(figure, panels, scenes, moments)


def painted(
    figure: Figure,
    panels: Sequence[Axes],
    scenes: Sequence[Scene],
    moments: Sequence[tuple[float, float]],
) -> Iterator[Image.Image]:
    """Yield a frame for each moment (time [s], turn [degrees]); draw the background only once."""
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    figure.set_layout_engine("none")
    background = canvas.copy_from_bbox(figure.bbox)
    for t, turn in moments:
        canvas.restore_region(background)
        for ax, scene in zip(panels, scenes, strict=True):
            _paint(ax, lambda ax=ax, scene=scene, t=t, turn=turn: scene(ax, t, turn))  # type: ignore[misc]
        yield pixels(canvas)


def palette_of(images: Sequence[Image.Image]) -> Image.Image:
    """Return a palette for all frames of a film: the style, its tints, and frequent colours."""
    width, height = images[0].size
    strip = Image.new("RGB", (width, height * len(images)))
    for k, image in enumerate(images):
        strip.paste(image, (0, k * height))
    found = strip.quantize(COLOURS, dither=Image.Dither.NONE).getpalette() or []
    values = np.array(found, dtype=float).reshape(-1, 3)
    values[values.min(axis=1) >= NEARLY_WHITE] = 255  # quantize() confuses near neighbours
    pure = 255 * np.array([to_rgb(colour) for colour in PALETTE])
    tints = [255 - share * (255 - pure) for share in (1.0, 0.75, 0.5, 0.25)]
    palette = Image.new("P", (1, 1))
    chosen = np.concatenate([np.full((1, 3), 255.0), *tints, values])[:256]
    palette.putpalette(np.rint(chosen).astype(int).ravel().tolist())
    return palette


def _paint(ax: Axes, draw: Callable[[], None]) -> None:
    """Let `draw` add artists, paint only these artists, and remove them again."""
    before = set(ax.get_children())
    draw()
    added = [artist for artist in ax.get_children() if artist not in before]
    for artist in sorted(added, key=lambda a: a.get_zorder()):
        ax.draw_artist(artist)
        artist.remove()
