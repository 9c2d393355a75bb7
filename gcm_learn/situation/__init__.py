"""Shapes, motion laws, situations and their exchange formats."""

from __future__ import annotations

from gcm_learn.situation.arm_body import (
    AnyArmBody,
    ArmBody,
    BoneMass,
    ChainBody,
    FrameMass,
    Motor,
    arm_body_from_json,
    arm_body_to_json,
    read_arm_body,
)
from gcm_learn.situation.arm_files import (
    ARM_FORMATS,
    arm_from_json,
    arm_names,
    arm_to_json,
    read_arm,
    shipped_arm,
)
from gcm_learn.situation.body import Approach, Body
from gcm_learn.situation.canonical import Frame, canonical, frame_of
from gcm_learn.situation.json_format import (
    read_situations,
    situation_from_json,
    situation_to_json,
    write_situations,
)
from gcm_learn.situation.json_records import JsonTextError, RepeatedField, line_of, parse
from gcm_learn.situation.laws import CATCHES, FORMATS, Format, Motion, SolidMotion, carried
from gcm_learn.situation.motion import Pendulum, PlanarQuadratic, SolidQuadratic
from gcm_learn.situation.schema import schemas
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
    numbers_of,
)
from gcm_learn.situation.situation import AnySituation, Plane, Situation, planar, spatial
from gcm_learn.situation.spatial_frame import SpatialFrame, arm_frame, plane_frame, spatial_frame_of
from gcm_learn.situation.timed_motion import Piece, Piecewise, Sampled

__all__ = [
    "ARM_FORMATS",
    "AnyArmBody",
    "AnySituation",
    "Approach",
    "ArmBody",
    "Body",
    "BoneMass",
    "Box",
    "CATCHES",
    "Capsule",
    "ChainBody",
    "Cylinder",
    "Disc",
    "FORMATS",
    "Format",
    "Frame",
    "FrameMass",
    "JsonTextError",
    "Motion",
    "Motor",
    "PLANAR",
    "Pendulum",
    "Piece",
    "Piecewise",
    "PlanarQuadratic",
    "PlanarShape",
    "Plane",
    "Polygon",
    "RepeatedField",
    "SOLID",
    "Sampled",
    "Shape",
    "Situation",
    "SolidMotion",
    "SolidQuadratic",
    "SolidShape",
    "SpatialFrame",
    "Sphere",
    "arm_body_from_json",
    "arm_body_to_json",
    "arm_frame",
    "arm_from_json",
    "arm_names",
    "arm_to_json",
    "canonical",
    "carried",
    "frame_of",
    "line_of",
    "numbers_of",
    "parse",
    "planar",
    "plane_frame",
    "read_arm",
    "read_arm_body",
    "read_situations",
    "schemas",
    "shipped_arm",
    "situation_from_json",
    "situation_to_json",
    "spatial",
    "spatial_frame_of",
    "write_situations",
]
