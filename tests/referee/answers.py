"""True answers for every kind of arm, made by hand: no planner takes part."""

import copy
import math

import numpy as np

from gcm_learn.referee import examine
from tests.chains import SLIDE
from tests.geometry import arm_of, hand_of, links_of
from tests.worlds import ball, body, still

PLANAR_ARM = {
    "upper_arm": 1.2, "elbow": "left", "hand": [1.5, 0.8], "max_hand_speed": 3.0,
    "max_joint_speed": [9.0, 9.0], "thickness": 0.05, "grasp": 0.04,
}  # fmt: skip
LEVEL = {"kind": "quadratic", "velocity": [0.0, 0.0], "acceleration": [0.0, 0.0]}
PLANE = {"origin": [0.3, -1.0, 0.5], "x": [0.0, 0.6, 0.8], "y": [-1.0, 0.0, 0.0]}


def planar_joints(hand, rho, side):
    """Joints (n, 2) of hands (n, 2): by the law of cosines at the elbow; side 1 is right."""
    hand = np.asarray(hand, dtype=float)
    cosine = ((hand**2).sum(axis=1) - 1.0 - rho**2) / (2.0 * rho)
    relative = side * np.arccos(cosine)
    across = np.arctan2(np.sin(relative), rho + np.cos(relative))
    first = np.arctan2(hand[:, 1], hand[:, 0]) - across
    return np.stack([first, relative], axis=1)


def planar(solid=False):
    """A planar arm among discs and polygons, or in a plane that cuts solids."""
    time = np.linspace(0.0, 1.0, 60)
    corner = np.array([[1.5, 0.8], [0.9, 0.6], [1.4, -0.9]])
    hand = np.stack([np.interp(time, [0.0, 0.4, 1.0], x) for x in corner.T], axis=1)
    joints = planar_joints(hand, 1.2, -1.0)
    situation = {"format": "gcm-learn/situation@1", "name": "planar", "horizon": 1.2}
    situation["arm"] = copy.deepcopy(PLANAR_ARM)
    bodies = flat_bodies()
    if solid:
        bodies, situation["plane"] = solid_bodies(), copy.deepcopy(PLANE)
    situation["bodies"] = bodies
    path = {"time": time, "hand": hand, "joints": joints}
    return situation, answer(1, situation, path, [("goal", 1.0)])


def flat_bodies():
    square = [[-0.1, -0.1], [0.1, -0.1], [0.1, 0.1], [-0.1, 0.1]]
    goal = body(
        "target", "goal", {"kind": "disc", "radius": 0.1}, LEVEL | {"position": [1.4, -1.03]}
    )
    post = body(
        "obstacle", "post", {"kind": "disc", "radius": 0.2}, LEVEL | {"position": [2.0, 0.0]}
    )
    spin = LEVEL | {"position": [-0.9, 0.5], "angle": 0.3, "spin": 2.0}
    return [goal, post, body("obstacle", "bar", {"kind": "polygon", "vertices": square}, spin)]


def lifted(x, y, z=0.0):
    """A place of the world over a point of the plane."""
    axes = np.array([PLANE["x"], PLANE["y"], np.cross(PLANE["x"], PLANE["y"])])
    return (np.array(PLANE["origin"]) + np.array([x, y, z]) @ axes).tolist()


def solid_bodies():
    """A ball whose cut has the radius 0.08, and solids."""
    box = {"kind": "box", "half_extents": [0.2, 0.1, 0.15]}
    pole = {"kind": "cylinder", "radius": 0.1, "half_length": 0.3}
    return [
        body("target", "goal", ball(0.1), still(lifted(1.4, -1.01, 0.06))),
        body("obstacle", "post", box, still(lifted(2.1, 0.0), spin=[1.0, 0.0, 2.0])),
        body("obstacle", "bar", pole, still(lifted(-0.9, 0.5))),
    ]


SPATIAL_ARM = {
    "kind": "spatial", "base": {"origin": [0.3, -0.2, 0.9], "rotation": [0.5, -0.5, 0.5, 0.5]},
    "upper_arm": [1.0, 0.1, 0.0], "forearm": [0.9, 0.0, -0.1], "joints": [0.2, 0.3, -0.4, -1.5],
    "joint_range": [[-2.0, 2.0], [-1.0, 1.5], [-2.0, 2.0], [-2.6, 0.0]],
    "max_joint_speed": [5.0, 5.0, 7.0, 7.0], "thickness": 0.05, "grasp": 0.02,
}  # fmt: skip
TIME = [0.0, 0.3, 0.7]
JOINTS = [SPATIAL_ARM["joints"], [0.9, 0.1, 0.4, -0.9], [1.2, 0.8, 0.1, -0.3]]
RATES = [[1.0, -1.0, 2.0, 0.0], [2.0, 0.5, 0.5, 2.0], [0.5, -0.5, -1.0, 1.0]]


