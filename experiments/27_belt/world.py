"""A Panda between a belt and a bin, under boxes that hang: one minute, and its picks as a family.

Parts come along y at irregular times and places. Boxes hang from a conveyor that runs the other
way. The arm rests over the bin and picks a part from above. The hand moves with it while a gripper
closes; then the arm carries it back to the posture from which it came.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from gcm_learn import Body, Situation, SolidQuadratic, rng
from gcm_learn.arms import Chain, hands_along
from gcm_learn.cover import Parameter, ParametricFamily
from gcm_learn.situation import Approach, Box, Hold, Place, shipped_arm

LENGTH = 60.0  # of all [s]
HOME = (-1.35, -0.3, 0.0, -2.2, 0.0, 1.9, 0.785)
LIMITS: dict[str, Any] = {
    "max_joint_acceleration": (15.0, 7.5, 10.0, 12.5, 15.0, 20.0, 20.0),
    "max_joint_jerk": (3750.0,) * 7,
}
PANDA = Chain(shipped_arm("panda"), HOME, grasp=0.03, **LIMITS)
BIN: tuple[float, float, float] = tuple(hands_along(PANDA, np.array([HOME]))[0][0].tolist())
"""Place of the hand at home, over the bin [m]."""
HORIZON = 1.6  # of a catch [s]
FORMAT = "gcm-learn/situation@4"

BELT_X, BELT_TOP, PACE = 0.55, 0.05, 0.25  # [m], [m/s]
HALF = (0.025, 0.025, 0.025)  # of a part [m]
FIRST, LAST = -0.42, 0.08  # where parts are when their catch begins [m]
WIDE = 0.05  # most that parts are off the middle of the belt [m]
GAPS = (0.3, 0.9)  # from part to part [m]
NEAR = 1.5  # along the belt: parts that are seen [m]
DOWN, HOLD = Approach((0.0, 0.0, -1.0), 0.5), Hold(0.2, 0.1)
BRIEF = 0.4  # the belt is no obstacle of a carried part for so long [s]

BOX, APART, BOX_PACE = (0.08, 0.08, 0.08), 1.0, -0.3  # of boxes that hang [m], [m/s]
BOX_X, BOX_Z = 0.5, 0.36  # [m]
COMING = (-1, 0, 1, 2)  # boxes that may be near the arm in a pick


def solid(name: str, shape: Any, place: tuple[float, float, float], pace: float = 0.0) -> Body:
    """Return an obstacle that moves along the belt."""
    law = SolidQuadratic(place, (0.0, pace, 0.0), (0.0, 0.0, 0.0))
    return Body("obstacle", name, shape, law)


def at_rest() -> tuple[Body, ...]:
    """Return the belt and the walls of the bin."""
    x, y, _ = BIN
    wide, thin, high = 0.1, 0.006, 0.06
    walls = {
        "right": ((wide, thin), (0.0, -wide)),
        "left": ((wide, thin), (0.0, wide)),
        "near": ((thin, wide), (-wide, 0.0)),
        "far": ((thin, wide), (wide, 0.0)),
    }
    belt = solid("belt", Box((0.1, 1.0, 0.02)), (BELT_X, 0.2, BELT_TOP - 0.02))
    return belt, *(
        solid(name, Box((*half, high)), (x + dx, y + dy, high))
        for name, (half, (dx, dy)) in walls.items()
    )


def hung(phase: float) -> tuple[Body, ...]:
    """Return the boxes near the arm at some phase of their conveyor [m]."""
    return tuple(
        solid(f"box {k}", Box(BOX), (BOX_X, phase + k * APART, BOX_Z), BOX_PACE) for k in COMING
    )


def part(name: str, along: float, across: float) -> Body:
    """Return a part on the belt, which is to be held."""
    place = (BELT_X + across, along, BELT_TOP + HALF[2] + 0.001)
    law = SolidQuadratic(place, (0.0, PACE, 0.0), (0.0, 0.0, 0.0))
    return Body("target", name, Box(HALF), law, (DOWN,), HOLD)


def of(name: str, bodies: tuple[Body, ...]) -> Any:
    """Return a situation whose arm starts at home among bodies and ends at rest."""
    end: Any = {"end": "rest", "end_by": 2.0 * HORIZON, "format": FORMAT}
    return Situation(name, HORIZON, PANDA, bodies, **end)


def picks() -> ParametricFamily:
    """Return the situations of one pick: the part's place along and across, the phase of boxes."""
    middle, ways = 0.5 * (FIRST + LAST), (0.0, 1.0, 0.0)
    boxes = hung(0.0)
    moves = tuple((box.name, "position", ways) for box in boxes)
    parameters = (
        Parameter("along", FIRST, LAST, "m", (("part", "position", ways),)),
        Parameter("across", -WIDE, WIDE, "m", (("part", "position", (1.0, 0.0, 0.0)),)),
        Parameter("phase", -0.5 * APART, 0.5 * APART, "m", moves),
    )
    situation = of("pick", (part("part", middle, 0.0), *at_rest(), *boxes))
    return ParametricFamily(
        "pick", "a part on a belt, under boxes that hang", situation, parameters
    )


@dataclass(frozen=True)
class Minute:
    """Parts that come by, and boxes."""

    seed: int

    @cached_property
    def parts(self) -> dict[str, tuple[float, float]]:
        """Places along and across the belt at t = 0, by name [m]."""
        random, along, found = rng(self.seed), FIRST, {}
        while along > LAST - PACE * LENGTH:
            across = random.uniform(-WIDE, WIDE)
            found[f"part {len(found) + 1}"] = along, across
            along -= random.uniform(*GAPS)
        return found

    @cached_property
    def phase(self) -> float:
        """Phase of the conveyors at t = 0 [m]."""
        return float(rng(self.seed, 1).uniform(-0.5, 0.5) * APART)

    def along(self, name: str, t: float) -> float:
        """Return the place of a part along the belt at t [s]."""
        return self.parts[name][0] + PACE * t

    def boxes(self, t: float) -> tuple[Body, ...]:
        """Return the boxes near the arm at t [s]."""
        return hung((self.phase + BOX_PACE * t + 0.5 * APART) % APART - 0.5 * APART)

    def reached(self, t: float, gone: set[str]) -> list[str]:
        """Return the parts whose catch may begin at t [s], the farthest first."""
        left = [name for name in self.parts if name not in gone]
        return [name for name in left if FIRST <= self.along(name, t) <= LAST]

    def near(self, t: float, gone: set[str]) -> tuple[Body, ...]:
        """Return the parts near the arm at t [s], without those that are gone."""
        left = {name: self.along(name, t) for name in self.parts if name not in gone}
        return tuple(
            part(name, along, self.parts[name][1])
            for name, along in left.items()
            if abs(along) < NEAR
        )

    def moment(self, t: float, wanted: str, gone: set[str]) -> Any:
        """Return the situation at t [s], in which one part is wanted and others are in the way."""
        free: Any = {"role": "obstacle", "approach": (), "hold": None}
        others = tuple(replace(body, **free) for body in self.near(t, gone | {wanted}))
        aim = part(wanted, self.along(wanted, t), self.parts[wanted][1])
        return of(wanted, (aim, *others, *at_rest(), *self.boxes(t)))


def with_place(situation: Any) -> Any:
    """Return the situation of a pick whose part has to come to the bin."""
    place = Place(BIN, 0.08)
    bodies = tuple(
        replace(b, place=place, ignore=("belt",), ignore_for=BRIEF) if b.role == "target" else b
        for b in situation.bodies
    )
    return replace(situation, bodies=bodies, end_by=10.0)
