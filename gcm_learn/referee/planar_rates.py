"""Rates of a planar arm's joints while its hand moves straight."""

from __future__ import annotations

from typing import Protocol

import numpy as np

from gcm_learn.referee.rotations import Array

INSTANTS = 33
"""Of a piece, ends included, and again around the highest rates."""


class Elbowed(Protocol):
    """An arm of two segments in the plane."""

    @property
    def rho(self) -> float:
        """Length of the upper arm [forearms]."""
        ...

    def elbows(self, hand: Array) -> Array:
        """Return elbows (k, 2) of hands (k, 2)."""
        ...


def joint_rates(arm: Elbowed, time: Array, hand: Array) -> Array:
    """Return the highest rates (n - 1, 2) of both joints in each piece [rad/s]."""
    span = np.diff(time)
    moves = (span > 0.0) & (np.diff(hand, axis=0) != 0.0).any(axis=1)
    out = np.zeros((len(span), 2))
    s = np.broadcast_to(np.linspace(0.0, 1.0, INSTANTS), (len(span), INSTANTS))
    for _ in range(2):
        rates = _rates(arm, span, hand, s)
        out = np.maximum(out, rates.max(axis=1))
        top = rates.max(axis=2).argmax(axis=1)
        rows = np.arange(len(span))
        low, high = s[rows, np.maximum(top - 1, 0)], s[rows, np.minimum(top + 1, INSTANTS - 1)]
        s = np.linspace(low, high, INSTANTS, axis=1)
    out = np.maximum(out, _rates(arm, span, hand, nearest_shares(hand)).max(axis=1))
    return np.where(moves[:, None], out, 0.0)


def nearest_shares(hand: Array) -> Array:
    """Return shares (n - 1, 1) of the pieces at which they are nearest to the shoulder.

    Rates peak there, as narrowly as the hand passes near.
    """
    step = np.diff(hand, axis=0)
    length2 = (step**2).sum(axis=1)
    s = -(hand[:-1] * step).sum(axis=1) / np.where(length2 > 0.0, length2, 1.0)
    return np.clip(s, 0.0, 1.0)[:, None]


def _rates(arm: Elbowed, span: Array, hand: Array, s: Array) -> Array:
    """Return absolute rates (n - 1, m, 2) at shares s (n - 1, m) of the pieces.

    With f the forearm's direction, u the upper arm's, and n the quarter turn, the hand's velocity
    is rho w1 (n u) + (w1 + w2) (n f).
    """
    step = np.diff(hand, axis=0)
    velocity = (step / np.where(span > 0.0, span, 1.0)[:, None])[:, None]
    place = hand[:-1, None] + s[:, :, None] * step[:, None]
    elbow = arm.elbows(place.reshape(-1, 2)).reshape(place.shape)
    u, f = elbow / arm.rho, place - elbow
    across = u[..., 0] * f[..., 1] - u[..., 1] * f[..., 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        first = (velocity * f).sum(axis=2) / (arm.rho * across)
        second = -(velocity * place).sum(axis=2) / (arm.rho * across)
    return np.nan_to_num(np.abs(np.stack([first, second], axis=2)), nan=0.0)
