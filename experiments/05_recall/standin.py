"""Planar situations unlike the families', in which a straight line fails.

Arms differ: upper arms of 0.55 to 1.6 forearms, thick limbs, slow and fast hands. Two to six bodies
of all shapes and sizes are anywhere, half of them at rest. Kept are situations that `layered`
catches and `straight` does not: W if `marching` catches, else Q. Families are classes of arms.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import count

from gcm_learn import get_planner, seeding
from gcm_learn.evaluation import Case
from gcm_learn.families.family import ArmRanges
from gcm_learn.families.random_planar import RandomPlanar

ARM = ArmRanges(
    upper_arm=(0.55, 1.6), thickness=(0.0, 0.03, 0.06), hand_speed=(1.5, 5.0), horizon=(0.7, 2.0)
)
FAMILY = RandomPlanar(
    arm=ARM, obstacles=(2, 6), still=0.5, radius=(0.05, 0.4), half_length=(0.1, 0.8),
    corners=(0.08, 0.45),
)  # fmt: skip
TRAINED = (0.8, 1.15)  # upper arms [forearms]


def standins(seed: int) -> Iterator[Case]:
    """Yield the situations of a seed that are kept."""
    straight, marching, layered = map(get_planner, ("straight", "marching", "layered"))
    for index in count():
        situation = FAMILY.draw(seeding.rng(seed, index), f"stand-in-{index:05d}")
        if straight.plan(situation).caught or not layered.plan(situation).caught:
            continue
        stratum = "W" if marching.plan(situation).caught else "Q"
        arm = situation.arm.upper_arm
        side = "short" if arm < TRAINED[0] else "long" if arm > TRAINED[1] else "as trained"
        yield Case(situation, "stand-in", side, stratum)
