"""An arm in space while it acts, step by step: pictures in which its whole reach is."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from gcm_learn.motion import SpatialTrajectory
from gcm_learn.rendering.bodies import arm_faces, body_faces, path_faces, view_of
from gcm_learn.rendering.camera import Window
from gcm_learn.rendering.staging import SpatialSituation, floor_of, staged

ROOM = 1.3  # half a picture [reaches]: what is nearer to the eye looks larger


class Spectator:
    """Looks at a situation from where little is in front of the arm, and stays there.

    Parameters
    ----------
    situation : Situation
        With a spatial arm.
    """

    def __init__(self, situation: SpatialSituation) -> None:
        arm = situation.arm
        self.situation = situation
        self.view = replace(view_of(situation), centre=np.asarray(arm.base.origin))
        self.window = Window(np.zeros(2), ROOM * arm.reach)
        things = [*body_faces(situation, 0.0), *arm_faces(arm, arm.joints)]
        self.floor = floor_of(situation, things)

    def picture(self, way: SpatialTrajectory, pixels: int) -> np.ndarray:
        """A picture (pixels, pixels, 3) uint8 of the end of a way, with what led there."""
        situation, end = self.situation, way.duration
        things = [*body_faces(situation, end), *arm_faces(situation.arm, way.joints[-1])]
        if end > 0.0:
            things += path_faces(situation, way)
        image = staged(self.view, self.window, self.floor, things, pixels)
        return np.rint(255.0 * image[::-1]).astype(np.uint8)
