"""Triangles to pixels, with a depth at every pixel: what is nearer hides what is behind it."""

from __future__ import annotations

import numpy as np

from gcm_learn.compiled import njit


@njit(_nrt=False)
def fill(points, shades, image, depth):
    """Paint triangles into an image, where nothing is nearer.

    Parameters
    ----------
    points : (n, 3, 3) ndarray
        Of every corner the column and row in pixels, and its nearness, larger when nearer.
    shades : (n, 3, 3) ndarray
        Red, green and blue of every corner.
    image : (h, w, 3) ndarray
    depth : (h, w) ndarray
        Nearness of what is in front.
    """
    for k in range(points.shape[0]):
        p, c = points[k], shades[k]
        x0, y0, x1, y1, x2, y2 = p[0, 0], p[0, 1], p[1, 0], p[1, 1], p[2, 0], p[2, 1]
        area = (x1 - x0) * (y2 - y0) - (x2 - x0) * (y1 - y0)
        if area == 0.0:
            continue
        left = max(0, int(np.ceil(min(x0, x1, x2) - 0.5)))
        right = min(image.shape[1] - 1, int(np.floor(max(x0, x1, x2) - 0.5)))
        bottom = max(0, int(np.ceil(min(y0, y1, y2) - 0.5)))
        top = min(image.shape[0] - 1, int(np.floor(max(y0, y1, y2) - 0.5)))
        for i in range(bottom, top + 1):
            for j in range(left, right + 1):
                x, y = j + 0.5, i + 0.5
                b = ((x - x0) * (y2 - y0) - (x2 - x0) * (y - y0)) / area
                d = ((x1 - x0) * (y - y0) - (x - x0) * (y1 - y0)) / area
                a = 1.0 - b - d
                if a < 0.0 or b < 0.0 or d < 0.0:
                    continue
                near = a * p[0, 2] + b * p[1, 2] + d * p[2, 2]
                if near <= depth[i, j]:
                    continue
                depth[i, j] = near
                for m in range(3):
                    image[i, j, m] = a * c[0, m] + b * c[1, m] + d * c[2, m]
