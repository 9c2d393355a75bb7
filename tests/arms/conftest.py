"""Arms of files from fewer postures than a user gets, which finds the same pairs sooner."""

from __future__ import annotations

import pytest

from gcm_learn.arms.robots import pairs


@pytest.fixture(scope="session", autouse=True)
def few_postures():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(pairs, "POSTURES", 3000)
        patch.setattr(pairs, "CORNERS", 300)
        yield
