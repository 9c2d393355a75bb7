"""What happens in the world: shapes, motion laws, situations and their exchange format."""

from __future__ import annotations

from gcm_learn.situation.canonical import Frame, canonical, frame_of, quaternion_of
from gcm_learn.situation.checks import number, positive, show
from gcm_learn.situation.frames import plane_frame, rotation_of
from gcm_learn.situation.json_format import (
    FORMAT,
    read_situations,
    situation_from_json,
    situation_to_json,
    write_situations,
)
from gcm_learn.situation.json_text import JsonTextError, RepeatedField, line_of, parse
from gcm_learn.situation.motion import (
    Motion,
    Pendulum,
    PlanarQuadratic,
    SolidMotion,
    SolidQuadratic,
)
from gcm_learn.situation.shapes import (
    PLANAR,
    SOLID,
    Box,
    Capsule,
    Cylinder,
    Disc,
    PlanarShape,
    Polygon,
    Shape,
    SolidShape,
    Sphere,
)
from gcm_learn.situation.situation import Arm, Body, Plane, Situation

__all__ = [
    "Arm",
    "Body",
    "Box",
    "Capsule",
    "Cylinder",
    "Disc",
    "FORMAT",
    "Frame",
    "JsonTextError",
    "Motion",
    "PLANAR",
    "Pendulum",
    "PlanarQuadratic",
    "PlanarShape",
    "Plane",
    "Polygon",
    "RepeatedField",
    "SOLID",
    "Shape",
    "Situation",
    "SolidMotion",
    "SolidQuadratic",
    "SolidShape",
    "Sphere",
    "canonical",
    "frame_of",
    "line_of",
    "number",
    "parse",
    "plane_frame",
    "positive",
    "quaternion_of",
    "read_situations",
    "rotation_of",
    "show",
    "situation_from_json",
    "situation_to_json",
    "write_situations",
]
