"""Distances of hulls of balls, by the algorithm of Gilbert, Johnson and Keerthi."""

from __future__ import annotations

import numpy as np

from gcm_learn.arms.link_gaps import segments_gap2
from gcm_learn.compiled import njit

ROUNDS = 60  # of a search for the nearest points; most take fewer than ten
CLOSE = 1e-9  # error of a distance, relative and absolute [lengths]
FLAT = 1e-14  # squared height of a simplex, beside its size, at which it is one with fewer corners


@njit(_nrt=False)
def nearest_face(corners, count, system):
    """Reduce a simplex to its face nearest to the origin; return that face's number of corners.

    The weights w of a face's corners C solve (C C^T + s) z = 1, with w = z / sum(z), for any s > 0.

    Parameters
    ----------
    corners : (5, 3) ndarray
        The first `count` (1 to 4) are the simplex; the last becomes the nearest point.
    count : int
    system : (8, 5) ndarray
        Overwritten: products of the corners, and below it a system of equations.
    """
    size, best, face = 0.0, 1e300, 1
    for i in range(count):
        for j in range(count):
            system[i, j] = 0.0
            for x in range(3):
                system[i, j] += corners[i, x] * corners[j, x]
        size = max(size, system[i, i])
    for mask in range(1, 1 << count):
        for i in range(count):
            system[4 + i, 4] = mask >> i & 1
            for j in range(count):
                both = mask >> i & mask >> j & 1
                system[4 + i, j] = system[i, j] + size if both else 1.0 * (i == j)
        if not solved(system[4:], count, FLAT * size):
            continue
        total, px, py, pz = 0.0, 0.0, 0.0, 0.0
        for i in range(count):
            weight = system[4 + i, 4]
            total, px = total + weight, px + weight * corners[i, 0]
            py, pz = py + weight * corners[i, 1], pz + weight * corners[i, 2]
        px, py, pz = px / total, py / total, pz / total
        far2 = px * px + py * py + pz * pz
        if far2 < best * (1.0 - 1e-12):
            best, face = far2, mask
            corners[4, 0], corners[4, 1], corners[4, 2] = px, py, pz
    left = 0
    for k in range(count):
        if face >> k & 1:
            for x in range(3):
                corners[left, x] = corners[k, x]
            left += 1
    return left


@njit(_nrt=False)
def solved(system, size, flat):
    """Solve equations (size, 5) in place; return False if singular, or if a number is negative."""
    for i in range(size):
        if system[i, i] <= flat:
            return False
        for j in range(size):
            if j != i:
                share = system[j, i] / system[i, i]
                for k in range(i, size):
                    system[j, k] -= share * system[i, k]
                system[j, 4] -= share * system[i, 4]
    for i in range(size):
        system[i, 4] /= system[i, i]
        if system[i, 4] < 0.0:
            return False
    return True


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
    corners, system : (5, 3) and (8, 5) ndarray
        Overwritten.
    """
    for x in range(3):
        corners[4, x] = balls[a[0], x] - place[x]
        for k in range(3):
            corners[4, x] -= turn[x, k] * balls[b[0], k]
    count, least = 0, 0.0
    for _ in range(ROUNDS):
        far = np.sqrt(corners[4, 0] ** 2 + corners[4, 1] ** 2 + corners[4, 2] ** 2)
        if far <= CLOSE or count == 4:
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
    return least


@njit
def gaps(balls, first, rounds, split, turns, places, enough):
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
    turns, places : (m, 3, 3) and (m, 3) ndarray
        Poses of the second group's frame in that of the first.
    enough : float
        Distances beyond are cut to it.
    """
    found = np.full(len(places), enough)
    corners, system, rows = np.empty((5, 3)), np.empty((8, 5)), np.empty((2, 6))
    for m in range(len(found)):
        turn, place = turns[m], places[m]
        for q in range(split, len(rounds)):
            for x in range(3):
                rows[1, x], rows[1, x + 3] = place[x], place[x]
                for k in range(3):
                    rows[1, x] += turn[x, k] * rounds[q, k]
                    rows[1, x + 3] += turn[x, k] * rounds[q, k + 3]
            for p in range(split):
                rows[0] = rounds[p, :6]
                gap = np.sqrt(segments_gap2(rows, 0, 1)) - rounds[p, 6] - rounds[q, 6]
                if gap < found[m]:
                    one, two = (first[p], first[p + 1]), (first[q], first[q + 1])
                    skin = rounds[p, 7] + rounds[q, 7]
                    limit = found[m] + skin
                    gap = hulls_gap(balls, one, two, turn, place, limit, corners, system) - skin
                    found[m] = min(found[m], gap)
            if found[m] <= 0.0:
                break
    return found
