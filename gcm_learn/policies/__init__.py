"""What acts: followers of plans, and learned policies with their training."""

from gcm_learn.policies.actor import Actor
from gcm_learn.policies.rollout import Episodes, play

__all__ = ["Actor", "Episodes", "play"]
