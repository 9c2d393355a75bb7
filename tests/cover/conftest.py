"""Small covers of the belt families, grown once."""

from __future__ import annotations

import pytest

from gcm_learn.cover import Budget, Cover, grow, parametric_family
from gcm_learn.processes import Here


def grown(name, free, **budget):
    """Return a cover of a family."""
    cover = Cover(parametric_family(name).free(free))
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


@pytest.fixture(params=["plane", "chain", pytest.param("space", marks=pytest.mark.slow)])
def cover(request):
    """Return each of the covers."""
    return request.getfixturevalue(request.param)
