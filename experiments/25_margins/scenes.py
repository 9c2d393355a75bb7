"""Scenes in which a Panda reaches for a target while recorded bodies cross its way.

Draws know of a body what its law foretells, and not what it did.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from gcm_learn import seeding
from gcm_learn.arms import Base, Chain, hands_along
from gcm_learn.outside import Window, laws_of, places_of
from gcm_learn.outside.ball_flight import RADIUS, TABLE
from gcm_learn.outside.converted import is_blocked
from gcm_learn.outside.table_tennis import READY, table
from gcm_learn.situation import (
    Body,
    Capsule,
    Margin,
    Sampled,
    Situation,
    SolidQuadratic,
    Sphere,
    shipped_arm,
)

HORIZON, REACHED = 0.5, 0.4  # of a scene; when the hand can be at the target [s]
STEPS = np.linspace(0.0, HORIZON, 26)
FREE = Margin(0.0, 0.0)
BALLS, NEAR, BEFORE = 6, 0.1, 0.5  # number; to the way of the hand; along the table at t = 0 [m]
PEOPLE, WAIST, TALL, ASIDE = 1, 0.25, 1.7, 0.3  # number; radius, height, most beside the hand [m]
PEDESTAL = 0.8  # of an arm among people [m]


class Scene(NamedTuple):
    """An arm, its target, the table, and bodies with the laws that foretell them."""

    name: str
    arm: Chain
    fixed: tuple[Body, ...]
    shape: Any
    laws: tuple[Any, ...]
    windows: tuple[Window, ...]

    def situation(self, margin: Margin | None) -> Situation[Chain]:
        """Return the scene with foretold bodies and a margin, or with recorded ones."""
        told = self.laws if margin is not None else tuple(map(recorded, self.windows))
        bodies = [
            Body("obstacle", f"body-{k}", self.shape, law, margin=margin or FREE)
            for k, law in enumerate(told)
        ]
        return Situation(self.name, HORIZON, self.arm, (*self.fixed, *bodies))


def recorded(window: Window) -> Sampled:
    """Return the motion of a recorded body."""
    return Sampled(tuple(window.times.tolist()), tuple(map(tuple, window.places.tolist())))


def reach(rng: np.random.Generator, base: Base) -> tuple[Chain, np.ndarray, Body]:
    """Return an arm, a straight way of its hand (m, 3) at `STEPS`, and a target at its end."""
    arm = Chain(shipped_arm("panda"), READY["panda"], 0.05, base)
    low, high = np.array(arm.model.ranges).T
    begin, n = np.array(READY["panda"]), len(READY["panda"])
    turns = rng.uniform(0.5, 1.0, n) * rng.choice([-1.0, 1.0], n)
    goal = np.clip(begin + REACHED * np.array(arm.max_joint_speed) * turns, low, high)
    share = np.minimum(STEPS / REACHED, 1.0)[:, None]
    way = hands_along(arm, begin + share * (goal - begin))[0]
    angle, fast = rng.uniform(0.0, 2.0 * np.pi), rng.uniform(0.5, 1.5)
    speed = fast * np.array([np.cos(angle), np.sin(angle), 0.0])
    law = SolidQuadratic(tuple(way[-1] - REACHED * speed), tuple(speed), (0.0, 0.0, 0.0))
    return arm, way, Body("target", "goal", Sphere(0.03), law)


class Balls:
    """Draws beside a table, at either side of which the arm stands.

    By their laws, balls begin before the arm and come near the hand's straight way in time.
    """

    predictor, looks, count = "ball", 1, BALLS

    def __init__(self, windows: Sequence[Window]) -> None:
        self.windows, self.laws = windows, laws_of(windows, self.predictor)
        self.foretold = np.array([places_of(law, STEPS) for law in self.laws])

    def scene(self, rng: np.random.Generator, name: str) -> Scene | None:
        """Return a scene, or None if too few balls come near."""
        side, along = rng.choice([-1.0, 1.0]), rng.uniform(-1.0, 0.6)
        turn = (1.0, 0.0, 0.0, 0.0) if side < 0.0 else (0.0, 0.0, 0.0, 1.0)
        arm, way, target = reach(rng, Base((side * (TABLE[0] + 0.25), along, 0.0), turn))
        apart = np.linalg.norm(self.foretold - way, axis=2).min(axis=1)
        near = np.flatnonzero((apart < NEAR) & (self.foretold[:, 0, 1] - along > BEFORE))
        if way[-1, 2] < 0.1 or len(near) < self.count:
            return None
        some = rng.choice(near, self.count, replace=False).tolist()
        laws, windows = ([row[k] for k in some] for row in (self.laws, self.windows))
        return Scene(name, arm, (target, table()), Sphere(RADIUS), tuple(laws), tuple(windows))


class People:
    """Draws of people, turned and moved so that by their laws they pass the hand's way."""

    predictor, looks, count = "velocity", 3, PEOPLE

    def __init__(self, windows: Sequence[Window]) -> None:
        self.windows = windows

    def scene(self, rng: np.random.Generator, name: str) -> Scene | None:
        """Return a scene, or None if somebody touches the arm at the start."""
        arm, way, target = reach(rng, Base((0.0, 0.0, PEDESTAL)))
        windows = []
        for k in rng.choice(len(self.windows), self.count, replace=False).tolist():
            (law,) = laws_of([self.windows[k]], self.predictor)
            when = int(rng.integers(10, len(STEPS)))
            angle, aside = rng.uniform(0.0, 2.0 * np.pi, 2)
            away = WAIST + rng.uniform(0.0, ASIDE)
            there = way[when] + away * np.array([np.cos(aside), np.sin(aside), 0.0])
            there[2] = 0.5 * TALL
            windows.append(turned(self.windows[k], angle, places_of(law, STEPS)[when], there))
        laws = laws_of(windows, self.predictor)
        shape = Capsule(WAIST, 0.5 * TALL - WAIST)
        made = Scene(name, arm, (target,), shape, tuple(laws), tuple(windows))
        return None if is_blocked(made.situation(FREE)) else made


def turned(window: Window, angle: float, place: np.ndarray, there: np.ndarray) -> Window:
    """Return a window turned about the vertical through a place, which is moved."""
    c, s = np.cos(angle), np.sin(angle)
    turn = np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
    seen, places = ((rows - place) @ turn + there for rows in (window.seen, window.places))
    return window._replace(seen=seen, places=places)


def draws(kind: Balls | People, seed: int, count: int) -> list[Scene]:
    """Return scenes, of which each has a number of its own."""
    found = []
    for k in range(count):
        rng, scene = seeding.rng(seed, 2, k), None
        while scene is None:
            scene = kind.scene(rng, f"scene-{k}")
        found.append(scene)
    return found
