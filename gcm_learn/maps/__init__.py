"""Dynamic made static: cognitive maps and the paths that run down them."""

from gcm_learn.maps.build import build_map, explore, map_of, static_twin
from gcm_learn.maps.cognitive_map import CognitiveMap, Interception
from gcm_learn.maps.descent import chain_to, descend

__all__ = [
    "CognitiveMap",
    "Interception",
    "build_map",
    "chain_to",
    "descend",
    "explore",
    "map_of",
    "static_twin",
]
