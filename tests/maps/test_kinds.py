"""Maps and engines refuse kinds of arms for which there are none, in one line."""

from __future__ import annotations

import pytest

from gcm_learn.charts import chart_of
from gcm_learn.errors import ArmKindError
from gcm_learn.maps import build_map, explore
from gcm_learn.scene import pack
from gcm_learn.situation import situation_from_json
from gcm_learn.wave import MarchingParams, WaveParams
from tests.charts.test_chart import CHAIN
from tests.situation.scenes import NAO

SPACE, LINKS = situation_from_json(NAO), situation_from_json(CHAIN)
WAVE, MARCHING = WaveParams(), MarchingParams()
REFUSALS = [
    (SPACE, WAVE, True, "a wave that may wait does not take spatial arms"),
    (LINKS, WAVE, False, "a wave does not take chains"),
    (LINKS, WAVE, True, "a wave that may wait does not take chains"),
    (LINKS, MARCHING, True, "marching that may wait does not take chains"),
]


@pytest.mark.parametrize(("situation", "params", "wait", "message"), REFUSALS)
def test_a_map_that_cannot_be_is_refused(situation, params, wait, message):
    with pytest.raises(ArmKindError) as refusal:
        build_map(situation, params, wait=wait)
    assert str(refusal.value) == f"{message} (situation {situation.name!r})"


def test_a_front_that_cannot_be_is_refused():
    with pytest.raises(ArmKindError, match="a wave that may wait does not take spatial arms"):
        explore(pack(SPACE), chart_of(SPACE, 20), WAVE, wait=True)
    with pytest.raises(ArmKindError, match="a wave does not take chains"):
        explore(pack(LINKS), chart_of(LINKS, 20), WAVE)
