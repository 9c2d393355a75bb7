"""Problems that others made, converted to situations of chains."""

from gcm_learn.outside.converted import Converted as Converted, Converter as Converter
from gcm_learn.outside.motionbenchmaker import MotionBenchMaker as MotionBenchMaker
from gcm_learn.outside.moveit import (
    bodies_of as bodies_of,
    goal_of as goal_of,
    posture_of as posture_of,
    start_of as start_of,
)
from gcm_learn.outside.nodes import Node as Node, json_nodes as json_nodes, yaml_node as yaml_node
from gcm_learn.outside.pcd import read_pcd as read_pcd
from gcm_learn.outside.predictors import (
    PREDICTORS as PREDICTORS,
    laws_of as laws_of,
    places_of as places_of,
)
from gcm_learn.outside.scene_text import scene_node as scene_node
from gcm_learn.outside.si_rrt import SiRrt as SiRrt
from gcm_learn.outside.table_tennis import TableTennis as TableTennis
from gcm_learn.outside.tracks import (
    Window as Window,
    read_tracks as read_tracks,
    windows as windows,
)
from gcm_learn.outside.worlds import World as World

CONVERTERS: dict[str, type[Converter]] = {
    "motionbenchmaker": MotionBenchMaker,
    "si-rrt": SiRrt,
    "table-tennis": TableTennis,
}
