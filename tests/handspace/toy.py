"""A toy chart of three dimensions: cells of a cube, and four swivels of the elbow in each.

The hand is in a cell in front of the shoulder, the elbow at one of four places on the circle that
upper arm and forearm leave it.  A step goes to one of the six neighbours of a cell, with the same
swivel, or to one of the two neighbouring swivels in the same cell, at a price.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np

from gcm_learn.handspace.chart import steps_of

SWIVELS = 4


class Cube:
    """Cells of a cube of n x n x n and SWIVELS; a swivel to the next takes `turn` seconds."""

    def __init__(self, n=5, side=1.0, centre=(1.1, 0.3, 0.2), turn=0.15, speed=2.0):
        self.n, self.spacing, self.turn, self.speed = n, side / n, turn, speed
        self.shape = (n, n, n, SWIVELS)
        along = (np.arange(n) + 0.5) * self.spacing - 0.5 * side
        grid = np.stack(np.meshgrid(along, along, along, indexing="ij"), axis=-1) + centre
        self.hands = np.repeat(grid.reshape(-1, 3), SWIVELS, axis=0)
        radius = np.linalg.norm(self.hands, axis=1)
        self.inside = (radius > 0.3) & (radius < 1.99)

    @cached_property
    def limbs(self):
        radius = np.linalg.norm(self.hands, axis=1, keepdims=True)
        out = self.hands / radius
        across = np.cross(out, [0.0, 0.0, 1.0])
        across /= np.linalg.norm(across, axis=1, keepdims=True)
        swivel = np.tile(np.arange(SWIVELS), self.n**3)[:, None] * 2.0 * np.pi / SWIVELS
        around = np.cos(swivel) * across + np.sin(swivel) * np.cross(out, across)
        half = 0.5 * np.minimum(radius, 2.0)  # both bones have the length 1
        elbow = half * out + np.sqrt(1.0 - half**2) * around
        return np.stack([np.zeros_like(out), elbow, self.hands], axis=1)

    @property
    def strides(self):
        return np.full(len(self.hands), 0.5 * self.spacing)

    def steps(self, limits):
        index = np.arange(len(self.hands)).reshape(self.shape)
        pairs, times = [], []
        for axis in range(3):
            here = np.moveaxis(index, axis, 0)
            pairs.append(np.stack([here[:-1].ravel(), here[1:].ravel()], axis=-1))
            times.append(np.full(len(pairs[-1]), self.spacing / self.speed))
        pairs.append(np.stack([index.ravel(), np.roll(index, 1, axis=3).ravel()], axis=-1))
        times.append(np.full(index.size, self.turn))
        there, taken = np.concatenate(pairs), np.concatenate(times)
        both, taken = np.concatenate([there, there[:, ::-1]]), np.concatenate([taken, taken])
        open_ = self.inside[both].all(axis=1)
        return steps_of(both[open_], taken[open_], index.size)

    def start(self, scene):
        middle = (self.n // 2,) * 3
        return np.array([np.ravel_multi_index((*middle, 0), self.shape)]), np.zeros(1)

    def lower_bound(self, place, near, limits):
        away = np.linalg.norm(self.hands - place, axis=1)
        return np.maximum(away - near, 0.0) / self.speed
