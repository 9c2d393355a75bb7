"""Bodies as faces, with arrows of approaches; paths as tubes, coloured by time."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from gcm_learn.motion import Movement
from gcm_learn.rendering.camera import Faces
from gcm_learn.rendering.colours import APPROACH, body_colour, rgb, time_colours
from gcm_learn.rendering.poses import JointSituation, body_poses, ground_of
from gcm_learn.rendering.solids import arrow, frame_along, placed, tube
from gcm_learn.rendering.staging import LONGEST
from gcm_learn.situation import Body

SMALLEST = 0.018  # of the reach: smaller targets are drawn so large
ARROW = 0.16  # of the reach: length of an approach
BEFORE = 0.012  # of the reach: from the point of an approach to the target


def body_faces(
    situation: JointSituation, t: float, alpha: float = 1.0, roles: Sequence[str] = ()
) -> Iterator[Faces]:
    """Yield the bodies at time t [s], or those in some roles, with their approaches.

    The ground is not among them: the stage has a floor there.
    """
    (centres, turns), ground = body_poses(situation, [t]), ground_of(situation)
    for body, centre, turn in zip(situation.bodies, centres[0], turns[0], strict=True):
        if (roles and body.role not in roles) or (ground is not None and body is ground.body):
            continue
        yield solid_faces(situation, body, centre, turn, alpha)
        if body.approach is not None:
            corners = centre + approach_corners(situation, body) @ turn.T
            yield Faces(corners, rgb(APPROACH), alpha)


def solid_faces(
    situation: JointSituation, body: Body, centre: np.ndarray, turn: np.ndarray, alpha: float = 1.0
) -> Faces:
    """Return a body at its place (3,), turned by a rotation (3, 3)."""
    colour, scale = rgb(body_colour(body)), drawn_scale(situation, body)
    return placed(body.shape, centre, turn, colour, alpha, scale)  # type: ignore[arg-type]


def drawn_scale(situation: JointSituation, body: Body) -> float:
    """Return the factor by which a body is drawn larger than it is, so that it can be seen."""
    if body.role != "target":
        return 1.0
    return max(1.0, SMALLEST * situation.arm.reach / body.shape.bounding_radius)


def approach_corners(situation: JointSituation, body: Body) -> np.ndarray:
    """Return the arrow (n, 4, 3) along which a hand catches a target, in the target's frame."""
    assert body.approach is not None
    reach = situation.arm.reach
    surface = drawn_scale(situation, body) * body.shape.bounding_radius
    pointing = arrow(ARROW * reach, surface + BEFORE * reach)
    turned: np.ndarray = pointing @ frame_along(np.asarray(body.approach.axis)).T
    return turned


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
    base, ground = np.asarray(situation.arm.base.origin), ground_of(situation)
    for path in target_paths(situation, times):
        far = np.linalg.norm(path - base, axis=1).max() / situation.arm.reach
        seen = far < LONGEST and (ground is None or path[:, 2].min() > ground.height)
        for faces in tube_faces(path, times / max(end, 1e-9), 0.8 * radius, dashed=True):
            yield faces._replace(kept=bool(seen))


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
