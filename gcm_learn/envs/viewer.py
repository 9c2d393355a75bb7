"""Pictures of an arena, as arrays or in a window."""

from __future__ import annotations

import os
from collections.abc import Callable
from typing import Any, Protocol

import numpy as np

from gcm_learn.arms import PLANAR, ByKind, Kind, elbow_position
from gcm_learn.errors import ArenaError, MissingExtraError
from gcm_learn.motion import Movement
from gcm_learn.rendering import ARM, INK, PATH, Spectator, body_colour
from gcm_learn.scene import outline
from gcm_learn.situation import Situation

UNSEEN = ("dummy", "offscreen")  # SDL's drivers without a display, used unasked where there is none


class PictureWindow:
    """A square window that shows pictures at a steady rate.

    Parameters
    ----------
    pixels : int
        Of a side.
    rate : int
        Most pictures per second [1/s].

    Raises
    ------
    MissingExtraError
        Without pygame.
    ArenaError
        Without a display.
    """

    def __init__(self, pixels: int, rate: int) -> None:
        self._pygame, self._rate = _pygame(), rate
        try:
            self._pygame.display.init()
            driver = self._pygame.display.get_driver()
            if driver in UNSEEN and os.environ.get("SDL_VIDEODRIVER") != driver:
                raise self._pygame.error("no video device")
            self._screen = self._pygame.display.set_mode((pixels, pixels))
        except self._pygame.error as error:
            self._pygame.display.quit()
            raise ArenaError(
                f"render_mode: 'human' needs a display ({error}); choose 'rgb_array'"
            ) from None
        self._pygame.display.set_caption("gcm_learn")
        self._clock = self._pygame.time.Clock()

    def show(self, picture: np.ndarray) -> None:
        """Show a picture (pixels, pixels, 3) uint8, at most as often as the window's rate."""
        surface = self._pygame.surfarray.make_surface(picture.swapaxes(0, 1))
        self._screen.blit(surface, (0, 0))
        self._pygame.event.pump()
        self._clock.tick(self._rate)
        self._pygame.display.flip()

    def close(self) -> None:
        """Close the window."""
        self._pygame.display.quit()
        self._pygame.quit()


def _pygame() -> Any:
    """Return the module pygame; raise MissingExtraError if it is not installed."""
    try:
        import pygame
    except ImportError:
        raise MissingExtraError("render_mode: 'human'", "pygame", "render") from None
    return pygame


SIZE_INCHES, DPI = 4.8, 100
PIXELS = round(SIZE_INCHES * DPI)  # of a side


class Artist(Protocol):
    """Painter of one kind of arm."""

    def picture(self, situation: Any, way: Any) -> np.ndarray:
        """Return the picture (480, 480, 3) uint8 of the end of a trajectory."""


class Viewer:
    """Viewer of the moments of an episode, in a window if a rate is given.

    Parameters
    ----------
    kind : Kind
        Of the arm.
    rate : int, optional
        Pictures per second in a window [1/s]; without a rate there is no window.

    Raises
    ------
    MissingExtraError
        Without pygame, if a window is wanted.
    ArenaError
        Without a display, if a window is wanted.
    """

    def __init__(self, kind: Kind, rate: int | None = None) -> None:
        self._artist = _ARTISTS.of(kind)()
        self._window = None if rate is None else PictureWindow(PIXELS, rate)

    def show(self, situation: Any, way: Any) -> np.ndarray | None:
        """Return the picture of the end of a trajectory, or None if it is shown in the window.

        Parameters
        ----------
        situation : Situation
            As the arena has it.
        way : Movement
            In the situation's coordinates.
        """
        picture = self._artist.picture(situation, way)
        if self._window is None:
            return picture
        self._window.show(picture)
        return None

    def close(self) -> None:
        """Close the window."""
        if self._window is not None:
            self._window.close()


class _PlaneArtist:
    """Painter of an arm's plane."""

    def __init__(self) -> None:
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure

        figure = Figure(figsize=(SIZE_INCHES, SIZE_INCHES), dpi=DPI)
        self._canvas = FigureCanvasAgg(figure)
        self._axes: Any = figure.add_axes((0.0, 0.0, 1.0, 1.0))

    def picture(self, situation: Situation, way: Movement) -> np.ndarray:
        """As `Artist` says."""
        from matplotlib.patches import Circle

        ax, arm, time, path = self._axes, situation.arm, float(way.time[-1]), way.hand
        ax.clear()
        ax.set_axis_off()
        limit = 1.15 * arm.reach
        ax.set_xlim(-limit, limit)
        ax.set_ylim(-limit, limit)
        ax.add_patch(Circle((0, 0), arm.reach, fill=False, ls="--", ec="#a0aec0"))
        self._add_bodies(situation, time)
        hand = path[-1]
        elbow = elbow_position(hand, arm.upper_arm, arm.elbow)
        ax.plot(path[:, 0], path[:, 1], color=PATH, lw=1.2)
        ax.plot(*np.array([(0.0, 0.0), elbow, hand]).T, color=ARM, lw=4, solid_capstyle="round")
        ax.add_patch(Circle(tuple(hand), max(arm.grasp, 0.02), color=ARM))
        ax.text(-0.98 * limit, 0.95 * limit, f"{time:.2f} s", va="top", color=INK)
        self._canvas.draw()
        return np.asarray(self._canvas.buffer_rgba())[..., :3].copy()

    def _add_bodies(self, situation: Situation, time: float) -> None:
        """Add the bodies, or their cuts with the plane."""
        from matplotlib.patches import Polygon

        for index, body in enumerate(situation.bodies):
            corners = outline(situation, index, time)
            if corners is not None:
                self._axes.add_patch(Polygon(corners, closed=True, color=body_colour(body), lw=0))


class _SpaceArtist:
    """Painter with the package's own renderer, which needs no graphics card."""

    def __init__(self) -> None:
        self._seen: tuple[Any, Any] = (None, None)

    def picture(self, situation: Any, way: Movement) -> np.ndarray:
        """As `Artist` says."""
        seen, spectator = self._seen
        if seen is not situation:
            spectator = Spectator(situation)
            self._seen = (situation, spectator)
        picture: np.ndarray = spectator.picture(way, PIXELS)
        return picture


_ARTISTS: ByKind[Callable[[], Artist]] = ByKind({PLANAR: _PlaneArtist}, default=_SpaceArtist)
