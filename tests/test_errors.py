"""Messages for names that are not known."""

from __future__ import annotations

import pytest

from gcm_learn.errors import FEW, UnknownNameError, not_known

MANY = [f"name-{k}" for k in range(FEW)] + ["layered"]


@pytest.mark.parametrize(
    ("name", "known", "message"),
    [
        ("layred", MANY, "x: 'layred' is not known; did you mean 'layered'?"),
        ("Layered", MANY, "x: 'Layered' is not known; did you mean 'layered'?"),
        ("zzz", MANY, f"x: 'zzz' is not one of {', '.join(MANY)}"),
        ("wav", ("wave", "tree"), "x: 'wav' is not one of wave, tree; did you mean 'wave'?"),
        (3, ("wave", "tree"), "x: 3 is not one of wave, tree"),
    ],
)
def test_the_nearest_name_is_suggested(name, known, message):
    error = UnknownNameError.among("x", name, iter(known))
    assert str(error) == message and error.known == tuple(known)


def test_the_nearest_field_is_suggested():
    assert not_known("n_envz", ["n_envs"]) == "is not a known field (did you mean 'n_envs'?)"
    assert not_known("zz", ["b", "a"]) == "is not a known field (known: a, b)"
