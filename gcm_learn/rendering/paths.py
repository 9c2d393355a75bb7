"""Paths of hand and targets as tubes, coloured by time."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from gcm_learn.motion import Movement
from gcm_learn.rendering.camera import Faces
from gcm_learn.rendering.colours import time_colours
from gcm_learn.rendering.poses import JointSituation, body_poses
from gcm_learn.rendering.solids import tube
from gcm_learn.rendering.staging import LONGEST

LINE = 0.007  # of the reach: radius of a path
SAMPLES = 60  # points of a path


def path_faces(
    situation: JointSituation, trajectory: Movement, until: float | None = None
) -> Iterator[Faces]:
    """Yield the paths of the hand and, dashed, of the targets, up to a time [s]."""
    end = trajectory.duration
    times = np.linspace(0.0, end if until is None else until, SAMPLES)
    radius = LINE * situation.arm.reach
    yield from tube_faces(trajectory.hand_at(times), times / max(end, 1e-9), radius)
    base = np.asarray(situation.arm.base.origin)
    for path in target_paths(situation, times):
        far = np.linalg.norm(path - base, axis=1).max() / situation.arm.reach
        for faces in tube_faces(path, times / max(end, 1e-9), 0.8 * radius, dashed=True):
            yield faces._replace(kept=bool(far < LONGEST.of(situation)))


def target_paths(situation: JointSituation, times: np.ndarray) -> np.ndarray:
    """Return the places (m, k, 3) of the targets' centres at times (k,) [s], in the world."""
    targets = [body.role == "target" for body in situation.bodies]
    return np.swapaxes(body_poses(situation, times)[0][:, targets], 0, 1)


def tube_faces(
    path: np.ndarray, shares: np.ndarray, radius: float, *, dashed: bool = False
) -> Iterator[Faces]:
    """Yield a path (k, 3) as a tube, coloured by shares (k,) of the time; nothing if short."""
    if np.ptp(path, axis=0).max() <= radius:
        return
    shades = time_colours(0.5 * (shares[1:] + shares[:-1]))
    shown = np.arange(len(shades)) % 3 != 2 if dashed else np.ones(len(shades), dtype=bool)
    parts = tube(path, radius).reshape(len(shades), 6, 4, 3)[shown]
    yield Faces(parts.reshape(-1, 4, 3), np.repeat(shades[shown], 6, axis=0)[:, None])
