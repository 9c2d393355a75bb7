"""Acting: an agent sees a moment and gives commands, a plant carries them out.

>>> from gcm_learn.execution import Settings, plant_of, pool_for, run_episode
>>> pool = pool_for(Settings(), situations)                                  # doctest: +SKIP
>>> plant = plant_of(pool, len(pool), Settings())                            # doctest: +SKIP
>>> run_episode(agent, plant, np.arange(len(pool))).outcomes                 # doctest: +SKIP
"""

from gcm_learn.execution.arena.batch import (
    Batch as Batch,
    KinematicPlant as KinematicPlant,
    way_of as way_of,
)
from gcm_learn.execution.arena.kernels.hands.nearness import RAYS as RAYS
from gcm_learn.execution.arena.kernels.hands.observation import MEETING as MEETING
from gcm_learn.execution.arena.kernels.joints.fan import (
    COMMANDS as COMMANDS,
    commands_of as commands_of,
)
from gcm_learn.execution.arena.kernels.joints.observation import AIM as AIM
from gcm_learn.execution.arena.kernels.world import (
    CAUGHT as CAUGHT,
    COLLIDED as COLLIDED,
    LATE as LATE,
    RUNNING as RUNNING,
)
from gcm_learn.execution.arena.pool import Pool as Pool, placed as placed, without as without
from gcm_learn.execution.arena.settings import (
    OUTCOMES as OUTCOMES,
    TERMS as TERMS,
    ArenaSettings as ArenaSettings,
    ChainSettings as ChainSettings,
    Settings as Settings,
    SpatialSettings as SpatialSettings,
    Weights as Weights,
    encoder as encoder,
    settings_of as settings_of,
)
from gcm_learn.execution.arenas import (
    ARENAS as ARENAS,
    AnyBody as AnyBody,
    Arena as Arena,
    Reserve as Reserve,
    Source as Source,
    arena_named as arena_named,
    arena_of as arena_of,
    plant_of as plant_of,
    pool_for as pool_for,
    pool_of as pool_of,
    reserve_of as reserve_of,
    situations_of as situations_of,
)
from gcm_learn.execution.body.arms import (
    ChainPhysicalSettings as ChainPhysicalSettings,
    PhysicalArms as PhysicalArms,
    PhysicalSettings as PhysicalSettings,
)
from gcm_learn.execution.body.bodies import (
    body_for as body_for,
    body_of_robot as body_of_robot,
    read_body as read_body,
    shipped_bodies as shipped_bodies,
)
from gcm_learn.execution.body.executing import (
    Execution as Execution,
    as_touch as as_touch,
    execute as execute,
    execute_seen as execute_seen,
    execution_to_json as execution_to_json,
    several_in as several_in,
    tube_about as tube_about,
)
from gcm_learn.execution.body.gripper import Gripped as Gripped, GrippingPlant as GrippingPlant
from gcm_learn.execution.body.kinds import MECHANICS as MECHANICS
from gcm_learn.execution.body.motors import (
    Controller as Controller,
    motor_accelerations as motor_accelerations,
    with_motor_limits as with_motor_limits,
)
from gcm_learn.execution.body.plant import Contact as Contact, PhysicalPlant as PhysicalPlant
from gcm_learn.execution.loop.belief import Belief as Belief
from gcm_learn.execution.loop.closed_loop import (
    Course as Course,
    ExactPlant as ExactPlant,
    LedPlant as LedPlant,
    Loop as Loop,
    Mind as Mind,
    Occasion as Occasion,
    Thought as Thought,
    run_closed_loop as run_closed_loop,
)
from gcm_learn.execution.loop.episode import (
    Agent as Agent,
    Episodes as Episodes,
    Moment as Moment,
    Plant as Plant,
    Steps as Steps,
    into_frame as into_frame,
    run_episode as run_episode,
)
from gcm_learn.execution.loop.kinds import forearm_of as forearm_of
from gcm_learn.execution.loop.minds import (
    HABITS as HABITS,
    Commanding as Commanding,
    Planning as Planning,
    follower_of as follower_of,
)
from gcm_learn.execution.loop.perception import Percept as Percept, Perception as Perception
