"""Actions of policies: a choice of a direction, or a velocity, both seen from the straight way.

A choice is one of 24 directions at full speed, or to rest. The first direction leads straight to
where the target can be met, the others follow counter-clockwise: they are the rays of the
observation's fan, so what is told of a ray is told of a choice. A choice can have several good
answers, left and right of an obstacle; a mean of them would lead into it. A velocity has its first
axis in the first direction, so that (1, 0) catches where nothing is in the way: who has to find out
about targets and about the frame of the moment at once hardly ever meets one at first.

In space a choice is one of 30 commands of the joints, the rays of the fan there
(`execution.space.fan`); the first is the command that goes straight. Others say how to differ from
that command, which is told: 0 goes there. Half of the largest difference stops a joint, all of it
turns it about. Where there is a fan, differences are in its frame.
"""

from __future__ import annotations

import numpy as np

from gcm_learn.execution import (
    AIM,
    COMMANDS,
    MEETING,
    RAYS,
    AnySettings,
    PhysicalSettings,
    SpatialSettings,
    commands_of,
)

REST = RAYS - 1
STEER = 2.0  # largest difference from the straight command in space [greatest joint speeds]
_SLOW = 0.25  # hands slower than this rest [hand speeds]


def choices_in(settings: AnySettings) -> int:
    """How many choices there are; 0 where all that can be told is how to differ."""
    if not isinstance(settings, SpatialSettings):
        return RAYS
    pushed = isinstance(settings, PhysicalSettings) and settings.control == "torque"
    return COMMANDS if settings.fan and not pushed else 0


def chosen(settings: AnySettings, observations: np.ndarray, choices: np.ndarray) -> np.ndarray:
    """Actions (n, 2), in space (n, 4), of choices (n,) under observations (n, width)."""
    if isinstance(settings, SpatialSettings):
        out = np.empty((len(choices), 4))
        commands_of(observations, AIM, settings.fan_at, choices, out)
        return out
    return _velocities(observations, choices)


def choices_of(settings: AnySettings, observations: np.ndarray, actions: np.ndarray) -> np.ndarray:
    """The choices (n,) nearest to actions (n, 2), in space (n, 4)."""
    if isinstance(settings, SpatialSettings):
        nearest, found = np.full(len(actions), np.inf), np.zeros(len(actions), np.int64)
        for ray in range(COMMANDS):
            mine = chosen(settings, observations, np.full(len(actions), ray))
            away = np.sum((mine - actions) ** 2, axis=1)
            found[away < nearest], nearest = ray, np.minimum(away, nearest)
        return found
    angle = np.arctan2(actions[:, 1], actions[:, 0]) - _straight(observations)
    nearest = np.round(angle * (REST / (2.0 * np.pi))).astype(np.int64) % REST
    return np.where(np.hypot(*actions.T) < _SLOW, REST, nearest)


def _velocities(observations: np.ndarray, choices: np.ndarray) -> np.ndarray:
    """Actions (n, 2) in the plane of choices (n,) under observations (n, width)."""
    angle = _straight(observations) + choices * (2.0 * np.pi / REST)
    out = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    out[choices == REST] = 0.0
    return out


def turned(observations: np.ndarray, aimed: np.ndarray) -> np.ndarray:
    """Actions (n, 2) of the arena of velocities (n, 2) as seen from the straight way."""
    return _rotated(aimed, _straight(observations))


def aimed_of(observations: np.ndarray, actions: np.ndarray) -> np.ndarray:
    """The reverse of `turned`."""
    return _rotated(actions, -_straight(observations))


def moved(settings: AnySettings, observations: np.ndarray, aimed: np.ndarray) -> np.ndarray:
    """Actions of the arena of what policies say: `turned`, in space differences."""
    if not isinstance(settings, SpatialSettings):
        return turned(observations, aimed)
    straight = _straight_command(settings, observations)
    if choices_in(settings):
        aimed = np.einsum("ni,nij->nj", aimed, _frame(settings, observations))
    return np.clip(straight + STEER * aimed, -1.0, 1.0)


def said(settings: AnySettings, observations: np.ndarray, actions: np.ndarray) -> np.ndarray:
    """The reverse of `moved`: what a policy says that acts so."""
    if not isinstance(settings, SpatialSettings):
        return aimed_of(observations, actions)
    aimed = (actions - _straight_command(settings, observations)) / STEER
    if choices_in(settings):
        aimed = np.einsum("nj,nij->ni", aimed, _frame(settings, observations))
    return np.clip(aimed, -1.0, 1.0)


def _straight_command(settings: SpatialSettings, observations: np.ndarray) -> np.ndarray:
    """The command (n, 4) that goes straight, as it is told."""
    found: np.ndarray = observations[:, settings.straight : settings.straight + 4].astype(float)
    return found


def _frame(settings: SpatialSettings, observations: np.ndarray) -> np.ndarray:
    """Frames (n, 4, 4) of fans, their vectors as rows."""
    told = observations[:, settings.fan_at : settings.fan_at + 16].astype(float)
    return told.reshape(-1, 4, 4)


def _rotated(vectors: np.ndarray, angle: np.ndarray) -> np.ndarray:
    c, s = np.cos(angle), np.sin(angle)
    x, y = vectors.T
    return np.stack([c * x - s * y, s * x + c * y], axis=-1)


def _straight(observations: np.ndarray) -> np.ndarray:
    """Direction (n,) in which the target can be met [rad]."""
    x, y = observations[:, MEETING].astype(float), observations[:, MEETING + 1].astype(float)
    return np.arctan2(y, x)
