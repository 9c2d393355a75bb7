"""Registration of the environments, now or as soon as Gymnasium is imported.

Importing `gcm_learn` must not load Gymnasium, and ``gymnasium.make("gcm_learn:CatchArm-v0")`` must
work whichever of the two was imported first. So a finder waits until Gymnasium is imported, and is
removed then.
"""

from __future__ import annotations

import importlib.util
import sys
from collections.abc import Sequence
from importlib.abc import Loader, MetaPathFinder
from importlib.machinery import ModuleSpec
from types import ModuleType

ENTRIES = {
    "CatchArm-v0": ("gcm_learn.envs.catch_arm:CatchArm", "gcm_learn.envs.vector:CatchArms"),
    "CatchArm3D-v0": (
        "gcm_learn.envs.catch_arm:CatchArm3D", "gcm_learn.envs.vector:CatchArms3D",
    ),
    "CatchChain-v0": (
        "gcm_learn.envs.catch_chain:CatchChain", "gcm_learn.envs.vector:CatchChains",
    ),
    "CatchArmPhysics-v0": (
        "gcm_learn.envs.catch_arm:CatchArmPhysics",
        "gcm_learn.envs.vector:CatchArmsPhysics",
    ),
    "CatchChainPhysics-v0": (
        "gcm_learn.envs.catch_chain:CatchChainPhysics",
        "gcm_learn.envs.vector:CatchChainsPhysics",
    ),
}  # fmt: skip
LIBRARY = "gymnasium"
NAMESPACE = "gcm_learn"
"""Of the second name of each environment, e.g. ``gcm_learn/CatchArm-v0``."""


def announce() -> None:
    """Register the environments, now or when Gymnasium is imported."""
    if LIBRARY in sys.modules:
        register()
    elif not any(isinstance(finder, _Waiter) for finder in sys.meta_path):
        sys.meta_path.insert(0, _Waiter())


def register() -> None:
    """Register the environments, if they are not yet."""
    import gymnasium

    for bare, (one, many) in ENTRIES.items():
        for name in (bare, f"{NAMESPACE}/{bare}"):
            if name not in gymnasium.registry:
                gymnasium.register(name, entry_point=one, vector_entry_point=many)


class _Waiter(MetaPathFinder):
    """Finder that gives Gymnasium a loader that registers the environments after the import."""

    asking = False

    def find_spec(
        self, name: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        """Return the library's own specification, with a loader that registers afterwards."""
        if name != LIBRARY or self.asking:
            return None
        self.asking = True
        try:
            spec = importlib.util.find_spec(name)
        finally:
            self.asking = False
        if spec is not None and spec.loader is not None:
            spec.loader = _ThenRegister(spec.loader)
        return spec


class _ThenRegister(Loader):
    """Loader that loads as another loader does, then registers the environments."""

    def __init__(self, loader: Loader) -> None:
        self.loader = loader

    def create_module(self, spec: ModuleSpec) -> ModuleType | None:
        """Create the module as the other loader does."""
        return self.loader.create_module(spec)

    def exec_module(self, module: ModuleType) -> None:
        """Execute the module as the other loader does; then register the environments."""
        self.loader.exec_module(module)
        sys.meta_path[:] = [f for f in sys.meta_path if not isinstance(f, _Waiter)]
        register()

    def __getattr__(self, name: str) -> object:
        """Return an attribute of the other loader, e.g. its resources."""
        return getattr(self.loader, name)
