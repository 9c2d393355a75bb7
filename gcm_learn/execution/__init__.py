"""Acting: an agent sees a moment and gives commands, a plant carries them out.

>>> from gcm_learn.execution import Settings, plant_of, pool_for, run_episode
>>> pool = pool_for(Settings(), situations)                                  # doctest: +SKIP
>>> plant = plant_of(pool, len(pool), Settings())                            # doctest: +SKIP
>>> run_episode(agent, plant, np.arange(len(pool))).outcomes                 # doctest: +SKIP
"""

from gcm_learn.execution.arena.batch import Batch, KinematicPlant, way_of
from gcm_learn.execution.arena.kernels.hands.nearness import RAYS
from gcm_learn.execution.arena.kernels.hands.observation import MEETING
from gcm_learn.execution.arena.kernels.joints.fan import COMMANDS, commands_of
from gcm_learn.execution.arena.kernels.joints.observation import AIM
from gcm_learn.execution.arena.kernels.world import CAUGHT, COLLIDED, LATE, RUNNING
from gcm_learn.execution.arena.pool import Pool, placed, without
from gcm_learn.execution.arena.settings import (
    OUTCOMES,
    TERMS,
    ArenaSettings,
    ChainSettings,
    Settings,
    SpatialSettings,
    Weights,
    encoder,
    settings_of,
)
from gcm_learn.execution.arenas import (
    ARENAS,
    AnyBody,
    Arena,
    Source,
    arena_named,
    arena_of,
    plant_of,
    pool_for,
    pool_of,
    situations_of,
)
from gcm_learn.execution.body.arms import ChainPhysicalSettings, PhysicalArms, PhysicalSettings
from gcm_learn.execution.body.bodies import (
    body_for,
    body_of_robot,
    read_body,
    shipped_bodies,
)
from gcm_learn.execution.body.executing import (
    Execution,
    execute,
    execute_seen,
    execution_to_json,
    measured_tube,
    several_in,
)
from gcm_learn.execution.body.kinds import MECHANICS
from gcm_learn.execution.body.motors import Controller, motor_accelerations, with_motor_limits
from gcm_learn.execution.body.plant import Contact, PhysicalPlant
from gcm_learn.execution.loop.belief import Belief
from gcm_learn.execution.loop.closed_loop import (
    Course,
    ExactPlant,
    LedPlant,
    Loop,
    Mind,
    Occasion,
    Thought,
    run_closed_loop,
)
from gcm_learn.execution.loop.episode import (
    Agent,
    Episodes,
    Moment,
    Plant,
    Steps,
    into_frame,
    run_episode,
)
from gcm_learn.execution.loop.kinds import forearm_of
from gcm_learn.execution.loop.minds import HABITS, Commanding, Planning, follower_of
from gcm_learn.execution.loop.perception import Percept, Perception

__all__ = [
    "AIM",
    "ARENAS",
    "Agent",
    "AnyBody",
    "Arena",
    "ArenaSettings",
    "Batch",
    "Belief",
    "CAUGHT",
    "COMMANDS",
    "COLLIDED",
    "ChainPhysicalSettings",
    "ChainSettings",
    "Commanding",
    "Contact",
    "Controller",
    "Course",
    "Episodes",
    "ExactPlant",
    "Execution",
    "HABITS",
    "KinematicPlant",
    "LATE",
    "LedPlant",
    "Loop",
    "MECHANICS",
    "MEETING",
    "Mind",
    "Moment",
    "OUTCOMES",
    "Occasion",
    "Percept",
    "Perception",
    "PhysicalArms",
    "PhysicalPlant",
    "PhysicalSettings",
    "Planning",
    "Plant",
    "Pool",
    "RAYS",
    "RUNNING",
    "Settings",
    "Source",
    "SpatialSettings",
    "Steps",
    "TERMS",
    "Thought",
    "Weights",
    "arena_named",
    "arena_of",
    "body_for",
    "body_of_robot",
    "commands_of",
    "encoder",
    "execute",
    "execute_seen",
    "execution_to_json",
    "several_in",
    "follower_of",
    "forearm_of",
    "into_frame",
    "measured_tube",
    "motor_accelerations",
    "placed",
    "plant_of",
    "pool_for",
    "pool_of",
    "read_body",
    "run_closed_loop",
    "run_episode",
    "settings_of",
    "shipped_bodies",
    "situations_of",
    "way_of",
    "with_motor_limits",
    "without",
]
