"""Actions of policies: a choice of a direction, or a velocity, both seen from the straight way.

For planar arms a choice is one of 24 directions at full speed, or rest. The first direction leads
straight to the meeting with the target, the others follow counter-clockwise. They are the rays of
the observation's fan, so each choice has its numbers there. A choice can have several good answers,
left and right of an obstacle; a mean of them would lead into it. A velocity has its first axis in
the first direction, so that (1, 0) catches if nothing is in the way. Otherwise learners hardly ever
meet a target at first.

For spatial arms a choice is one of 30 commands of the joints, the rays of the fan in
`execution.arena.kernels.joints.fan`. The first is the command that goes straight. Velocities are
differences from that command: 0 goes straight, half of the largest difference stops a joint, all
of it turns the joint about. With a fan, differences are in its frame.
"""

from __future__ import annotations

import numpy as np

from gcm_learn.arms import PLANAR, ByKind
from gcm_learn.execution import AIM, COMMANDS, MEETING, RAYS, ArenaSettings, commands_of

REST = RAYS - 1
STEER = 2.0  # largest difference from the straight command [greatest joint speeds]
_SLOW = 0.25  # hands slower than this rest [hand speeds]


def choices_in(settings: ArenaSettings) -> int:
    """Return the number of choices; 0 where policies can only say how to differ."""
    return LANGUAGES.of(settings.kind).choices(settings)


def is_bounded(settings: ArenaSettings) -> bool:
    """Return whether cloned velocities pass through a tanh."""
    return LANGUAGES.of(settings.kind).bounded


def chosen(settings: ArenaSettings, observations: np.ndarray, choices: np.ndarray) -> np.ndarray:
    """Return actions (n, commands) of choices (n,) under observations (n, width)."""
    return LANGUAGES.of(settings.kind).chosen(settings, observations, choices)


def choices_of(
    settings: ArenaSettings, observations: np.ndarray, actions: np.ndarray
) -> np.ndarray:
    """Return the choices (n,) nearest to actions (n, commands)."""
    return LANGUAGES.of(settings.kind).choices_of(settings, observations, actions)


def moved(settings: ArenaSettings, observations: np.ndarray, aimed: np.ndarray) -> np.ndarray:
    """Return actions of the arena from velocities as policies see them.

    These are seen from the straight way for planar arms, and differences from the straight command
    for spatial ones.
    """
    return LANGUAGES.of(settings.kind).moved(settings, observations, aimed)


def said(settings: ArenaSettings, observations: np.ndarray, actions: np.ndarray) -> np.ndarray:
    """Return the inverse of `moved`."""
    return LANGUAGES.of(settings.kind).said(settings, observations, actions)


def turned(observations: np.ndarray, aimed: np.ndarray) -> np.ndarray:
    """Return actions (n, 2) of velocities (n, 2) as seen from the straight way."""
    return _rotated(aimed, _straight(observations))


def aimed_of(observations: np.ndarray, actions: np.ndarray) -> np.ndarray:
    """Return the inverse of `turned`."""
    return _rotated(actions, -_straight(observations))


class _Hands:
    """Velocities of planar arms; the methods are the functions above."""

    bounded = True

    def choices(self, settings: ArenaSettings) -> int:
        return RAYS

    def chosen(
        self, settings: ArenaSettings, observations: np.ndarray, choices: np.ndarray
    ) -> np.ndarray:
        angle = _straight(observations) + choices * (2.0 * np.pi / REST)
        out = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
        out[choices == REST] = 0.0
        return out

    def choices_of(
        self, settings: ArenaSettings, observations: np.ndarray, actions: np.ndarray
    ) -> np.ndarray:
        angle = np.arctan2(actions[:, 1], actions[:, 0]) - _straight(observations)
        nearest = np.round(angle * (REST / (2.0 * np.pi))).astype(np.int64) % REST
        return np.where(np.hypot(*actions.T) < _SLOW, REST, nearest)

    def moved(
        self, settings: ArenaSettings, observations: np.ndarray, aimed: np.ndarray
    ) -> np.ndarray:
        return turned(observations, aimed)

    def said(
        self, settings: ArenaSettings, observations: np.ndarray, actions: np.ndarray
    ) -> np.ndarray:
        return aimed_of(observations, actions)


class _Joints:
    """Commands of joints; the methods are the functions above."""

    bounded = False  # PPO, which begins as a clone, has no tanh

    def choices(self, settings: ArenaSettings) -> int:
        return COMMANDS if settings.fan and not settings.pushed else 0

    def chosen(
        self, settings: ArenaSettings, observations: np.ndarray, choices: np.ndarray
    ) -> np.ndarray:
        out = np.empty((len(choices), settings.commands))
        commands_of(observations, AIM, settings.fan_at, choices, out)
        return out

    def choices_of(
        self, settings: ArenaSettings, observations: np.ndarray, actions: np.ndarray
    ) -> np.ndarray:
        nearest, found = np.full(len(actions), np.inf), np.zeros(len(actions), np.int64)
        for ray in range(COMMANDS):
            mine = self.chosen(settings, observations, np.full(len(actions), ray))
            away = np.sum((mine - actions) ** 2, axis=1)
            found[away < nearest], nearest = ray, np.minimum(away, nearest)
        return found

    def moved(
        self, settings: ArenaSettings, observations: np.ndarray, aimed: np.ndarray
    ) -> np.ndarray:
        straight = _straight_command(settings, observations)
        if self.choices(settings):
            aimed = np.einsum("ni,nij->nj", aimed, _frame(settings, observations))
        return np.clip(straight + STEER * aimed, -1.0, 1.0)

    def said(
        self, settings: ArenaSettings, observations: np.ndarray, actions: np.ndarray
    ) -> np.ndarray:
        aimed = (actions - _straight_command(settings, observations)) / STEER
        if self.choices(settings):
            aimed = np.einsum("nj,nij->ni", aimed, _frame(settings, observations))
        return np.clip(aimed, -1.0, 1.0)


LANGUAGES: ByKind[_Hands | _Joints] = ByKind({PLANAR: _Hands()}, default=_Joints())
"""By kind of arm."""


def _straight_command(settings: ArenaSettings, observations: np.ndarray) -> np.ndarray:
    """Return commands (n, commands) that go straight, from the observations."""
    until = settings.straight + settings.commands
    found: np.ndarray = observations[:, settings.straight : until].astype(float)
    return found


def _frame(settings: ArenaSettings, observations: np.ndarray) -> np.ndarray:
    """Return frames (n, commands, commands) of fans, their vectors as rows."""
    size = settings.commands
    told = observations[:, settings.fan_at : settings.fan_at + size * size].astype(float)
    return told.reshape(-1, size, size)


def _rotated(vectors: np.ndarray, angle: np.ndarray) -> np.ndarray:
    c, s = np.cos(angle), np.sin(angle)
    x, y = vectors.T
    return np.stack([c * x - s * y, s * x + c * y], axis=-1)


def _straight(observations: np.ndarray) -> np.ndarray:
    """Return directions (n,) in which the target can be met [rad]."""
    x, y = observations[:, MEETING].astype(float), observations[:, MEETING + 1].astype(float)
    return np.arctan2(y, x)
