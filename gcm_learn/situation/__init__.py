"""Shapes, motion laws, situations and their exchange format."""

from __future__ import annotations

from gcm_learn.situation.arm_body import (
    BODY_FORMAT,
    ArmBody,
    BoneMass,
    Motor,
    arm_body_from_json,
    read_arm_body,
)
from gcm_learn.situation.canonical import Frame, canonical, frame_of
from gcm_learn.situation.frames import arm_frame, carried, plane_frame
from gcm_learn.situation.json_format import (
    FORMAT,
    SPATIAL_FORMAT,
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
from gcm_learn.situation.situation import AnySituation, Body, Plane, Situation, planar, spatial
from gcm_learn.situation.spatial_frame import SpatialFrame, spatial_frame_of

__all__ = [
    "AnySituation",
    "ArmBody",
    "BODY_FORMAT",
    "Body",
    "BoneMass",
    "Box",
    "Capsule",
    "Cylinder",
    "Disc",
    "FORMAT",
    "Frame",
    "JsonTextError",
    "Motion",
    "Motor",
    "PLANAR",
    "Pendulum",
    "PlanarQuadratic",
    "PlanarShape",
    "Plane",
    "Polygon",
    "RepeatedField",
    "SOLID",
    "SPATIAL_FORMAT",
    "Shape",
    "Situation",
    "SolidMotion",
    "SolidQuadratic",
    "SolidShape",
    "SpatialFrame",
    "Sphere",
    "arm_body_from_json",
    "arm_frame",
    "canonical",
    "carried",
    "frame_of",
    "line_of",
    "parse",
    "planar",
    "plane_frame",
    "read_arm_body",
    "read_situations",
    "situation_from_json",
    "situation_to_json",
    "spatial",
    "spatial_frame_of",
    "write_situations",
]
