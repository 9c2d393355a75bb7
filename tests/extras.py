"""What can be tested with the libraries that are installed."""

from __future__ import annotations

from importlib.util import find_spec

import pytest

from gcm_learn.planners import planner_names

NEEDS = {"st-rrt-star": "ompl"}  # planner: library
INSTALLED = [name for name in planner_names() if find_spec(NEEDS.get(name, "numpy")) is not None]


def planner_params(names=None):
    """Planners, or all, as parameters; where a library is missing they are skipped, and say so."""
    return [
        pytest.param(
            name,
            marks=pytest.mark.skipif(
                name not in INSTALLED, reason=f"{name} needs {NEEDS.get(name)} (extra `peers`)"
            ),
        )
        for name in names or planner_names()
    ]
