"""What a front is to explore, and what its answers are compared by."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from typing import NamedTuple

import numpy as np
import pytest

from gcm_learn.arms import Arm
from gcm_learn.charts.lattice import Lattice
from gcm_learn.scene import Scene, pack
from gcm_learn.situation import Body, Disc, PlanarQuadratic, Situation
from gcm_learn.wave import kappa_of
from gcm_learn.wave.kernels import CONTACT, FREE, FROZEN
from tests.transforms import mirrored, turned

SPEED = 3.4  # kappa is about 1/400 s on 80 cells
STILL = (0.0, 0.0)
SYMMETRIES = pytest.mark.parametrize(
    ("move", "back"),
    [
        (mirrored, lambda a: a[..., ::-1, :]),
        (lambda s: turned(s, 0.5 * np.pi), lambda a: np.rot90(a, axes=(-2, -1))),
        (lambda s: turned(s, np.pi), lambda a: np.rot90(a, 2, axes=(-2, -1))),
    ],
    ids=["mirror", "quarter turn", "half turn"],
)
"""Moves of a situation, and what takes its map (..., n, n) back."""


def disc(role, name, position, velocity=STILL, radius=0.1):
    return Body(role, name, Disc(radius), PlanarQuadratic(position, velocity, STILL))


class Setting(NamedTuple):
    """What a front runs in; the first two arguments of all engines."""

    scene: Scene
    lattice: Lattice

    @property
    def hand(self):
        return self.scene.limb.x, self.scene.limb.y

    @property
    def speed(self):
        return self.scene.limits.speed

    def limited(self, **changes):
        """Return the same with other limits of movement or another horizon."""
        scene = self.scene._replace(limits=self.scene.limits._replace(**changes))
        return self._replace(scene=scene)


def setting_of(situation, n=80):
    """Make a front's setting of a situation."""
    arm = situation.arm
    return Setting(pack(situation), Lattice(n, arm.upper_arm, arm.elbow))


def scene(*bodies, hand=(1.2, 0.3), horizon=1.0, **arm):
    """Make a situation of some bodies; a target far away makes it valid."""
    far = disc("target", "far away", (9.0, 0.0))
    return Situation("scene", horizon, Arm(hand, SPEED, **arm), (*bodies, far))


def three_discs(rng, moving=True, **arm):
    """Draw three obstacles away from the hand and a target that may be met."""
    places = []
    while len(places) < 4:
        place = rng.uniform(-1.6, 1.6, size=2)
        if np.hypot(place[0] - 1.2, place[1] - 0.3) > 0.6 and np.hypot(*place) > 0.5:
            places.append(tuple(float(v) for v in place))
    velocities = rng.uniform(-1.5, 1.5, size=(4, 2)) * moving
    roles = ("target", "obstacle", "obstacle", "obstacle")
    bodies = (
        disc(role, f"{role} {k}", places[k], tuple(float(v) for v in velocities[k]))
        for k, role in enumerate(roles)
    )
    return scene(*bodies, **arm)


def arrival_tau(setting, front, params):
    """Arrival times [tau], nan where the front never came."""
    return np.where(front.first >= 0.0, front.first / kappa_of(*setting, params), np.nan)


def state_of(front):
    """FREE, FROZEN or CONTACT of every cell."""
    return np.where(front.refused, FROZEN, np.where(front.met, CONTACT, FREE))


def away(setting):
    """Distance (n, n) of every cell's centre from the hand [cells]."""
    x, y = np.meshgrid(setting.lattice.centres, setting.lattice.centres)
    return np.hypot(x - setting.hand[0], y - setting.hand[1]) / setting.lattice.spacing


def earliest(front, n):
    """First arrival in every cell (n, n) [s], infinite where there is none."""
    out = np.full((n, n), np.inf)
    np.minimum.at(out, tuple(front.cells.T), front.arrival)
    return out


def in_threads(*works):
    """Results of some functions, each called in a thread of its own."""
    with ThreadPoolExecutor(len(works)) as pool:
        return [job.result() for job in [pool.submit(work) for work in works]]
