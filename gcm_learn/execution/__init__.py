"""Acting: an agent sees a moment and gives commands, a plant carries them out.

>>> from gcm_learn.execution import KinematicPlant, Pool, Settings, run_episode
>>> plant = KinematicPlant(Pool.of(situations), len(situations), Settings())  # doctest: +SKIP
>>> run_episode(agent, plant, np.arange(len(situations))).outcomes           # doctest: +SKIP
"""

from gcm_learn.execution.belief import Belief
from gcm_learn.execution.embedding import encoder
from gcm_learn.execution.episode import (
    Agent,
    Episodes,
    Moment,
    Plant,
    Steps,
    into_frame,
    run_episode,
)
from gcm_learn.execution.fan import RAYS
from gcm_learn.execution.follower import Follower
from gcm_learn.execution.observation import MEETING
from gcm_learn.execution.perception import Percept, Perception
from gcm_learn.execution.plant import KinematicPlant
from gcm_learn.execution.pool import Pool
from gcm_learn.execution.settings import OUTCOMES, TERMS, Settings, Weights, settings_of
from gcm_learn.execution.sources import Source, pool_of, situations_of
from gcm_learn.execution.world import CAUGHT, COLLIDED, LATE, RUNNING

__all__ = [
    "Agent",
    "Belief",
    "CAUGHT",
    "COLLIDED",
    "Episodes",
    "Follower",
    "KinematicPlant",
    "LATE",
    "MEETING",
    "Moment",
    "OUTCOMES",
    "Percept",
    "Perception",
    "Plant",
    "Pool",
    "RAYS",
    "RUNNING",
    "Settings",
    "Source",
    "Steps",
    "TERMS",
    "Weights",
    "encoder",
    "into_frame",
    "pool_of",
    "run_episode",
    "settings_of",
    "situations_of",
]
