"""Answers of the engine to the page, without a server."""

import base64
import json
import threading

import numpy as np
import pytest

from gcm_learn.charts import Lattice, occupied_cells
from gcm_learn.families import draw, gate_scene
from gcm_learn.maps import build_map
from gcm_learn.planners import get_planner, plan_with, solve, stratum
from gcm_learn.play import KINDS, Newest, example, respond
from gcm_learn.play.answers import LEVELS, NEVER, OBSTACLE, extended_pictures, map_picture
from gcm_learn.play.server import DROPPED
from gcm_learn.situation import situation_from_json, situation_to_json
from gcm_learn.wave import MarchingParams
from tests import worlds

FIRST = example()
PATHS = ("search", "gcm")


def changed(*path, to):
    """Return the example with one field changed."""
    return worlds.changed(FIRST, path, to)


@pytest.mark.parametrize("scene", [FIRST, situation_to_json(gate_scene())], ids=lambda s: s["name"])
def test_an_answer_has_the_plans_of_solve(scene):
    question = {"situation": scene, "planners": list(PATHS), "instants": [0.0, 0.4]}
    answer = respond("answer", question)
    for name, plan in zip(PATHS, answer["plans"], strict=True):
        asked = solve(situation_from_json(scene), name)
        assert (plan["status"], plan["catch_time"]) == (asked.status, asked.catch_time)
        assert plan["map"]["size"] == 80
        if asked.caught:
            np.testing.assert_allclose(plan["trajectory"]["hand"], asked.trajectory.hand, atol=1e-5)
    assert [picture["time"] for picture in answer["extended"]] == [0.0, 0.4]
    assert set(answer["parts_ms"]) >= {"read", "plan gcm", "map gcm", "obstacles"}
    json.dumps(answer, allow_nan=False)


def test_maps_are_made_only_when_they_are_shown():
    answer = respond("answer", {"situation": FIRST, "map": False})
    assert "map" not in answer["plans"][0] and answer["extended"] == []


def test_pictures_hold_what_the_engine_computed():
    situation = gate_scene()
    made = build_map(situation, MarchingParams())
    picture = map_picture(made)
    cells = np.frombuffer(base64.b64decode(picture["cells"]), dtype=np.uint8).reshape(80, 80)
    reached = ~np.ma.getmaskarray(made.arrival)
    shown = cells[reached] * picture["last"] / LEVELS
    np.testing.assert_allclose(shown, made.arrival[reached], atol=0.51 * picture["last"] / LEVELS)
    assert set(np.unique(cells[made.effective_obstacles & ~reached])) == {OBSTACLE}
    assert (cells == NEVER).any()
    (extended,) = extended_pictures(situation, [0.3])
    bits = np.unpackbits(np.frombuffer(base64.b64decode(extended["cells"]), dtype=np.uint8))
    size = extended["size"]
    wanted = occupied_cells(situation, Lattice(size), 0.3)
    assert wanted.any() and np.array_equal(bits.reshape(size, size).astype(bool), wanted)


@pytest.mark.parametrize(("family", "index"), [("static-clutter", 0), ("gate", 1)])
def test_a_stratum_is_that_of_the_oracle(family, index):
    drawn = respond("draw", {"name": family, "index": index})["situation"]
    situation = draw(family, 0, index)
    assert drawn == situation_to_json(situation)
    explained = respond("explain", {"situation": drawn})
    assert explained["stratum"] == stratum(situation) and explained["reasons"]
    assert (explained["stratum"] == "L") == plan_with(get_planner("straight"), situation).caught


@pytest.mark.slow
def test_everything_that_is_offered_is_answered():
    offered = respond("begin", {})
    for name in [*offered["scenes"], *offered["families"]]:
        drawn = respond("draw", {"name": name, "index": 3})["situation"]
        answer = respond("answer", {"situation": drawn, "planners": offered["planners"][:1]})
        assert answer["plans"][0]["status"] in ("caught", "unreachable", "start_blocked")
    for name in offered["planners"]:
        (plan,) = respond("answer", {"situation": FIRST, "planners": [name]})["plans"]
        assert plan["planner"] == name and plan["map"]["size"] in (80, 160)


