"""Arms and bodies in space as pictures, computed without a graphics card and without matplotlib."""

from __future__ import annotations

from gcm_learn.rendering.bodies import (
    approach_corners,
    body_faces,
    drawn_scale,
    solid_faces,
)
from gcm_learn.rendering.camera import Camera, Faces, Window, camera_from, normals, render, shaded
from gcm_learn.rendering.colours import (
    APPROACH,
    ARM,
    FLOOR,
    INK,
    OBSTACLE,
    PATH,
    SHADES,
    TARGET,
    TIME,
    body_colour,
    rgb,
    time_colours,
)
from gcm_learn.rendering.limbs import (
    HAND,
    Limb,
    arm_faces,
    balls_of,
    bone_pose,
    limb_along,
    limb_faces,
)
from gcm_learn.rendering.paths import LINE, SAMPLES, path_faces, target_paths, tube_faces
from gcm_learn.rendering.poses import JointSituation, body_poses, ground_of
from gcm_learn.rendering.solids import faces, has_edges, placed, tube
from gcm_learn.rendering.spectator import Spectator
from gcm_learn.rendering.staging import (
    PIXELS,
    box_of,
    centred,
    floor_of,
    from_above,
    staged,
    turned_view,
    window_of,
)
from gcm_learn.rendering.views import EYE, view_of

__all__ = [
    "APPROACH",
    "ARM",
    "Camera",
    "EYE",
    "FLOOR",
    "Faces",
    "HAND",
    "INK",
    "JointSituation",
    "LINE",
    "Limb",
    "OBSTACLE",
    "PATH",
    "PIXELS",
    "SAMPLES",
    "SHADES",
    "Spectator",
    "TARGET",
    "TIME",
    "Window",
    "approach_corners",
    "arm_faces",
    "balls_of",
    "body_colour",
    "body_faces",
    "body_poses",
    "bone_pose",
    "box_of",
    "camera_from",
    "centred",
    "drawn_scale",
    "faces",
    "floor_of",
    "from_above",
    "ground_of",
    "has_edges",
    "limb_along",
    "limb_faces",
    "normals",
    "path_faces",
    "placed",
    "render",
    "rgb",
    "shaded",
    "solid_faces",
    "staged",
    "target_paths",
    "time_colours",
    "tube",
    "tube_faces",
    "turned_view",
    "view_of",
    "window_of",
]
