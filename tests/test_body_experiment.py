"""The paper's experiment in physics: its variations, and that its page tells what it found."""

from __future__ import annotations

import importlib.util
import json
import sys
from pathlib import Path

import numpy as np
import pytest

from gcm_learn.motion import start_clearance
from gcm_learn.scene import pack, pose

FOLDER = Path(__file__).parents[1] / "experiments" / "14_body"
RESULTS = json.loads((FOLDER / "fig8.json").read_text("utf-8"))


@pytest.fixture(scope="module")
def script():
    spec = importlib.util.spec_from_file_location("body_fig8", FOLDER / "fig8.py")
    module = importlib.util.module_from_spec(spec)
    path = list(sys.path)
    spec.loader.exec_module(module)
    sys.path[:] = path
    return module


def test_variations_differ_and_begin_free(script):
    drawn = [script.varied(k) for k in range(12)]
    assert all(start_clearance(pack(s)) > 0.0 for s in drawn)
    assert len({s.bodies[0].motion.angle for s in drawn}) == 12
    assert script.varied(3) == drawn[3]
    for situation in drawn:
        ball, cord, _ = situation.bodies
        pivot = np.array(ball.motion.pivot)
        for t in (0.0, 0.4):
            place, middle = pose(situation, 0, t)[0], pose(situation, 1, t)[0]
            way = (place - pivot) / ball.motion.length
            end = middle + way * cord.shape.half_length
            assert np.linalg.norm(place - end) == pytest.approx(ball.shape.radius)


@pytest.mark.parametrize("name", ["executed", "tube", "gravity", "kinematic"])
def test_counts_of_the_results_add_up(name):
    found = RESULTS[name]
    assert found["planned"] <= found["situations"] == len(RESULTS["rows"])
    ends = found["caught"] + found["late"] + sum(found["collided"].values())
    assert ends == found["planned"]
    assert max(found["within_2_cm"], found["within_5_ms"], found["stays"]) <= found["caught"]


def test_rows_are_those_that_were_counted():
    statuses = [row[1] for row in RESULTS["rows"]]
    found = RESULTS["executed"]
    assert statuses.count("caught") == found["caught"]
    assert statuses.count("no plan") == found["situations"] - found["planned"]
    assert RESULTS["clear"][0] <= found["caught"]


def test_the_page_tells_what_was_found():
    page = (FOLDER / "README.md").read_text("utf-8")
    rows = [line.split("|")[2:5] for line in page.splitlines() if line.startswith("|")]
    told = {tuple(cell.strip().strip("*") for cell in row[:2]) for row in rows}
    for name in ("executed", "tube", "gravity", "kinematic"):
        assert (str(RESULTS[name]["planned"]), str(RESULTS[name]["caught"])) in told
    found = RESULTS["executed"]
    assert f"are {found['within_5_ms']} (" in page
    assert f"it is in {found['stays']} of {found['caught']}" in page
    assert f"of the {RESULTS['clear'][0]} plans that" in page and RESULTS["clear"][1] == 0
