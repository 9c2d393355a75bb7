"""A camera that sees an arm, its path and the targets well; pictures of an arm as it acts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from gcm_learn.motion import Movement
from gcm_learn.rendering.bodies import body_faces, path_faces, target_paths
from gcm_learn.rendering.camera import Camera, Faces, Window, camera_from, render
from gcm_learn.rendering.limbs import arm_faces, limb_along
from gcm_learn.rendering.poses import JointSituation
from gcm_learn.rendering.staging import floor_of, staged

SIGHT = 28  # pixels a side of pictures that are tried for what they hide
EYE = 7.0  # [reaches] distance of the eye
ELEVATION = 24.0  # [degrees] of the eye
TRIED = 12  # instants of a movement that are sampled


def view_of(
    situation: JointSituation,
    trajectory: Movement | None = None,
    *,
    elevation: float = ELEVATION,
    turn: float = 0.0,
) -> Camera:
    """Return a camera that sees arm and hand's path from the side, and little in front of them.

    Parameters
    ----------
    situation : Situation
        With an arm that moves in its joints.
    trajectory : Movement, optional

    Other Parameters
    ----------------
    elevation : float
        Of the eye [degrees].
    turn : float
        The camera is turned about the vertical by so much [degrees].
    """
    arm = situation.arm
    end = situation.horizon if trajectory is None else trajectory.duration
    times = np.linspace(0.0, end, TRIED)
    rest = np.tile(arm.joints, (TRIED, 1))
    joints = rest if trajectory is None else trajectory.joints_at(times)
    limb, targets = limb_along(arm, joints), target_paths(situation, times[-3:])
    tips = limb.ends[:, :, 1].reshape(-1, 3)
    seen = np.concatenate([limb.base[None], tips, limb.hand, targets.reshape(-1, 3)])
    centre = 0.5 * (limb.base + limb.hand.mean(axis=0))
    wanted = [*arm_faces(arm, joints[-1]), *body_faces(situation, end, roles=("target",))]
    wanted += [] if trajectory is None else path_faces(situation, trajectory)
    others = list(body_faces(situation, end, roles=("obstacle",)))

    def merit(azimuth: float) -> float:
        view = camera_from(azimuth, elevation, centre, EYE * arm.reach)
        flat = view.turned(seen - centre)[:, :2]
        spread = np.sqrt(np.linalg.det(np.cov(flat.T)) + 1e-12) / arm.reach**2
        return float(spread * _share_in_sight(view, arm.reach, wanted, others) ** 2)

    best = max(np.arange(0.0, 360.0, 20.0), key=merit)
    return camera_from(best + turn, elevation, centre, EYE * arm.reach)


def _share_in_sight(
    view: Camera, reach: float, wanted: Sequence[Faces], others: Sequence[Faces]
) -> float:
    """Return the share of what is wanted in a picture that others leave in sight."""
    red, blue = np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0])
    marked = [thing._replace(colours=red, lit=False) for thing in wanted]
    hiding = [thing._replace(colours=blue, lit=False) for thing in others]
    window = Window(np.zeros(2), reach)
    images = [render(view, window, things, SIGHT) for things in (marked, marked + hiding)]
    whole, rest = ((image[..., 0] > 1.2 * image[..., 2]).sum() for image in images)
    return float(rest / max(whole, 1))


ROOM = 1.3  # half a picture [reaches]: what is nearer to the eye looks larger


class Spectator:
    """A camera that stays at a place from which little is in front of the arm.

    Parameters
    ----------
    situation : Situation
        With an arm that moves in its joints.
    """

    def __init__(self, situation: JointSituation) -> None:
        arm = situation.arm
        self.situation = situation
        self.view = replace(view_of(situation), centre=np.asarray(arm.base.origin))
        self.window = Window(np.zeros(2), ROOM * arm.reach)
        things = [*body_faces(situation, 0.0), *arm_faces(arm, arm.joints)]
        self.floor = floor_of(situation, things)

    def picture(self, way: Movement, pixels: int) -> np.ndarray:
        """Return a picture (pixels, pixels, 3) uint8 of the end of a movement, with its paths."""
        situation, end = self.situation, way.duration
        things = [*body_faces(situation, end), *arm_faces(situation.arm, way.joints[-1])]
        if end > 0.0:
            things += path_faces(situation, way)
        image = staged(self.view, self.window, self.floor, things, pixels)
        return np.rint(255.0 * image[::-1]).astype(np.uint8)
