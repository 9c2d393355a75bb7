"""Files of Stable-Baselines3 models, read without running code that they bring along.

Such a file is a ZIP archive.  Weights in it are tensors, which torch reads with
``weights_only=True``.  Spaces, the policy's class and its arguments are pickles; here they may
only name classes of Gymnasium, NumPy, torch and Stable-Baselines3.
"""

from __future__ import annotations

import base64
import io
import json
import pickle
import zipfile
from pathlib import Path
from typing import Any

from gcm_learn.errors import MissingExtraError, PolicyError, UnknownNameError
from gcm_learn.planners import in_words

NEEDED = ("policy_class", "observation_space", "action_space", "policy_kwargs")
SCALED = ("vecnormalize.pkl", "vec_normalize.pkl")  # statistics that are kept beside models
ARRAYS = (
    "_reconstruct", "scalar", "_frombuffer", "__generator_ctor", "__bit_generator_ctor",
    "__pyx_unpickle_SeedSequence",
)  # fmt: skip
"""Functions of NumPy that make arrays and generators."""
PLACES = (
    "gymnasium.spaces", "numpy", "stable_baselines3", "sb3_contrib", "torch.nn.modules",
    "torch.optim",
)  # fmt: skip


def read_model(path: Path) -> Any:
    """Return the policy in the file of a model, whatever algorithm made it.

    Parameters
    ----------
    path : Path

    Raises
    ------
    UnknownNameError
        If there is no such file.
    MissingExtraError
        Without Stable-Baselines3.
    PolicyError
        If it is no model, if it needs code of its own, or if its observations were scaled.
    """
    if not path.is_file():
        raise UnknownNameError(f"{str(path)!r}: there is no such file")
    _refuse_scaled(path)
    try:
        from stable_baselines3.common.save_util import load_from_zip_file
    except ImportError:
        raise MissingExtraError(f"{path.name!r}", "stable_baselines3", "rl") from None
    try:
        data = _data(path)
        made, space, actions, more = (data[name] for name in NEEDED)
        noise = {"use_sde": True} if data["use_sde"] else {}
        policy = made(space, actions, lambda progress: 0.0, **more | noise)
        _, states, _ = load_from_zip_file(path, load_data=False, device="cpu")
        policy.load_state_dict(states["policy"])
    except PolicyError:
        raise
    except Exception as error:
        reason = f"is no model of Stable-Baselines3 ({in_words(error)})"
        raise PolicyError(f"{str(path)!r}: {reason}") from error
    policy.set_training_mode(False)
    return policy


def _refuse_scaled(path: Path) -> None:
    """Refuse a model beside which the statistics of `VecNormalize` are kept."""
    for name in SCALED:
        if path.with_name(name).exists():
            raise PolicyError(
                f"{str(path)!r}: its observations were scaled ({name}); "
                "load both yourself, and give the model with its environment as an object"
            )


def _data(path: Path) -> dict[str, Any]:
    """Return what is needed of a model's data."""
    with zipfile.ZipFile(path) as archive:
        kept = json.loads(archive.read("data"))
    found: dict[str, Any] = {"use_sde": kept.get("use_sde", False)}
    for name in NEEDED:
        value = kept[name]
        if isinstance(value, dict) and ":serialized:" in value:
            pickled = base64.b64decode(value[":serialized:"])
            value = _Reader(io.BytesIO(pickled), f"{str(path)!r}: {name}").load()
        found[name] = value
    return found


class _Reader(pickle.Unpickler):
    """Reader of pickles that makes spaces, arrays and classes of policies only.

    Parameters
    ----------
    stream : binary stream
    about : str
        Name of the pickle in messages.
    """

    def __init__(self, stream: io.BytesIO, about: str) -> None:
        super().__init__(stream)
        self._about = about

    def find_class(self, module: str, name: str) -> Any:
        """Return a class by its name, if pickles may name it."""
        if (module, name) == ("collections", "OrderedDict"):
            return super().find_class(module, name)
        if any(module == place or module.startswith(f"{place}.") for place in PLACES):
            found = super().find_class(module, name)
            array = module.startswith("numpy.") and name in ARRAYS
            if array or (isinstance(found, type) and issubclass(found, _allowed())):
                return found
        raise PolicyError(
            f"{self._about} needs {module}.{name}, which is not run from a file; "
            "load the model yourself and give it as an object"
        )


def _allowed() -> tuple[type, ...]:
    """Return the classes whose subclasses pickles may name."""
    import numpy as np
    from gymnasium.spaces import Space
    from stable_baselines3.common.policies import BasePolicy
    from stable_baselines3.common.torch_layers import BaseFeaturesExtractor
    from torch.nn import Module
    from torch.optim import Optimizer

    arrays = (np.ndarray, np.dtype, np.generic)
    draws = (np.random.Generator, np.random.BitGenerator, np.random.SeedSequence)
    return (Space, BasePolicy, BaseFeaturesExtractor, Module, Optimizer, *arrays, *draws)
