"""Sources of situations: the paper's scenes and random families.

>>> from gcm_learn import families
>>> families.draw("gate", seed=0, index=42).name
'gate-0000042'
"""

from gcm_learn.families.family import ArmRanges as ArmRanges, Family as Family
from gcm_learn.families.layout import WayRanges as WayRanges
from gcm_learn.families.paper import (
    CAPTION_INSTANTS as CAPTION_INSTANTS,
    KAPPA as KAPPA,
    PAPER_SCENES as PAPER_SCENES,
    fig3 as fig3,
    gate_scene as gate_scene,
    thrown_scene as thrown_scene,
)
from gcm_learn.families.piece_family import Sizes as Sizes
from gcm_learn.families.pieces import SpaceRanges as SpaceRanges
from gcm_learn.families.presets import PRESETS as PRESETS
from gcm_learn.families.random_planar import random_planar as random_planar
from gcm_learn.families.random_solid import random_solid as random_solid
from gcm_learn.families.registry import (
    draw as draw,
    family_from_dict as family_from_dict,
    family_names as family_names,
    family_to_dict as family_to_dict,
    get_family as get_family,
    item_name as item_name,
    preset_families as preset_families,
    read_family as read_family,
    with_arm as with_arm,
)
from gcm_learn.families.space.arms import (
    SPATIAL_SCENES as SPATIAL_SCENES,
    paper_scene as paper_scene,
)
from gcm_learn.families.space.family import SpatialFamily as SpatialFamily
