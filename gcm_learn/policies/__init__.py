"""Learned policies, their training, and planners that try them out.

>>> from gcm_learn.policies import shipped_actor
>>> shipped_actor("clone").play(pool, np.arange(len(pool))).outcomes  # doctest: +SKIP
"""

from typing import TYPE_CHECKING

from gcm_learn.late import late_names
from gcm_learn.policies.actor import (
    FILE,
    Acting,
    Actor,
    ActorPlanner,
    acted,
    actor_folder,
    actor_names,
    all_actor_names,
    is_actor,
    shipped_actor,
    tried_out,
)
from gcm_learn.policies.exports import export_minari
from gcm_learn.policies.outside import OwnPolicy, own_policy
from gcm_learn.policies.plan import TrainingPlan, plan_of, read_plan
from gcm_learn.policies.training import score

if TYPE_CHECKING:
    from gcm_learn.policies.training import train

# Loaded when it is asked for: it needs torch.
__getattr__ = late_names(__name__, {"training": ("train",)})

__all__ = [
    "Acting",
    "Actor",
    "ActorPlanner",
    "FILE",
    "OwnPolicy",
    "TrainingPlan",
    "acted",
    "actor_folder",
    "actor_names",
    "export_minari",
    "is_actor",
    "all_actor_names",
    "own_policy",
    "plan_of",
    "read_plan",
    "score",
    "shipped_actor",
    "tried_out",
    "train",
]
