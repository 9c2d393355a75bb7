"""Sources of situations: the paper's scenes and random families.

>>> from gcm_learn import families
>>> families.draw("gate", seed=0, index=42).name
'gate-0000042'
"""

from gcm_learn.errors import UnknownNameError
from gcm_learn.families.family import ArmRanges, Family
from gcm_learn.families.layout import WayRanges
from gcm_learn.families.paper import (
    CAPTION_INSTANTS,
    KAPPA,
    PAPER_SCENES,
    fig3,
    gate_scene,
    thrown_scene,
)
from gcm_learn.families.piece_family import Sizes
from gcm_learn.families.pieces import SpaceRanges
from gcm_learn.families.random_planar import random_planar
from gcm_learn.families.random_solid import random_solid
from gcm_learn.families.registry import (
    PRESETS,
    draw,
    family_from_dict,
    family_names,
    family_to_dict,
    get_family,
    item_name,
    preset_families,
    read_family,
    with_arm,
)
from gcm_learn.families.space.arms import SPATIAL_SCENES
from gcm_learn.families.space.family import SpatialFamily
from gcm_learn.situation import AnySituation

__all__ = [
    "ArmRanges",
    "CAPTION_INSTANTS",
    "Family",
    "KAPPA",
    "PAPER_SCENES",
    "PRESETS",
    "SPATIAL_SCENES",
    "Sizes",
    "SpaceRanges",
    "SpatialFamily",
    "WayRanges",
    "draw",
    "family_from_dict",
    "family_names",
    "family_to_dict",
    "fig3",
    "gate_scene",
    "get_family",
    "item_name",
    "paper_scene",
    "preset_families",
    "random_planar",
    "random_solid",
    "read_family",
    "with_arm",
    "thrown_scene",
]


def paper_scene(name: str) -> AnySituation:
    """The scene of one of the paper's figures, e.g. ``paper_scene("fig4")`` or ``"fig8-space"``."""
    scene = SPATIAL_SCENES.get(name) or PAPER_SCENES.get(name)
    if scene is None:
        raise UnknownNameError.among("scene", name, [*PAPER_SCENES, *SPATIAL_SCENES])
    return scene()
