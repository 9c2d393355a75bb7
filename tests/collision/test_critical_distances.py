"""Distances that are just kept by limbs and bodies in motion: no answer says more than is true.

What `least_on`, `move_is_free` and `leg_is_free` find is compared with densely sampled truth, where
one bound of motion decides: a body that passes within a span, a limb that does, or both.
"""

import numpy as np
import pytest

from gcm_learn.collision.postures import desk_of, least_on, move_is_free
from gcm_learn.collision.sweep import DEEPEST, HAIR, Sweep, least_distance, leg_is_free
from gcm_learn.scene import pack
from tests.cover.test_bounds import (
    HAND,
    LONG,
    PLANAR,
    POSTURE,
    REST,
    SHORT,
    STILL,
    STRETCHED,
    axes_of,
    chain,
    planar,
    spatial,
    truth,
)

EXACT = 1e-6
WAYS = {
    "body passes at the begin": ([((1.4, -0.1), (0.0, 20.0))], HAND, HAND, PLANAR),
    "body passes at the end": ([((1.4, -19.1), (0.0, 20.0))], HAND, HAND, PLANAR),
    "hand passes early": ([((1.235, 0.518), REST)], HAND, (0.6, 1.2), PLANAR),
    "hand passes late": ([((0.78, 1.2), REST)], HAND, (0.6, 1.2), PLANAR),
    "both pass": ([((1.3, 0.3), (-0.4, 0.9))], HAND, (0.6, 1.2), PLANAR),
    "elbow is led out": ([((0.9, -0.75), REST)], STRETCHED.hand, (1.2, 0.0), STRETCHED),
    "elbow passes a body": ([((0.62, -0.9), REST)], STRETCHED.hand, (0.5, 0.0), STRETCHED),
    "arm turns": ([((-0.3, 1.5), REST)], (1.2, 0.8), (-1.2, 0.8), PLANAR),
    "short arm turns": ([((0.0, 0.8), REST)], SHORT.hand, (-1.0, 0.6), SHORT),
    "long arm folds": ([((1.0, -1.4), REST)], LONG.hand, (0.8, 0.0), LONG),
    "body beside the shoulder": ([((-0.12, 0.0), REST)], HAND, (0.6, 1.2), PLANAR),
    "second of two": ([((3.0, 0.0), REST), ((1.4, 0.4), REST)], HAND, (1.3, 0.2), PLANAR),
}


def critical(keeps, low=-0.5, high=3.0):
    """Return the largest distance that is said to be kept."""
    while high - low > EXACT:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if keeps(middle) else (low, middle)
    return low


def moves(first, last):
    """Return times, way and no deviations."""
    way = np.array([first, last], dtype=float)
    return np.array([0.0, 1.0]), way, np.zeros_like(way)


@pytest.mark.parametrize("name", WAYS)
def test_what_a_planar_limb_keeps_on_a_leg_is_true(name):
    obstacles, first, last, arm = WAYS[name]
    situation = planar(*obstacles, arm=arm)
    scene, (time, hand, _) = pack(situation), moves(first, last)
    least, _ = truth(situation, moves(first, last), (0.0, 0.0))
    poses, stack = np.zeros((len(situation.bodies), 12)), np.empty((DEEPEST + 2, 3))

    def keeps(floor):
        work = Sweep(time, hand, floor, 1e300, poses, stack)
        return leg_is_free(scene, work, np.empty(64), np.full(1, 10**9))

    assert least - 4.0 * HAIR < critical(keeps, 0.0) <= least + 1e-5
    found, when = least_distance(scene, time, hand, 0.0, EXACT)
    assert least - 1e-5 < found <= least + 1e-5 and 0.0 <= when <= 1.0
    for floor in (least + 1e-4, least - 1e-4):
        assert (least_distance(scene, time, hand, floor, 1e300)[0] > floor) == (floor < least)


