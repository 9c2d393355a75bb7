"""What can be tested with the libraries that are installed."""

from __future__ import annotations

from importlib.util import find_spec

import pytest

from gcm_learn.planners import planner_names

NEEDS = {"st-rrt-star": "ompl"}  # planner: library
INSTALLED = [name for name in planner_names() if find_spec(NEEDS.get(name, "numpy")) is not None]


def needed(name):
    """Skip a test of a planner whose library is missing."""
    return pytest.mark.skipif(
        name not in INSTALLED, reason=f"{name} needs {NEEDS[name]} (extra `peers`)"
    )


def planner_params(names=None):
    """Planners, or all, as parameters; those of other libraries are slow, or skipped if missing."""
    return [
        pytest.param(
            name,
            marks=[needed(name), pytest.mark.slow] if name in NEEDS else (),
        )
        for name in names or planner_names()
    ]
