"""A window of pygame for ``render_mode="human"``, as in Gymnasium's own environments."""

from __future__ import annotations

import os
from typing import Any

import numpy as np

from gcm_learn.errors import ArenaError, MissingExtraError

UNSEEN = ("dummy", "offscreen")  # SDL's drivers without a display, used unasked where there is none


class Window:
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
        """Show a picture (pixels, pixels, 3) uint8; wait if the last one was shown just now."""
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
    """Return the library, or say how to install it."""
    try:
        import pygame
    except ImportError:
        raise MissingExtraError("render_mode: 'human'", "pygame", "render") from None
    return pygame
