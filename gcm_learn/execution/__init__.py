"""Acting: an agent sees a moment and gives commands, a plant carries them out.

>>> from gcm_learn.execution import KinematicPlant, Pool, Settings, run_episode
>>> plant = KinematicPlant(Pool.of(situations), len(situations), Settings())  # doctest: +SKIP
>>> run_episode(agent, plant, np.arange(len(situations))).outcomes           # doctest: +SKIP
"""

from gcm_learn.execution.batch import Batch
from gcm_learn.execution.belief import Belief
from gcm_learn.execution.closed_loop import Course, Loop, Mind, Occasion, Thought, run_closed_loop
from gcm_learn.execution.embedding import encoder
from gcm_learn.execution.episode import (
    Agent,
    Episodes,
    Moment,
    Plant,
    Steps,
    into_frame,
    run_episode,
    way_of,
)
from gcm_learn.execution.exact import ExactPlant
from gcm_learn.execution.fan import RAYS
from gcm_learn.execution.follower import Follower, FollowerInSpace
from gcm_learn.execution.following import LedPlant
from gcm_learn.execution.minds import Commanding, Planning
from gcm_learn.execution.observation import MEETING
from gcm_learn.execution.perception import Percept, Perception
from gcm_learn.execution.physics.arms import PhysicalArms
from gcm_learn.execution.physics.bodies import body_for, read_body, shipped_bodies
from gcm_learn.execution.physics.control import Controller
from gcm_learn.execution.physics.executing import (
    Execution,
    execute,
    execute_seen,
    execution_to_json,
)
from gcm_learn.execution.physics.motors import motor_accelerations, with_motor_limits
from gcm_learn.execution.physics.plant import Contact, PhysicalPlant
from gcm_learn.execution.physics.pool import PhysicalPool
from gcm_learn.execution.physics.tube import measured_tube
from gcm_learn.execution.plant import KinematicPlant
from gcm_learn.execution.plants import AnyPool, AnySettings, plant_of, pool_for, situations_for
from gcm_learn.execution.pool import Pool, SpatialPool
from gcm_learn.execution.settings import (
    OUTCOMES,
    TERMS,
    PhysicalSettings,
    Settings,
    SpatialSettings,
    Weights,
    made_of,
    settings_of,
)
from gcm_learn.execution.sources import (
    Source,
    physical_pool_of,
    pool_of,
    situations_of,
    spatial_pool_of,
    spatial_situations_of,
)
from gcm_learn.execution.space.fan import COMMANDS, commands_of
from gcm_learn.execution.space.observation import AIM
from gcm_learn.execution.space.plant import SpatialPlant
from gcm_learn.execution.world import CAUGHT, COLLIDED, LATE, RUNNING

__all__ = [
    "AIM",
    "Agent",
    "AnyPool",
    "AnySettings",
    "Batch",
    "Belief",
    "CAUGHT",
    "COMMANDS",
    "COLLIDED",
    "Commanding",
    "Contact",
    "Controller",
    "Course",
    "Episodes",
    "ExactPlant",
    "Execution",
    "Follower",
    "FollowerInSpace",
    "KinematicPlant",
    "LATE",
    "LedPlant",
    "Loop",
    "MEETING",
    "Mind",
    "Moment",
    "OUTCOMES",
    "Occasion",
    "Percept",
    "Perception",
    "PhysicalArms",
    "PhysicalPlant",
    "PhysicalPool",
    "PhysicalSettings",
    "Planning",
    "Plant",
    "Pool",
    "RAYS",
    "RUNNING",
    "Settings",
    "Source",
    "SpatialPlant",
    "SpatialPool",
    "SpatialSettings",
    "Steps",
    "TERMS",
    "Thought",
    "Weights",
    "body_for",
    "commands_of",
    "encoder",
    "execute",
    "execute_seen",
    "execution_to_json",
    "into_frame",
    "made_of",
    "measured_tube",
    "motor_accelerations",
    "physical_pool_of",
    "plant_of",
    "pool_for",
    "pool_of",
    "read_body",
    "run_closed_loop",
    "run_episode",
    "settings_of",
    "shipped_bodies",
    "situations_for",
    "situations_of",
    "spatial_pool_of",
    "spatial_situations_of",
    "way_of",
    "with_motor_limits",
]
