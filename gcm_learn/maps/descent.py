"""Down the map: a smooth path from any reached cell back to the hand, by gradient descent."""

from __future__ import annotations

import math

import numpy as np

from gcm_learn.compiled import njit
from gcm_learn.maps.cognitive_map import CognitiveMap

STRIDE = 0.35  # length of a step [cells]
NEAR = 1.5  # from here the path runs straight to the hand [cells]


@njit
def _slope(before, here, after):
    """Derivative of arrival along an axis at a reached cell, from reached neighbours only.

    Central where both neighbours are reached; else only downhill, because a front that came from
    elsewhere says nothing about the way back.
    """
    if before >= 0.0 and after >= 0.0:
        return 0.5 * (after - before)
    if before >= 0.0 and before < here:
        return here - before
    if after >= 0.0 and after < here:
        return after - here
    return 0.0


@njit
def gradient(arrival, x, y):
    """Return arrival and gradient at a point in cells: (value or -1, d/dx, d/dy).

    Both are interpolated bilinearly between the reached cells among the four nearest.
    """
    n = arrival.shape[0]
    j, i = min(max(int(x), 0), n - 2), min(max(int(y), 0), n - 2)
    u, v = min(max(x - j, 0.0), 1.0), min(max(y - i, 0.0), 1.0)
    total, value, gx, gy = 0.0, 0.0, 0.0, 0.0
    for a in range(i, i + 2):
        for b in range(j, j + 2):
            here = arrival[a, b]
            if here < 0.0:
                continue
            w = (u if b > j else 1.0 - u) * (v if a > i else 1.0 - v)
            left = arrival[a, b - 1] if b > 0 else -1.0
            right = arrival[a, b + 1] if b + 1 < n else -1.0
            down = arrival[a - 1, b] if a > 0 else -1.0
            up = arrival[a + 1, b] if a + 1 < n else -1.0
            total += w
            value += w * here
            gx += w * _slope(left, here, right)
            gy += w * _slope(down, here, up)
    if total < 1e-9:
        return -1.0, 0.0, 0.0
    return value / total, gx / total, gy / total


@njit
def _lowest_neighbour(arrival, x, y):
    """Reached cell with the earliest arrival among the nine around a point: (value, x, y)."""
    n = arrival.shape[0]
    ci, cj = int(np.round(y)), int(np.round(x))
    best, bx, by = 1e300, x, y
    for i in range(max(ci - 1, 0), min(ci + 2, n)):
        for j in range(max(cj - 1, 0), min(cj + 2, n)):
            if 0.0 <= arrival[i, j] < best:
                best, bx, by = arrival[i, j], float(j), float(i)
    return best, bx, by


@njit
def descend_kernel(arrival, x, y, hand_x, hand_y, points):
    """Follow the gradient from (x, y) to the hand; all positions in cells.

    Parameters
    ----------
    arrival : (n, n) ndarray
        Negative where no path leads.
    points : (m, 3) ndarray
        Filled with x, y and arrival, from the start of the descent to the hand.

    Returns
    -------
    int
        Number of points, -1 if the descent got stuck.
    """
    value, gx, gy = gradient(arrival, x, y)
    if value < 0.0:
        return -1
    points[0, 0], points[0, 1], points[0, 2] = x, y, value
    count = 1
    while count < points.shape[0] - 1:
        if (x - hand_x) ** 2 + (y - hand_y) ** 2 <= NEAR * NEAR:
            points[count, 0], points[count, 1], points[count, 2] = hand_x, hand_y, 0.0
            return count + 1
        size = np.sqrt(gx * gx + gy * gy)
        moved = False
        if size > 1e-12:
            # Midpoint rule: the gradient half a step on is second-order accurate.
            half, hx, hy = gradient(
                arrival, x - 0.5 * STRIDE * gx / size, y - 0.5 * STRIDE * gy / size
            )
            middle = np.sqrt(hx * hx + hy * hy)
            if half >= 0.0 and middle > 1e-12:
                px, py = x - STRIDE * hx / middle, y - STRIDE * hy / middle
                ahead, ax, ay = gradient(arrival, px, py)
                if 0.0 <= ahead < value:
                    x, y, value, gx, gy = px, py, ahead, ax, ay
                    moved = True
        if not moved:
            lowest, px, py = _lowest_neighbour(arrival, x, y)
            if lowest >= value:
                return -1
            x, y = px, py
            value, gx, gy = gradient(arrival, x, y)
        points[count, 0], points[count, 1], points[count, 2] = x, y, value
        count += 1
    return -1


def descend(
    cognitive_map: CognitiveMap, start: tuple[float, ...] | None = None
) -> tuple[np.ndarray, np.ndarray] | None:
    """Find the path from the hand to a point of the map, and arrivals along it (Sect. 2.3.4).

    The path is smooth in the plane. In space it runs from node to node and, where the hand may
    wait, through the spans in which the nodes are free.

    Parameters
    ----------
    cognitive_map : CognitiveMap
    start : (d,) tuple of float, optional
        Where the descent starts, i.e. where the path ends; the interception's cell by default.

    Returns
    -------
    points : (m, d) ndarray
        Hand positions from the hand at t = 0 to `start` [forearm lengths].
    arrival : (m,) ndarray
        When the front was there [s].
        None instead of both if there is no path.
    """
    if cognitive_map.via is not None:
        return _over_nodes(cognitive_map, start)
    lattice = cognitive_map.lattice
    if start is None:
        if cognitive_map.interception is None:
            return None
        start = cognitive_map.interception.position
    h, reach = lattice.spacing, lattice.reach
    ends = (np.array([*start, *cognitive_map.hand]) + reach) / h - 0.5
    points = np.empty((40 * lattice.n, 3))
    count = descend_kernel(cognitive_map.arrival.filled(-1.0), *ends, points)
    if count < 0:
        return None
    path = points[:count][::-1]
    hands = (path[:, :2] + 0.5) * h - reach
    hands[0] = cognitive_map.hand
    return hands, path[:, 2].copy()


def _over_nodes(
    cognitive_map: CognitiveMap, start: tuple[float, ...] | None
) -> tuple[np.ndarray, np.ndarray] | None:
    """Run `descend` from node to node; the earliest node at `start` counts."""
    chart = cognitive_map.chart
    arrival = cognitive_map.arrival.filled(np.inf).ravel()
    node = cognitive_map.met
    if start is not None:
        index = chart.cell_of(start)
        cells = (chart.n,) * len(index)
        postures = chart.size // math.prod(cells)
        nearest = int(np.ravel_multi_index(index, cells)) * postures + np.arange(postures)
        node = int(nearest[np.argmin(arrival[nearest])])
    if node < 0 or not np.isfinite(arrival[node]):
        return None
    nodes = np.array(chain_to(cognitive_map, node))
    return np.array([chart.hand_at(n) for n in nodes]), arrival[nodes].astype(float)


def chain_to(cognitive_map: CognitiveMap, node: int) -> list[int]:
    """Return the nodes along which the front came to `node`, from the first to `node` itself."""
    if cognitive_map.via is None:
        raise ValueError("this map does not say where its front came from")
    chain, via = [], cognitive_map.via.ravel()
    while node >= 0:
        chain.append(node)
        node = int(via[node])
    return chain[::-1]
