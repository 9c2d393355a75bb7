"""Dynamic made static: cognitive maps and the paths that run down them."""

from gcm_learn.maps.build import (
    build_map as build_map,
    explore as explore,
    map_of as map_of,
    static_twin as static_twin,
)
from gcm_learn.maps.cognitive_map import (
    IN_SPACE as IN_SPACE,
    MAPS as MAPS,
    CognitiveMap as CognitiveMap,
    Interception as Interception,
)
from gcm_learn.maps.descent import chain_to as chain_to, descend as descend
