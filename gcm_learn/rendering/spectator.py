"""An arm while it acts, step by step, in pictures that show its whole reach."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from gcm_learn.motion import Movement
from gcm_learn.rendering.bodies import body_faces
from gcm_learn.rendering.camera import Window
from gcm_learn.rendering.limbs import arm_faces
from gcm_learn.rendering.paths import path_faces
from gcm_learn.rendering.poses import JointSituation
from gcm_learn.rendering.staging import floor_of, staged
from gcm_learn.rendering.views import view_of

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