def spatial(smooth=False, version=2, obstacle=None, **changes):
    """A spatial arm with a ball at the end of its movement, on straight or cubic curves."""
    arm, path = copy.deepcopy(SPATIAL_ARM), {"time": TIME, "joints": JOINTS}
    if smooth:
        arm |= {"max_joint_acceleration": [60.0] * 4, "joint_rates": RATES[0]}
        path["rates"] = RATES
    arm |= changes
    read, joints = arm_of(arm), np.array(JOINTS)
    path["hand"] = hand_of(read, joints)[0]
    if version == 2:
        path["elbow"] = links_of(read, joints)[0][0, 1]
    goal = body("target", "goal", ball(0.1), still(path["hand"][-1] + [0.0, 0.11, 0.0]))
    post = obstacle or body("obstacle", "post", ball(0.1), still([0.5, -1.2, 2.4]))
    situation = {"format": f"gcm-learn/situation@{version}", "name": "made", "horizon": 0.7}
    situation |= {"arm": arm, "bodies": [goal, post]}
    return situation, answer(version, situation, path, [("goal", 0.7)])


CHAIN_ARM = {
    "kind": "chain", "model": SLIDE,
    "base": {"origin": [1, 2, 0], "rotation": [math.cos(math.pi / 8), 0, 0, math.sin(math.pi / 8)]},
    "posture": [0.4, 0.25, -0.7], "grasp": 0.02, "max_acceleration": [60.0, 60.0, 60.0],
    "rates": [1.0, -0.2, 0.5],
}  # fmt: skip
CHAIN_PATH = {
    "time": [0.0, 0.3, 0.7],
    "joints": [CHAIN_ARM["posture"], [0.9, 0.4, 0.1], [1.1, 0.2, 0.5]],
    "rates": [CHAIN_ARM["rates"], [1.0, 0.3, 1.5], [0.0, -0.5, 0.3]],
}


def chain(smooth=True):
    """A chain that slides and turns, with two targets, both of which it catches."""
    arm, path = copy.deepcopy(CHAIN_ARM), copy.deepcopy(CHAIN_PATH)
    if not smooth:
        del arm["max_acceleration"], arm["rates"], path["rates"]
    path["hand"], axes = hand_of(arm_of(arm), np.array(path["joints"]))
    approach = {"axis": axes[2].tolist(), "within": 0.0}
    hands = path["hand"]
    bodies = [
        body("target", "second", ball(0.1), still(hands[2] + [0, 0.11, 0]), approach=approach),
        body("target", "first", ball(0.05), still(hands[1])),
        body("obstacle", "post", ball(0.1), still([2.2, 2.9, 0.3])),
    ]
    situation = {"format": "gcm-learn/situation@3", "name": "chain", "horizon": 0.7, "arm": arm}
    situation |= {"catch": "all", "bodies": bodies}
    return situation, answer(3, situation, path, [("first", 0.3), ("second", 0.7)])


def answer(version, situation, path, catches):
    """A solution with a trajectory, whose clearance is the one that the referee finds."""
    solution = {"format": f"gcm-learn/solution@{version}", "name": situation["name"]}
    solution |= {"planner": "hand", "status": "caught"}
    if version == 3:
        solution["catches"] = [{"body": name, "time": t} for name, t in catches]
    solution["catch_body"], solution["catch_time"] = catches[-1]
    solution |= {"clearance": 0.0, "planning_ms": 1.0, "message": ""}
    solution["trajectory"] = {name: np.array(column).tolist() for name, column in path.items()}
    return solution | {"clearance": examine(situation, solution).clearance}


def blocked(situation, obstacle, start):
    """The situation with an obstacle moved to a place, and the answer that says so."""
    situation, given = copy.deepcopy(situation), {"status": "start_blocked", "message": "blocked"}
    found = next(b for b in situation["bodies"] if b["name"] == obstacle)
    found["motion"]["position"] = [float(x) for x in start]
    return situation, given


MADE = {
    "planar": lambda: planar(), "solid": lambda: planar(solid=True), "spatial": lambda: spatial(),
    "spatial, smooth": lambda: spatial(smooth=True), "spatial @3": lambda: spatial(version=3),
    "chain": lambda: chain(smooth=False), "chain, smooth": lambda: chain(),
}  # fmt: skip
"""True answers by name: situation and solution."""
