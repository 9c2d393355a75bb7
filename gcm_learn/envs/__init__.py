"""The arena: the arm as a Gymnasium environment, single and in batches.

>>> import gymnasium
>>> env = gymnasium.make("gcm_learn:CatchArm-v0", situations="random-planar")
>>> observation, info = env.reset(seed=0)
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from gcm_learn.envs.catch_arm import (
        CatchArm as CatchArm,
        CatchArm3D as CatchArm3D,
        CatchArmPhysics as CatchArmPhysics,
    )
    from gcm_learn.envs.catch_chain import (
        CatchChain as CatchChain,
        CatchChainPhysics as CatchChainPhysics,
    )
    from gcm_learn.envs.one_arm import box as box, commands as commands, finite as finite
    from gcm_learn.envs.vector import (
        CatchArms as CatchArms,
        CatchArms3D as CatchArms3D,
        CatchArmsPhysics as CatchArmsPhysics,
        CatchChains as CatchChains,
        CatchChainsPhysics as CatchChainsPhysics,
    )
    from gcm_learn.envs.views import WithMap as WithMap, map_image as map_image
    from gcm_learn.execution import (
        ChainPhysicalSettings as ChainPhysicalSettings,
        ChainSettings as ChainSettings,
        PhysicalSettings as PhysicalSettings,
        Pool as Pool,
        Settings as Settings,
        SpatialSettings as SpatialSettings,
        Weights as Weights,
    )


_HOMES = {
    "CatchArm": "envs.catch_arm",
    "CatchArm3D": "envs.catch_arm",
    "CatchArmPhysics": "envs.catch_arm",
    "CatchArms": "envs.vector",
    "CatchArms3D": "envs.vector",
    "CatchArmsPhysics": "envs.vector",
    "CatchChain": "envs.catch_chain",
    "CatchChainPhysics": "envs.catch_chain",
    "CatchChains": "envs.vector",
    "CatchChainsPhysics": "envs.vector",
    "ChainPhysicalSettings": "execution",
    "ChainSettings": "execution",
    "PhysicalSettings": "execution",
    "Pool": "execution",
    "Settings": "execution",
    "SpatialSettings": "execution",
    "Weights": "execution",
    "WithMap": "envs.views",
    "box": "envs.one_arm",
    "commands": "envs.one_arm",
    "finite": "envs.one_arm",
    "map_image": "envs.views",
}


def __getattr__(name: str) -> object:
    """Import a name of this folder at its first use, since its modules need gymnasium."""
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


def __dir__() -> list[str]:
    return sorted({*globals(), *(n for n in _HOMES if _HOMES[n] != "execution")})
