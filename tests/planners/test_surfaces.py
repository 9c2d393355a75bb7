"""Clouds, meshes and margins as obstacles: every catch passes the referee."""

from __future__ import annotations

import copy
import json

import numpy as np
import pytest
import trimesh

from gcm_learn import solve
from gcm_learn.planners import plan_to_json
from gcm_learn.referee import judge
from gcm_learn.situation import situation_from_json
from tests.chains import drawn

PLANNERS = {"marching": 3, "search": 7, "straight": 1, "straight-wait": 2}
"""Planners, and how many of twelve situations they catch at least."""


def surface_of(shape):
    """Return triangles of the surface of a solid."""
    if shape["kind"] == "sphere":
        return trimesh.creation.icosphere(subdivisions=2, radius=shape["radius"])
    if shape["kind"] == "box":
        return trimesh.creation.box(extents=2.0 * np.array(shape["half_extents"]))
    make = trimesh.creation.capsule if shape["kind"] == "capsule" else trimesh.creation.cylinder
    return make(height=2.0 * shape["half_length"], radius=shape["radius"])


def measured(situation, k, margin=False):
    """Return a situation whose obstacles are clouds and meshes in turn, with margins if asked."""
    made = copy.deepcopy(situation) | {"format": "gcm-learn/situation@4"}
    obstacles = [body for body in made["bodies"] if body["role"] == "obstacle"]
    for i, body in enumerate(obstacles):
        surface = surface_of(body["shape"])
        if (i + k) % 2:
            points, _ = trimesh.sample.sample_surface(surface, 40 * (i + 1), seed=k)
            body["shape"] = {"kind": "cloud", "points": np.array(points).tolist(), "radius": 0.02}
        else:
            corners, sides = np.array(surface.vertices), np.array(surface.faces)
            body["shape"] = {"kind": "mesh", "vertices": corners.tolist()}
            body["shape"]["triangles"] = sides.tolist()
        if margin and body["name"] != "table":
            body["margin"] = {"now": 0.002, "rate": 0.01}
    return made


@pytest.mark.parametrize(
    "planner",
    [pytest.param(name, marks=() if name == "search" else pytest.mark.slow) for name in PLANNERS],
)
@pytest.mark.parametrize("name", ["panda", "slide"])
def test_what_was_measured_is_not_touched(name, planner):
    caught = 0
    for k in range(12):
        situation = measured(drawn(name, k), k, margin=k % 3 == 0)
        answer = json.loads(
            json.dumps(plan_to_json(solve(situation_from_json(situation), planner)))
        )
        assert judge(situation, answer) == [], situation["name"]
        caught += answer["status"] == "caught"
    assert caught >= PLANNERS[planner]


def test_a_mesh_has_no_inside_and_a_cloud_is_full():
    """An arm within a closed mesh is free; one within a ball of a cloud is blocked."""
    situation = measured(drawn("slide", 0), 0)
    target = situation["bodies"][0]
    rest = {"kind": "quadratic", "velocity": [0, 0, 0], "acceleration": [0, 0, 0]}
    there = rest | {"position": situation["arm"].get("base", {}).get("origin", [0, 0, 0])}
    shell = trimesh.creation.icosphere(subdivisions=2, radius=9.0)
    mesh = {"kind": "mesh", "vertices": np.array(shell.vertices).tolist()}
    mesh["triangles"] = np.array(shell.faces).tolist()
    ball = {"kind": "cloud", "points": [[0, 0, 0]], "radius": 9.0}
    for shape, status in ((mesh, "caught"), (ball, "start_blocked")):
        room = {"role": "obstacle", "name": "room", "shape": shape, "motion": there}
        asked = situation | {"bodies": [target, room]}
        plan = solve(situation_from_json(asked), "search")
        assert plan.status == status
        assert judge(asked, json.loads(json.dumps(plan_to_json(plan)))) == []
