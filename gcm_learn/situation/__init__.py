"""What happens in the world: shapes, motion laws, situations and their exchange format."""

from __future__ import annotations

from gcm_learn.situation.json_format import (
    FORMAT,
    read_situations,
    situation_from_json,
    situation_to_json,
    write_situations,
)
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
    "FORMAT",
    "PLANAR",
    "SOLID",
    "Arm",
    "Body",
    "Box",
    "Capsule",
    "Cylinder",
    "Disc",
    "Motion",
    "Pendulum",
    "PlanarQuadratic",
    "PlanarShape",
    "Plane",
    "Polygon",
    "Shape",
    "Situation",
    "SolidMotion",
    "SolidQuadratic",
    "SolidShape",
    "Sphere",
    "read_situations",
    "situation_from_json",
    "situation_to_json",
    "write_situations",
]
