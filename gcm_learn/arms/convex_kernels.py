"""Distances of hulls of balls, by the algorithm of Gilbert, Johnson and Keerthi."""

from __future__ import annotations

import numpy as np

from gcm_learn.arms.link_gaps import segments_gap2
from gcm_learn.compiled import njit

ROUNDS = 60  # of a search for the nearest points; most take fewer than ten
CLOSE = 1e-9  # error of a distance, relative and absolute [lengths]


@njit(_nrt=False)
def nearest_face(corners, count, system):
    """Reduce a simplex to the face nearest to the origin, and return the number of its corners.

    Parameters
    ----------
    corners : (5, 3) ndarray
        The first `count` (1 to 4) are the simplex; the last becomes the nearest point.
    count : int
    system : (3, 4) ndarray
        Overwritten.
    """
    best, face = 1e300, 1
    for mask in range(1, 1 << count):
        first, size = -1, 0
        for k in range(count):
            if not mask >> k & 1:
                continue
            if first < 0:
                first = k
                continue
            column = 0
            for other in range(first + 1, count):
                if mask >> other & 1:
                    system[size, column] = 0.0
                    for x in range(3):
                        system[size, column] += (corners[k, x] - corners[first, x]) * (
                            corners[other, x] - corners[first, x]
                        )
                    column += 1
            system[size, 3] = 0.0
            for x in range(3):
                system[size, 3] -= (corners[k, x] - corners[first, x]) * corners[first, x]
            size += 1
        if not solved(system, size):
            continue
        far2 = 0.0
        for x in range(3):
            at, row = corners[first, x], 0
            for k in range(first + 1, count):
                if mask >> k & 1:
                    at += system[row, 3] * (corners[k, x] - corners[first, x])
                    row += 1
            far2 += at * at
            system[x, 0] = at
        if far2 < best:
            best, face = far2, mask
            for x in range(3):
                corners[4, x] = system[x, 0]
    left = 0
    for k in range(count):
        if face >> k & 1:
            for x in range(3):
                corners[left, x] = corners[k, x]
            left += 1
    return left


@njit(_nrt=False)
def solved(system, size):
    """Solve for the weights of corners, in place; false unless all are from 0 to 1."""
    total = 0.0
    for i in range(size):
        if system[i, i] <= 1e-24:
            return False
        for j in range(size):
            if j != i:
                share = system[j, i] / system[i, i]
                for k in range(i, size):
                    system[j, k] -= share * system[i, k]
                system[j, 3] -= share * system[i, 3]
    for i in range(size):
        system[i, 3] /= system[i, i]
        total += system[i, 3]
        if system[i, 3] < 0.0:
            return False
    return total <= 1.0


@njit(_nrt=False)
def farthest(balls, begin, end, x, y, z):
    """Return the number of the ball that reaches farthest in a direction of length 1."""
    best, at = -1e300, begin
    for k in range(begin, end):
        value = balls[k, 0] * x + balls[k, 1] * y + balls[k, 2] * z + balls[k, 3]
        if value > best:
            best, at = value, k
    return at


@njit(_nrt=False)
def hulls_gap(balls, a, b, turn, place, enough, corners, system):
    """Return the distance of the hulls of two spans of balls, 0 if they touch.

    Parameters
    ----------
    balls : (n, 4) ndarray
        Centres and radii.
    a, b : (2,) tuple of int
        First ball, and that after the last one.
    turn, place : (3, 3) and (3,) ndarray
        Pose of b's frame in that of a.
    enough : float
        For a larger distance, a lower bound above this is returned.
    corners, system : (5, 3) and (3, 4) ndarray
        Overwritten.
    """
    for x in range(3):
        corners[4, x] = balls[a[0], x] - place[x]
        for k in range(3):
            corners[4, x] -= turn[x, k] * balls[b[0], k]
    count, least = 0, 0.0
    for _ in range(ROUNDS):
        far = np.sqrt(corners[4, 0] ** 2 + corners[4, 1] ** 2 + corners[4, 2] ** 2)
        if far <= CLOSE:
            return 0.0
        dx, dy, dz = -corners[4, 0] / far, -corners[4, 1] / far, -corners[4, 2] / far
        bx = -(turn[0, 0] * dx + turn[1, 0] * dy + turn[2, 0] * dz)
        by = -(turn[0, 1] * dx + turn[1, 1] * dy + turn[2, 1] * dz)
        bz = -(turn[0, 2] * dx + turn[1, 2] * dy + turn[2, 2] * dz)
        i, j = farthest(balls, a[0], a[1], dx, dy, dz), farthest(balls, b[0], b[1], bx, by, bz)
        thick = balls[i, 3] + balls[j, 3]
        for x in range(3):
            corners[count, x] = balls[i, x] - place[x] + thick * (dx, dy, dz)[x]
            for k in range(3):
                corners[count, x] -= turn[x, k] * balls[j, k]
        bound = -(corners[count, 0] * dx + corners[count, 1] * dy + corners[count, 2] * dz)
        least = max(least, bound)
        if least > enough or far - least <= CLOSE * (1.0 + far):
            return least
        count = nearest_face(corners, count + 1, system)
        if count == 4:
            return 0.0
    return least


