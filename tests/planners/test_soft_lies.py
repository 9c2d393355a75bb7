"""The package's judge and the referee say the same of planted lies and of the true answers."""

import numpy as np
import pytest

from gcm_learn.motion import Movement
from gcm_learn.planners import Plan
from gcm_learn.planners.outside import broken_promise
from gcm_learn.planners.plan import Catch
from gcm_learn.situation import situation_from_json
from tests.referee.belt import edited
from tests.referee.test_soft_lies import LIES, PAIR

CLOSER = (
    "accelerates at the end", "accelerations at the start", "jump of acceleration",
    "turns at the end",
)  # fmt: skip
"""True answers at the rim of a tolerance, of which the package grants half."""
REFUSED = "rounded approaches"
"""The lie is a situation that is refused."""


def fault(edits):
    """Return what the package says against an answer in JSON."""
    pair = edited(PAIR, edits)
    situation, answer = situation_from_json(pair["situation"]), pair["solution"]
    path = [np.array(answer["trajectory"][key], float) for key in ("time", "joints", "rates")]
    *way, last = [
        Catch(c["body"], c["time"], c.get("held_until"), c.get("placed")) for c in answer["catches"]
    ]
    plan = Plan(
        answer["name"], "x", "caught", "", 0.0, answer["catch_time"], answer["catch_body"],
        trajectory=Movement(situation.arm, *path), on_the_way=tuple(way),
        held_until=last.held_until, placed=last.placed,
    )  # fmt: skip
    return broken_promise(situation, plan)


@pytest.mark.parametrize("name", sorted({*LIES} - {REFUSED}))
def test_both_judges_find_a_lie(name):
    true, lie, _ = LIES[name]
    assert name in CLOSER or fault(true) is None
    assert fault(true | lie) is not None
