"""A catch as a film: the work-space beside the wave that grows in hand-space."""

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

from gcm_learn.arms import SpatialArm
from gcm_learn.handspace import SpaceLattice
from gcm_learn.planners import Plan
from gcm_learn.plots.figures import style
from gcm_learn.plots.figures.handspace import draw_hand, extended_image, show_image
from gcm_learn.plots.figures.maps import draw_effective, draw_explored
from gcm_learn.plots.figures.space import TIME_COLOURS, Scenery
from gcm_learn.plots.figures.space_maps import HandSpace, ball_window
from gcm_learn.plots.figures.workspace import draw_arm, draw_bodies, draw_waits, waiting_at
from gcm_learn.rendering import from_above
from gcm_learn.situation import AnySituation, Situation

if TYPE_CHECKING:
    from gcm_learn.motion import SpatialTrajectory
    from gcm_learn.planners import AnyPlan

Scene = Callable[[Axes, float, float], None]  # draws a time [s], turned by an angle [degrees]

FRAMES = 40
ROUND = 16  # frames of a look around
SWAY = 35.0  # [degrees] by which hand-space is turned to and fro
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
COARSE = 240  # cells a side of the drawn extended obstacles


def animate(
    situation: AnySituation, plan: AnyPlan, path: str | Path, *, frames: int = FRAMES
) -> None:
    """Write an animated GIF of a plan; in space, with a look around the catch at its end.

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
    """The drawing as an image of its own."""
    return Image.fromarray(np.asarray(canvas.buffer_rgba())[..., :3].copy())


def _frames(situation: AnySituation, plan: AnyPlan, frames: int) -> Iterator[Image.Image]:
    """Draw frame after frame over one unchanging background."""
    figure = style.new_figure(WIDTH, HEIGHT)
    figure.set_dpi(FILM_DPI)
    panels = figure.subplots(1, 2)
    scenes = (_spatial_scenes if situation.is_spatial else _planar_scenes)(situation, plan, panels)  # type: ignore[operator, arg-type]
    last = _duration(situation, plan)
    moments = [(t, 0.0) for t in np.linspace(0.0, last, frames)]
    if situation.is_spatial and plan.caught:
        moments += [(last, turn) for turn in np.linspace(0.0, 360.0, ROUND + 1)[1:]]
    yield from painted(figure, panels, scenes, moments)


def painted(
    figure: Figure,
    panels: Sequence[Axes],
    scenes: Sequence[Scene],
    moments: Sequence[tuple[float, float]],
) -> Iterator[Image.Image]:
    """Draw what panels show at moments (time [s], turn [degrees]), all else once."""
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    figure.set_layout_engine("none")
    background = canvas.copy_from_bbox(figure.bbox)
    for t, turn in moments:
        canvas.restore_region(background)
        for ax, scene in zip(panels, scenes, strict=True):
            _paint(ax, lambda ax=ax, scene=scene, t=t, turn=turn: scene(ax, t, turn))  # type: ignore[misc]
        yield pixels(canvas)


def _planar_scenes(situation: Situation, plan: Plan, panels: Sequence[Axes]) -> tuple[Scene, Scene]:
    """Return a function that draws the panels of a planar situation at a time [s]."""
    for ax, name in zip(panels, ("work-space", "hand-space"), strict=True):
        style.frame(ax, situation.arm.upper_arm)
        style.title(ax, name)
    last = _duration(situation, plan)
    return (
        lambda ax, t, turn: _left(ax, situation, plan, t),
        lambda ax, t, turn: _right(ax, situation, plan, t, t >= last),
    )


def _spatial_scenes(
    situation: Situation[SpatialArm], plan: Plan[SpatialTrajectory], panels: Sequence[Axes]
) -> tuple[Scene, Scene]:
    """Return a function that draws a situation in space at a time [s], from a camera that turns."""
    size, last = round(WIDTH / 2 * FILM_DPI), _duration(situation, plan)
    level = Scenery(situation, plan.trajectory, turns=True)
    above = Scenery(situation, plan.trajectory, from_above(level.view))
    charted = plan.map is not None and isinstance(plan.map.chart, SpaceLattice)
    windows = (level.window, ball_window(situation) if charted else above.window)
    names = ("work-space", "hand-space" if charted else "from above")
    for ax, window, name in zip(panels, windows, names, strict=True):
        left, right, bottom, top = window.extent
        ax.set(aspect="equal", xlim=(left, right), ylim=(bottom, top))
        ax.axis("off")
        style.title(ax, name)

    def show(ax: Axes, t: float, turn: float) -> None:
        level.show(ax, t, turn, size)
        note_in_corner(ax, f"t = {t:.2f} s")

    if plan.map is None or not charted:
        return show, lambda ax, t, _: above.show(ax, t, 0.0, size)
    kappa, hands = plan.map.kappa, HandSpace(situation, plan.map, plan.trajectory, level.view)

    def show_hands(ax: Axes, t: float, turn: float) -> None:
        if t < last or not plan.caught:
            hands.show(ax, t, SWAY * np.sin(np.pi * (2.0 * t / last - 1.0)), size)
        else:
            hands.show_map(ax, SWAY * np.sin(np.radians(turn)), size)
        note_in_corner(ax, f"τ = {t / kappa:.0f}")

    return show, show_hands


def palette_of(images: Sequence[Image.Image]) -> Image.Image:
    """Colours for all frames of a film: the style, its tints, and other frequent colours."""
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
    """Let `draw` add artists, paint only those, and remove them again."""
    before = set(ax.get_children())
    draw()
    added = [artist for artist in ax.get_children() if artist not in before]
    for artist in sorted(added, key=lambda a: a.get_zorder()):
        ax.draw_artist(artist)
        artist.remove()


def _duration(situation: AnySituation, plan: AnyPlan) -> float:
    return plan.trajectory.duration if plan.trajectory is not None else situation.horizon


def _hand(situation: Situation, plan: Plan, t: float) -> np.ndarray:
    if plan.trajectory is None:
        return np.asarray(situation.arm.hand)
    return plan.trajectory.hand_at(t)


def _left(ax: Axes, situation: Situation, plan: Plan, t: float) -> None:
    note = f"t = {t:.2f} s"
    if plan.trajectory is not None:
        note += ", waiting" if waiting_at(plan.trajectory, t) else ""
        past = plan.trajectory.hand[plan.trajectory.time <= t]
        ax.plot(*past.T, color=style.PATH, lw=1.6, ls=(0, (2, 1.5)), zorder=4)
    draw_bodies(ax, situation, t)
    draw_arm(ax, situation.arm, _hand(situation, plan, t))
    note_in_corner(ax, note)


def _right(ax: Axes, situation: Situation, plan: Plan, t: float, at_end: bool) -> None:
    show_image(ax, extended_image(situation, t, n=COARSE), situation.arm, zorder=2.0)
    if plan.map is not None:
        tau = t / plan.map.kappa
        draw_explored(ax, plan.map, tau)
        draw_effective(ax, plan.map, tau)
        note_in_corner(ax, f"τ = {tau:.0f}")
    draw_bodies(ax, situation, t)
    if plan.trajectory is not None and at_end:
        style.draw_path(ax, plan.trajectory.hand)
        draw_waits(ax, plan.trajectory)
    draw_hand(ax, _hand(situation, plan, t))


def note_in_corner(ax: Axes, text: str, *, top: bool = False) -> None:
    """Write into the lower (or upper) left corner, over everything."""
    ax.text(
        0.01, 0.99 if top else 0.01, text, transform=ax.transAxes, ha="left",
        va="top" if top else "bottom", fontsize=style.TITLE, color=style.INK, zorder=20,
        path_effects=[style.HALO],
    )  # fmt: skip
