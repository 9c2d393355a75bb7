"""Problems that others made, converted to situations of chains."""

from gcm_learn.outside.converted import Converted, Converter
from gcm_learn.outside.motionbenchmaker import MotionBenchMaker
from gcm_learn.outside.moveit import bodies_of, goal_of, posture_of, start_of
from gcm_learn.outside.nodes import Node, json_nodes, yaml_node
from gcm_learn.outside.si_rrt import SiRrt
from gcm_learn.outside.table_tennis import TableTennis

CONVERTERS: dict[str, type[Converter]] = {
    "motionbenchmaker": MotionBenchMaker,
    "si-rrt": SiRrt,
    "table-tennis": TableTennis,
}

__all__ = [
    "CONVERTERS",
    "Converted",
    "Converter",
    "MotionBenchMaker",
    "Node",
    "SiRrt",
    "TableTennis",
    "bodies_of",
    "goal_of",
    "json_nodes",
    "posture_of",
    "start_of",
    "yaml_node",
]
