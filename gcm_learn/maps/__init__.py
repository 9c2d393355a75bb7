"""Dynamic made static: cognitive maps and the paths that run down them."""

from gcm_learn.maps.build import build_map, layered_map, task_of
from gcm_learn.maps.cognitive_map import CognitiveMap, Contact
from gcm_learn.maps.descent import descend

__all__ = ["CognitiveMap", "Contact", "build_map", "descend", "layered_map", "task_of"]
