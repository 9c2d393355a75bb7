"""Colours of all pictures, as in the paper."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from gcm_learn.situation import Body

OBSTACLE = "#2b6cb0"  # solid blue
TARGET = "#8e44ad"  # purple
ARM = "#a61e3a"  # dark red
JOINT = "#f3dfe3"
APPROACH = "#2f855a"  # green: from which side a target is to be caught
PATH = "#5b2a86"  # dark purple
FLOOR = "#f4f6f9"
INK = "#2d3748"  # text and outlines
TIME = ("#fbc65d", "#ef7b5a", "#c2427f", PATH)  # from early to late
SHADES = 256  # of them


def rgb(colour: str) -> np.ndarray:
    """Red, green and blue (3,) of a colour, from 0 to 1."""
    return np.array([int(colour[k : k + 2], 16) / 255 for k in (1, 3, 5)])


def body_colour(body: Body) -> str:
    """Return the colour of a body's role."""
    return TARGET if body.role == "target" else OBSTACLE


def time_colours(shares: ArrayLike) -> np.ndarray:
    """Colours (n, 3) of instants, given as shares (n,) of a movement."""
    marks, wanted = np.linspace(0.0, 1.0, len(TIME)), np.array([rgb(name) for name in TIME])
    step = np.minimum((np.asarray(shares) * SHADES).astype(int), SHADES - 1) / (SHADES - 1)
    return np.stack([np.interp(step, marks, channel) for channel in wanted.T], axis=-1)
