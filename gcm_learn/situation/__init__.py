"""Shapes, motion laws, situations and their exchange formats."""

from __future__ import annotations

from gcm_learn.situation.arm_body import (
    AnyArmBody as AnyArmBody,
    ArmBody as ArmBody,
    BoneMass as BoneMass,
    ChainBody as ChainBody,
    FrameMass as FrameMass,
    Motor as Motor,
    arm_body_from_json as arm_body_from_json,
    arm_body_to_json as arm_body_to_json,
    read_arm_body as read_arm_body,
)
from gcm_learn.situation.arm_files import (
    ARM_FORMATS as ARM_FORMATS,
    arm_from_json as arm_from_json,
    arm_names as arm_names,
    arm_to_json as arm_to_json,
    read_arm as read_arm,
    shipped_arm as shipped_arm,
)
from gcm_learn.situation.body import (
    Approach as Approach,
    Body as Body,
    Hold as Hold,
    Margin as Margin,
    Place as Place,
)
from gcm_learn.situation.canonical import (
    Frame as Frame,
    canonical as canonical,
    frame_of as frame_of,
)
from gcm_learn.situation.json_format import (
    read_situations as read_situations,
    situation_from_json as situation_from_json,
    situation_to_json as situation_to_json,
    write_situations as write_situations,
)
from gcm_learn.situation.json_records import (
    JsonTextError as JsonTextError,
    RepeatedField as RepeatedField,
    line_of as line_of,
    parse as parse,
)
from gcm_learn.situation.laws import (
    CATCHES as CATCHES,
    ENDS as ENDS,
    FORMATS as FORMATS,
    Format as Format,
    Motion as Motion,
    SolidMotion as SolidMotion,
    carried as carried,
)
from gcm_learn.situation.motion import (
    Pendulum as Pendulum,
    PlanarQuadratic as PlanarQuadratic,
    SolidQuadratic as SolidQuadratic,
)
from gcm_learn.situation.schema import schemas as schemas
from gcm_learn.situation.shapes import (
    PLANAR as PLANAR,
    SOLID as SOLID,
    SPACE as SPACE,
    Box as Box,
    Capsule as Capsule,
    Cylinder as Cylinder,
    Disc as Disc,
    PlanarShape as PlanarShape,
    Polygon as Polygon,
    Shape as Shape,
    SolidShape as SolidShape,
    SpaceShape as SpaceShape,
    Sphere as Sphere,
    numbers_of as numbers_of,
)
from gcm_learn.situation.situation import (
    AnySituation as AnySituation,
    Plane as Plane,
    Situation as Situation,
    planar as planar,
    with_end as with_end,
)
from gcm_learn.situation.spatial_frame import (
    SpatialFrame as SpatialFrame,
    arm_frame as arm_frame,
    plane_frame as plane_frame,
    spatial_frame_of as spatial_frame_of,
)
from gcm_learn.situation.surface_files import (
    read_mesh as read_mesh,
)
from gcm_learn.situation.surfaces import (
    SURFACES as SURFACES,
    Cloud as Cloud,
    Mesh as Mesh,
    Surface as Surface,
    SurfaceShape as SurfaceShape,
)
from gcm_learn.situation.timed_motion import (
    Piece as Piece,
    Piecewise as Piecewise,
    Sampled as Sampled,
)
