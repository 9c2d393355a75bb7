"""Actions of policies: a choice of a direction, or a velocity, both seen from the straight way.

A choice is one of 24 directions at full speed, or to rest. The first direction leads straight to
where the target can be met, the others follow counter-clockwise: they are the rays of the
observation's fan, so what is told of a ray is told of a choice. A choice can have several good
answers, left and right of an obstacle; a mean of them would lead into it. A velocity has its first
axis in the first direction, so that (1, 0) catches where nothing is in the way: who has to find out
about targets and about the frame of the moment at once hardly ever meets one at first.

In space policies say likewise how to differ from the command that goes straight, which is told: 0
goes there. Half of the largest difference stops a joint, all of it turns it about.
"""

from __future__ import annotations

import numpy as np

from gcm_learn.execution import MEETING, RAYS, AnySettings, SpatialSettings

REST = RAYS - 1
STEER = 2.0  # largest difference from the straight command in space [greatest joint speeds]
_SLOW = 0.25  # hands slower than this rest [hand speeds]


def velocities(observations: np.ndarray, choices: np.ndarray) -> np.ndarray:
    """Actions (n, 2) of choices (n,) under observations (n, width)."""
    angle = _straight(observations) + choices * (2.0 * np.pi / REST)
    out = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    out[choices == REST] = 0.0
    return out


def choices_of(observations: np.ndarray, actions: np.ndarray) -> np.ndarray:
    """The choices (n,) nearest to actions (n, 2)."""
    angle = np.arctan2(actions[:, 1], actions[:, 0]) - _straight(observations)
    nearest = np.round(angle * (REST / (2.0 * np.pi))).astype(np.int64) % REST
    return np.where(np.hypot(*actions.T) < _SLOW, REST, nearest)


def turned(observations: np.ndarray, aimed: np.ndarray) -> np.ndarray:
    """Actions (n, 2) of the arena of velocities (n, 2) as seen from the straight way."""
    return _rotated(aimed, _straight(observations))


def aimed_of(observations: np.ndarray, actions: np.ndarray) -> np.ndarray:
    """The reverse of `turned`."""
    return _rotated(actions, -_straight(observations))


def moved(settings: AnySettings, observations: np.ndarray, aimed: np.ndarray) -> np.ndarray:
    """Actions of the arena of what policies say: `turned`, in space `steered`."""
    if isinstance(settings, SpatialSettings):
        return steered(observations, aimed, settings.straight)
    return turned(observations, aimed)


def said(settings: AnySettings, observations: np.ndarray, actions: np.ndarray) -> np.ndarray:
    """The reverse of `moved`: what a policy says that acts so."""
    if isinstance(settings, SpatialSettings):
        at = settings.straight
        straight = observations[:, at : at + actions.shape[1]]
        return np.clip((actions - straight) / STEER, -1.0, 1.0)
    return aimed_of(observations, actions)


def steered(observations: np.ndarray, aimed: np.ndarray, at: int) -> np.ndarray:
    """Commands (n, 4) of arms in space of differences (n, 4) from the straight ones, told `at`."""
    straight = observations[:, at : at + aimed.shape[1]].astype(float)
    return np.clip(straight + STEER * aimed, -1.0, 1.0)


def _rotated(vectors: np.ndarray, angle: np.ndarray) -> np.ndarray:
    c, s = np.cos(angle), np.sin(angle)
    x, y = vectors.T
    return np.stack([c * x - s * y, s * x + c * y], axis=-1)


def _straight(observations: np.ndarray) -> np.ndarray:
    """Direction (n,) in which the target can be met [rad]."""
    x, y = observations[:, MEETING].astype(float), observations[:, MEETING + 1].astype(float)
    return np.arctan2(y, x)