def side(share, joint, gap):
    """Return a place beyond the hand of the spatial arm, on its way as a joint turns by 0.9."""
    way = POSTURE + np.outer((0.0, share), 0.9 * np.eye(4)[joint])
    hand = axes_of(spatial(), way)[0][1, 1, -1]
    return tuple(hand * (1.0 + gap / np.linalg.norm(hand)))


TURN = 0.9 * np.eye(4)
X, Y, Z = axes_of(spatial(), POSTURE[None])[0][1, 1, 0]
MOVES = {
    "ball passes at the begin": (spatial(((X + 0.15, Y, Z - 0.4), (0.0, 0.0, 20.0))), 0 * TURN[0]),
    "ball passes at the end": (spatial(((X + 0.15, Y, Z - 19.4), (0.0, 0.0, 20.0))), 0 * TURN[0]),
    "shoulder turns early": (spatial((side(0.07, 1, 0.2), STILL)), TURN[1]),
    "shoulder turns late": (spatial((side(0.95, 1, 0.2), STILL)), TURN[1]),
    "shoulder lifts": (spatial((side(0.3, 0, 0.2), STILL)), TURN[0]),
    "elbow bends": (spatial((side(0.8, 3, 0.1), STILL)), TURN[3]),
    "upper arm passes": (spatial(((0.567, 0.196, 0.15), STILL)), TURN[1]),
    "all turn": (spatial(((1.2, 0.9, 0.3), (0.0, -0.4, -0.3))), 0.6 * np.ones(4)),
    "second of two": (spatial(((0.0, 0.0, 3.0), STILL), (side(0.5, 1, 0.2), STILL)), TURN[1]),
}


@pytest.mark.parametrize("name", MOVES)
def test_what_a_limb_keeps_on_a_move_is_true(name):
    situation, turn = MOVES[name]
    agrees(situation, POSTURE, POSTURE + turn, [])


@pytest.mark.parametrize("joint", [1, 2])
def test_what_links_keep_of_each_other_is_true(joint):
    first = np.array((0.0, 0.3, 0.0))
    agrees(chain([0, 2]), first, first + (-0.1 if joint == 1 else 0.4) * np.eye(3)[joint], [(0, 2)])


CHAIN = np.array((0.0, 0.3, 0.0))  # its last link hangs at x = 0.6
BALLS = {
    "ball passes at the begin": (((0.75, 0.0, -0.3), (0.0, 0.0, 20.0)), (0.0, 0.0, 0.0)),
    "ball passes at the end": (((0.75, 0.0, -19.3), (0.0, 0.0, 20.0)), (0.0, 0.0, 0.0)),
    "slides": (((0.8, 0.15, 0.15), STILL), (0.0, 0.25, 0.0)),
    "turns": (((0.7, 0.5, 0.15), STILL), (0.8, 0.0, 0.0)),
}


@pytest.mark.parametrize("name", BALLS)
def test_what_a_chain_keeps_on_a_move_is_true(name):
    ball, turn = BALLS[name]
    agrees(chain(balls=[ball]), CHAIN, CHAIN + turn, [])


def agrees(situation, first, last, pairs):
    """Check what is kept on a straight move, at its least distance and beside it."""
    scene, way = pack(situation), moves(first, last)
    least, _ = truth(situation, way, (0.0, 0.0), pairs)
    desk = desk_of(scene)

    def keeps(touch):
        return move_is_free(scene, way[1][0], 0.0, way[1][1], 1.0, touch, desk)

    assert least - 1e-4 < critical(keeps) <= least + 1e-5
    if not pairs:
        keeps(0.0)  # the move is in the desk
        found, when = least_on(scene, 0.0, 1.0, -1.0, 1e-4, 1e300, desk)
        assert least - 1e-5 < found <= least + 1.1e-4 and 0.0 <= when <= 1.0
        desk.budget[0] = 0
        assert least_on(scene, 0.0, 1.0, least - 1e-7, EXACT, 1e300, desk)[0] <= least
