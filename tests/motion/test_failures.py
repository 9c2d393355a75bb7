"""Reasons can be counted, and are sentences."""

from __future__ import annotations

import string
from collections import Counter

import pytest

from gcm_learn import families, get_planner
from gcm_learn.motion.failures import Failure, Reason


def spoken(failure):
    """The reason with some number in every brace."""
    names = [name for _, name, _, _ in string.Formatter().parse(failure.value) if name]
    return failure.with_numbers(**dict.fromkeys(names, 2.5))


@pytest.mark.parametrize("failure", Failure, ids=lambda failure: failure.name)
def test_a_sentence_tells_its_reason(failure):
    assert Failure.of(str(spoken(failure))) is failure
    assert "{" not in str(spoken(failure))


def test_a_catch_has_no_reason():
    assert Failure.of("caught 'ball' at 0.500 s") is None


def test_what_planners_answer_can_be_counted():
    counted = Counter()
    for name in ("gate", "random-planar", "behind-mover"):
        for k in range(8):
            plan = get_planner("straight").plan(families.draw(name, 2, k))
            assert (plan.failure is None) == plan.caught
            assert plan.caught or plan.failure is Failure.of(plan.message)
            counted[plan.failure] += 1
    assert counted[None] > 0 and counted[Failure.COLLISION] > 0


def test_a_reason_inside_a_reason_is_told():
    inner = Failure.COLLISION.with_numbers(when=0.25)
    outer = Failure.TOO_SLOW.with_numbers(limit=9.0, reason=inner)
    assert str(outer) == "not with accelerations up to 9: the limb is touched at t = 0.250 s"
    assert Failure.of(str(outer)) is Failure.TOO_SLOW and isinstance(inner, Reason)