@njit
def gaps(balls, first, rounds, split, turns_a, places_a, turns_b, places_b, enough):
    """Return how far two groups of parts are apart in postures (m,); 0 or less where they touch.

    Parameters
    ----------
    balls : (n, 4) ndarray
        Centres, in the frame that carries them, and how much radii are above the part's least.
    first : (p + 1,) ndarray of int
        First ball of each part.
    rounds : (p, 8) ndarray
        Of each part: a capsule that holds it (ends, radius), and its balls' least radius.
    split : int
        Parts of the first group; the others are the second one.
    turns_a, places_a, turns_b, places_b : (m, 3, 3) and (m, 3) ndarray
        Frames of the groups.
    enough : float
        Distances beyond are cut to it.
    """
    found = np.full(len(places_a), enough)
    corners, system, rows = np.empty((5, 3)), np.empty((3, 4)), np.empty((2, 6))
    turn, place = np.empty((3, 3)), np.empty(3)
    for m in range(len(found)):
        for x in range(3):
            place[x] = 0.0
            for k in range(3):
                place[x] += turns_a[m, k, x] * (places_b[m, k] - places_a[m, k])
                turn[x, k] = 0.0
                for y in range(3):
                    turn[x, k] += turns_a[m, y, x] * turns_b[m, y, k]
        for p in range(split):
            rows[0] = rounds[p, :6]
            for q in range(split, len(rounds)):
                for x in range(3):
                    rows[1, x], rows[1, x + 3] = place[x], place[x]
                    for k in range(3):
                        rows[1, x] += turn[x, k] * rounds[q, k]
                        rows[1, x + 3] += turn[x, k] * rounds[q, k + 3]
                gap = np.sqrt(segments_gap2(rows, 0, 1)) - rounds[p, 6] - rounds[q, 6]
                if gap >= found[m]:
                    continue
                one, two = (first[p], first[p + 1]), (first[q], first[q + 1])
                if max(one[1] - one[0], two[1] - two[0]) > 2 or (
                    rounds[p, 6] > rounds[p, 7] or rounds[q, 6] > rounds[q, 7]
                ):
                    skin = rounds[p, 7] + rounds[q, 7]
                    limit = found[m] + skin
                    gap = hulls_gap(balls, one, two, turn, place, limit, corners, system) - skin
                found[m] = min(found[m], gap)
            if found[m] <= 0.0:
                break
    return found


@njit(_nrt=False)
def radius_about(start, end, balls):
    """Return the smallest radius with which a capsule holds balls (n, 4)."""
    ax, ay, az = end[0] - start[0], end[1] - start[1], end[2] - start[2]
    length2 = ax * ax + ay * ay + az * az
    best = 0.0
    for k in range(len(balls)):
        x, y, z = balls[k, 0] - start[0], balls[k, 1] - start[1], balls[k, 2] - start[2]
        if length2 > 0.0:
            share = min(max((x * ax + y * ay + z * az) / length2, 0.0), 1.0)
            x, y, z = x - share * ax, y - share * ay, z - share * az
        best = max(best, np.sqrt(x * x + y * y + z * z) + balls[k, 3])
    return best


@njit
def skin(start, end, radius, sphere):
    """Return points (n, 3) all over a capsule's surface, and the area of each (n,).

    Parameters
    ----------
    start, end : (3,) ndarray
    radius : float
    sphere : (d, 3) ndarray
        Directions, spread evenly.
    """
    axis = end - start
    length = np.sqrt((axis * axis).sum())
    rings = min(int(2.0 * length / radius) + 2, 24) if length > 0.0 else 0
    many, few = len(sphere), (len(sphere) + 4) // 5
    points, areas = np.empty((many + rings * few, 3)), np.empty(many + rings * few)
    areas[:many] = 4.0 * np.pi * radius * radius / many
    areas[many:] = 2.0 * np.pi * radius * length / max(rings * few, 1)
    for k in range(many):
        along = (sphere[k] * axis).sum()
        points[k] = (end if along > 0.0 else start) + radius * sphere[k]
        if k % 5 == 0 and rings > 0:
            flat = sphere[k] - along / (length * length) * axis
            flat *= radius / max(np.sqrt((flat * flat).sum()), 1e-9)
            for ring in range(rings):
                points[many + ring * few + k // 5] = start + (ring + 0.5) / rings * axis + flat
    return points, areas


@njit
def spill(field, frame, start, end, radius, sphere):
    """Return how far a capsule's surface lies beyond parts at most, and the volume between.

    Parameters
    ----------
    field : (a, b, c) ndarray
        Distance from the parts at the nodes of a lattice.
    frame : (4,) ndarray
        Place of its first node, and distance of neighbours.
    start, end, radius, sphere
        See `skin`.
    """
    points, areas = skin(start, end, radius, sphere)
    most, volume = 0.0, 0.0
    for n in range(len(points)):
        u = min(max((points[n, 0] - frame[0]) / frame[3], 0.0), field.shape[0] - 1.001)
        v = min(max((points[n, 1] - frame[1]) / frame[3], 0.0), field.shape[1] - 1.001)
        w = min(max((points[n, 2] - frame[2]) / frame[3], 0.0), field.shape[2] - 1.001)
        i, j, k = int(u), int(v), int(w)
        u, v, w = u - i, v - j, w - k
        out = 0.0
        for a in range(2):
            for b in range(2):
                for c in range(2):
                    share = (u if a else 1.0 - u) * (v if b else 1.0 - v) * (w if c else 1.0 - w)
                    out += share * field[i + a, j + b, k + c]
        most, volume = max(most, out), volume + areas[n] * out
    return most, volume
