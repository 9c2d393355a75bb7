"""What acts: learned policies, their training, and planners that try them out."""

from gcm_learn.policies.actor import Actor

__all__ = ["Actor"]