def test_a_text_is_read_with_its_defaults():
    short = {"name": "a", "horizon": 1.0, "format": FIRST["format"], "bodies": FIRST["bodies"]}
    short["arm"] = {"hand": [1.1, -0.4], "max_hand_speed": 3.1}
    line = json.dumps({"suite": "mine", "situation": short})
    for text in (json.dumps(short, indent=2), f"{json.dumps(short)}\n{json.dumps(FIRST)}", line):
        found = respond("read", {"text": text})["situation"]
        assert found["name"] == "a" and found["arm"]["elbow"] == "right"


SOLID = situation_to_json(draw("gate-solid", 0, 0))
CHAIN = {"format": "gcm-learn/situation@3", "arm": {"kind": "chain", "model": "secret.json"}}
REFUSED = [
    ("answer", {"situation": changed("arm", "hand", to=[2.4, 0])}, "is out of reach (max 2.0)"),
    ("answer", {"situation": changed("horizon", to=-1)}, "horizon: must be positive (got -1.0)"),
    ("answer", {"situation": changed("bodies", 0, "role", to="obstacle")}, "no target"),
    ("answer", {"situation": changed("bodies", to=FIRST["bodies"] * 20)}, "already the name"),
    ("answer", {"situation": SOLID}, "planar bodies only"),
    ("answer", {"situation": CHAIN}, "gcm-learn/situation@1 only"),
    ("answer", {}, "must be"),
    ("answer", {"situation": FIRST, "planners": ["os:system"]}, "planner: 'os:system' is not"),
    ("answer", {"situation": FIRST, "planners": ["gcm"] * 3}, "planners: must be a list of 1 to 2"),
    ("answer", {"situation": FIRST, "instants": [0.1] * 99}, "at most 16"),
    ("answer", {"situation": FIRST, "instants": [float("nan")]}, "must be a number from 0 on"),
    ("answer", {"situation": FIRST, "deadline": "now"}, "deadline: must be a number"),
    ("draw", {"name": "gaet"}, "did you mean 'gate'?"),
    ("draw", {"name": "gate-solid"}, "'gate-solid' is not"),
    ("draw", {"name": "gate", "index": -1}, "index: must be an integer from 0"),
    ("read", {"text": "{,}"}, "line 1: not valid JSON"),
    ("read", {"text": 3}, "text: must be a string"),
]  # fmt: skip


@pytest.mark.parametrize(("kind", "question", "said"), REFUSED, ids=lambda x: str(x)[:40])
def test_refusals_are_one_line_of_the_engine(kind, question, said):
    answer = respond(kind, question)
    assert list(answer) == ["error"] and said in answer["error"] and "\n" not in answer["error"]


def test_the_newest_question_wins_and_errors_are_answers():
    begun, go_on = threading.Event(), threading.Event()

    def slow(kind, question):
        begun.set()
        assert go_on.wait(10.0)
        return {"said": 1 / question["k"]}

    worker, answers = Newest(slow), {}

    def ask(k, page="a"):
        answers[k, page] = worker.ask("answer", {"k": k}, page)

    threads = [threading.Thread(target=ask, args=(1,))]
    threads[0].start()
    assert begun.wait(10.0)
    for k, page in ((2, "a"), (0, "a"), (4, "b")):
        threads.append(threading.Thread(target=ask, args=(k, page)))
        threads[-1].start()
        while (page, "answer") not in worker._waiting or worker._waiting[page, "answer"].question[
            "k"
        ] != k:
            pass
    go_on.set()
    for thread in threads:
        thread.join(10.0)
    assert answers[1, "a"] == {"said": 1.0} and answers[4, "b"] == {"said": 0.25}
    assert answers[2, "a"] == DROPPED
    assert answers[0, "a"] == {"error": "unexpected error: ZeroDivisionError: division by zero"}


def test_kinds_are_those_of_the_page():
    assert set(KINDS) == {"begin", "read", "draw", "extend", "answer", "explain"}
