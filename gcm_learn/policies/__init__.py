"""Learned policies, their training, and planners that try them out.

>>> from gcm_learn.policies import shipped_actor
>>> shipped_actor("clone").play(pool, np.arange(len(pool))).outcomes  # doctest: +SKIP
"""

from typing import TYPE_CHECKING

from gcm_learn import late
from gcm_learn.policies.actor import (
    FILE as FILE,
    Acting as Acting,
    Actor as Actor,
    ActorPlanner as ActorPlanner,
    acted as acted,
    actor_folder as actor_folder,
    actor_names as actor_names,
    all_actor_names as all_actor_names,
    found_actor as found_actor,
    shipped_actor as shipped_actor,
    tried_out as tried_out,
)
from gcm_learn.policies.exports import export_minari as export_minari
from gcm_learn.policies.outside import OwnPolicy as OwnPolicy, own_policy as own_policy
from gcm_learn.policies.plan import (
    TrainingPlan as TrainingPlan,
    plan_of as plan_of,
    read_plan as read_plan,
)
from gcm_learn.policies.training import score as score

if TYPE_CHECKING:
    from gcm_learn.policies.training import train as train
    from gcm_learn.policies.vec_env import ArenaVecEnv as ArenaVecEnv

# Loaded when they are asked for: they need torch.
__getattr__ = late.late_names(__name__, {"training": ("train",), "vec_env": ("ArenaVecEnv",)})
