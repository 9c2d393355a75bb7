"""Bodies as faces, with an arrow where a target says from which side it is caught."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from gcm_learn.rendering.camera import Faces
from gcm_learn.rendering.colours import APPROACH, body_colour, rgb
from gcm_learn.rendering.poses import JointSituation, body_poses, ground_of
from gcm_learn.rendering.solids import arrow, frame_along, placed
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
