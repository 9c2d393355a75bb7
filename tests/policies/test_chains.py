"""Policies of chains: in the arena, in comparisons, and as planners."""

import numpy as np
import pytest

from gcm_learn.errors import ArenaError
from gcm_learn.evaluation import ActorMethod, ask, get_method
from gcm_learn.execution import ChainSettings
from gcm_learn.policies import ActorPlanner
from gcm_learn.policies.outside import own_policy
from gcm_learn.situation import situation_from_json
from tests.chains import BLOCKED, drawn


class Straight:
    """Policy that follows the aim, for the arm of its settings."""

    settings = ChainSettings()

    def act(self, observations):
        at = self.settings.straight
        return observations[:, at : at + self.settings.commands]


@pytest.fixture(scope="module")
def situations():
    """Return situations of a Panda whose limb begins free."""
    return [situation_from_json(drawn("panda", k)) for k in range(8) if k != BLOCKED]


def test_a_policy_acts_and_its_catches_are_plans(situations):
    """Tried out first, a catch is a verified plan at the time at which the arena caught."""
    method = get_method(Straight())
    assert isinstance(method, ActorMethod)
    planner, caught = ActorPlanner(own_policy(Straight()), "straight-on", tries=1), 0
    for situation in situations:
        result, plan = method.answer(situation), planner.plan(situation)
        assert (result.outcome == "caught") == plan.caught
        if plan.caught:
            caught += 1
            assert plan.catch_time == pytest.approx(result.plans[0].catch_time)
            moves = result.plans[0].trajectory
            np.testing.assert_array_equal(plan.trajectory.joints, moves.joints)
    assert caught > 3


def test_policies_and_planners_are_compared(situations):
    sheet = ask([Straight(), "straight"], situations)
    for name in ("Straight", "straight"):
        outcomes = set(sheet.where(entrant=name)["outcome"])
        assert "caught" in outcomes and not outcomes & {"error", "broken"}


def test_an_arm_of_another_size_is_refused_in_one_line(situations):
    other = Straight()
    other.settings = ChainSettings(arm="ur5")
    with pytest.raises(ArenaError, match=r"^arm: 'ur5' has 6 joints and 8 links") as caught:
        ActorPlanner(own_policy(other), "other", tries=1).plan(situations[0])
    assert "\n" not in str(caught.value)
