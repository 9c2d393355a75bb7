"""Small covers of the belt families, grown once."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from gcm_learn.cover import Budget, Cover, grow, parametric_family
from gcm_learn.families.chain.measured import cloud_of, mesh_of
from gcm_learn.processes import Here
from gcm_learn.situation import Margin


def grown(name, free, **budget):
    """Return a cover of a family."""
    return grown_of(parametric_family(name).free(free), **budget)


def grown_of(family, **budget):
    """Return a cover of a family of the caller's."""
    cover = Cover(family)
    grow(cover, Budget(**budget), Here())
    return cover


@pytest.fixture(scope="session")
def plane():
    """Return a cover of the belt in the plane, two parameters free."""
    return grown("belt", 2, share=1.0, cells=60)


@pytest.fixture(scope="session")
def space():
    """Return a cover of the belt before a spatial arm; places of part and carrier are free."""
    return grown("belt-space-varied", 2, share=1.0, cells=120)


@pytest.fixture(scope="session")
def chain():
    """Return a cover of the belt before a Panda, two parameters free."""
    return grown("belt-chain", 2, share=0.9, cells=200)


@pytest.fixture(scope="session")
def measured():
    """Return a cover before a Panda of a post that is a cloud, a mesh, and goods with a margin."""
    family, rng = parametric_family("belt-chain"), np.random.default_rng(0)
    change = {
        "post 1": lambda body: {"shape": cloud_of(rng, mesh_of(body.shape), 500, 0.004)},
        "carrier": lambda body: {"shape": mesh_of(body.shape)},
        "good 1": lambda body: {"margin": Margin(0.01, 0.01)},
    }
    bodies = family.middle.bodies
    bodies = tuple(replace(b, **change.get(b.name, lambda body: {})(b)) for b in bodies)
    middle = replace(family.middle, bodies=bodies, format="gcm-learn/situation@4")
    return grown_of(replace(family, middle=middle).free(1), share=0.9)


@pytest.fixture(params=["plane", "chain", pytest.param("space", marks=pytest.mark.slow)])
def cover(request):
    """Return each of the covers."""
    return request.getfixturevalue(request.param)
