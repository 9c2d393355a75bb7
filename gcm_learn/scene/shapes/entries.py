"""The table of shapes."""

from __future__ import annotations

from gcm_learn.scene.shapes import ball, box, capsule, cylinder, polygon
from gcm_learn.scene.shapes.entry import Entry
from gcm_learn.situation import Box, Capsule, Cylinder, Disc, Polygon, Shape, Sphere

ENTRIES: dict[type, Entry] = {
    Disc: ball.DISC_ENTRY,
    Polygon: polygon.ENTRY,
    Sphere: ball.SPHERE_ENTRY,
    Box: box.ENTRY,
    Capsule: capsule.ENTRY,
    Cylinder: cylinder.ENTRY,
}


def entry_of(shape: Shape) -> Entry:
    """Return the entry of a shape."""
    return ENTRIES[type(shape)]
