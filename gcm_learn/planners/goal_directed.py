"""The default planner of planar arms: a goal-directed search (`planners.sipp`), verified."""

from __future__ import annotations

from functools import partial

import numpy as np

from gcm_learn.arms import elbow_of
from gcm_learn.charts import LARGEST_LATTICE, Lattice, hand_space
from gcm_learn.collision import DEEPEST, NEVER, Sweep, postures_of
from gcm_learn.motion import Failure, refine, straight_path
from gcm_learn.planners import completion, layered_front, sipp
from gcm_learn.planners.fronts import FrontPlanner
from gcm_learn.planners.plan import Plan
from gcm_learn.planners.sipp_labels import PIECES, Aim, Hunt, Labels, Queue, SearchCells, SearchEnd
from gcm_learn.wave import MarchingParams

MOST = 40_000  # labels that are taken up at most
BRIEF = 4_000  # of them on the finer lattice
FINER = 3  # its cells a side, for two of the other
SLICE = 200  # labels that are taken up between two readings of the clock
INSTANT = 0.1  # resolution of interceptions [crossings of a cell]
ANY = 1e9  # resolution of a clearance of which only the sign matters
LABELS = 3  # for which there is room, for every cell


def search() -> FrontPlanner:
    """Return the default planner of planar arms."""
    return layered(name="search")


def layered(params: MarchingParams | None = None, name: str = "layered") -> FrontPlanner:
    """Return the default planner under its other name, "layered": the hand may wait.

    The straight line to the earliest interception is the answer if it holds.  A search that
    heads for the target comes next, see `found`.  Neither makes a map; `build_map` with
    ``wait=True`` does.  Causal marching over cells and their safe intervals is for arms with limits
    of joints and for what the search leaves open.
    """
    params = MarchingParams() if params is None else params
    find = partial(found, n=params.n)
    return FrontPlanner(name, layered_front.levels(params), direct=True, find=find)


def found(problem: completion.Problem, n: int) -> Plan | None:
    """Search for a plan: a verified catch, the failure to find any, or None if undecided.

    It is undecided for arms with limits of joints, which legs do not know.  Rests between two legs
    are checked only so often that a plan may, rarely, turn out to touch.

    Parameters
    ----------
    problem : Problem
    n : int
        Cells a side of the lattice.  A finer one, which sees narrower gaps, is searched briefly.
    """
    if problem.situation.arm.max_joint_speed is not None:
        return None
    cut = False
    for size, most in ((n, MOST), (min(FINER * n // 2, LARGEST_LATTICE), BRIEF)):
        ground, labels, catches = searched(problem, size, most)
        cut = cut or problem.nodes >= MOST
        for caught in reversed(catches):
            attempt = _attempt(problem, ground, labels, caught)
            plan = None if attempt is None else completion.judged(problem, attempt)[0]
            if plan is not None:
                return plan
        if catches:
            return None
        if problem.over:
            return problem.answer(Failure.OUT_OF_TIME)
    return problem.answer(Failure.OUT_OF_WORK if cut else Failure.NO_INTERCEPTION)


def searched(
    problem: completion.Problem, n: int, most: int = MOST
) -> tuple[SearchCells, Labels, list[SearchEnd]]:
    """Search over n cells a side until nothing is left, or until the deadline.

    Returns
    -------
    ground, labels : SearchCells, Labels
        What was reached.
    catches : list of Catch
        The earliest, the last one of the list; with a deadline some that were found before, too.
    """
    arm, gain = problem.situation.arm, problem.gain
    ground = ground_of(problem, Lattice(n, arm.upper_arm, arm.elbow))
    labels = room_for(LABELS * n * n)
    hunt = new_hunt(labels.node.size, problem.situation.horizon)
    catches: list[SearchEnd] = []
    while most > 0 and hunt.goes_on and not problem.over:
        caught, hunt, taken = sipp.search(ground, labels, hunt, gain, problem.slices(SLICE, most))
        most, problem.nodes = most - taken, problem.nodes + taken
        if caught.label >= 0:
            catches.append(caught)
            if caught.time <= gain:
                break
    return ground, labels, catches


def ground_of(problem: completion.Problem, lattice: Lattice) -> SearchCells:
    """The lattice and the start as the search reads them."""
    scene, space = problem.scene, hand_space(lattice)
    elbow = elbow_of(scene.limb.x, scene.limb.y, scene.limb.rho, scene.limb.side)
    limb = np.vstack([space.limb, [(scene.limb.x, scene.limb.y, *elbow)]])
    nodes, bodies = len(limb), len(scene.bodies.rows)
    rules, crossing = problem.rules, lattice.spacing / scene.limits.speed
    touch, (first, size, soonest) = rules.touch, unasked(nodes)
    return SearchCells(
        scene=scene,
        rules=rules._replace(instant=max(rules.instant, INSTANT * crossing)),
        postures=postures_of(scene.bodies, limb, np.full(nodes, touch)),
        n=lattice.n,
        inside=space.inside,
        spacing=lattice.spacing,
        hole=completion.hole_of(problem.situation.arm),
        sweep=leg_room(bodies, touch),
        sweeps=np.empty(PIECES),
        budget=problem.budget,
        first=first,
        size=size,
        soonest=soonest,
    )


def _attempt(
    problem: completion.Problem, ground: SearchCells, labels: Labels, caught: SearchEnd
) -> completion.Attempt | None:
    """The movement that ends in a catch."""
    arm, chain = problem.situation.arm, [caught.label]
    while labels.via[chain[0]] >= 0:
        chain.insert(0, int(labels.via[chain[0]]))
    places = ground.postures.limb[labels.node[chain[1:]], :2]
    hand, wanted = completion.path_through(arm, places, labels.arrival[chain[1:]])
    time, hand = completion.timed(arm, wanted, hand)
    leave = max(caught.leave, float(time[-1]))
    if leave > time[-1]:
        time, hand = np.append(time, leave), np.vstack([hand, hand[-1:]])
    last = straight_path(hand[-1], np.array([caught.x, caught.y]))
    times, last = refine(arm, np.linspace(leave, max(caught.time, leave), len(last)), last)
    return completion.go_on(problem, time, hand, (times, last, caught.body))


def new_hunt(labels: int, bound: float) -> Hunt:
    """Return a search for a catch before a bound [s], with memory for so many labels."""
    queue = np.empty(labels), np.empty(labels), np.empty(labels, np.int64), np.zeros(1, np.int64)
    return Hunt(Aim(np.empty((0, 0, 4)), 0.0, bound), Queue(*queue), np.zeros(1, np.int64))


def leg_room(bodies: int, floor: float) -> Sweep:
    """Return buffers to check legs among so many bodies; nearer than `floor` is touching."""
    stack = np.empty((DEEPEST + 2, 3))
    return Sweep(np.zeros(2), np.zeros((2, 2)), floor, ANY, np.zeros((bodies, 12)), stack)


def unasked(nodes: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """First label, number of labels and `soonest` (nodes,) before any node is opened."""
    return np.full(nodes, -1), np.zeros(nodes, dtype=np.int64), np.full(nodes, NEVER)


def room_for(count: int) -> Labels:
    """Labels of nothing yet."""
    node, via, by, tries = np.full((4, count), -1)
    since, until, arrival, tent = np.full((4, count), NEVER)
    return Labels(node, since, until, arrival, via, tent, by, tries)
