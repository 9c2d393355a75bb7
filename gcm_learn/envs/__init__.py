"""The arena: the arm as a Gymnasium environment, single and in batches.

>>> import gymnasium
>>> env = gymnasium.make("gcm_learn:CatchArm-v0", situations="random-planar")
>>> observation, info = env.reset(seed=0)
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from gcm_learn.envs.catch_arm import CatchArm, box
    from gcm_learn.envs.vector import CatchArms
    from gcm_learn.envs.views import WithMap, map_image
    from gcm_learn.execution import Pool, Settings, Weights

__all__ = [
    "CatchArm",
    "CatchArms",
    "Pool",
    "Settings",
    "Weights",
    "WithMap",
    "box",
    "map_image",
]

_HOMES = {
    "CatchArm": "envs.catch_arm",
    "CatchArms": "envs.vector",
    "Pool": "execution",
    "Settings": "execution",
    "Weights": "execution",
    "WithMap": "envs.views",
    "box": "envs.catch_arm",
    "map_image": "envs.views",
}


def __getattr__(name: str) -> Any:
    """Names of this folder, loaded when they are asked for: they need gymnasium."""
    import importlib

    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from gcm_learn.errors import MissingExtraError

    try:
        module = importlib.import_module(f"gcm_learn.{_HOMES[name]}")
    except ModuleNotFoundError as error:
        if error.name != "gymnasium":
            raise
        raise MissingExtraError(f"gcm_learn.envs.{name}", "gymnasium", "rl") from None
    return getattr(module, name)
