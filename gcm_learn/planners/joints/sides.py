"""A search from either end in turn, until one finds a way or has nothing left to try."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from gcm_learn.charts import JointLattice, joint_lattice
from gcm_learn.planners.completion import SpatialProblem
from gcm_learn.planners.joints.backward import (
    goal_at_start,
    plant_goals,
    reversed_scene,
    trace_back,
)
from gcm_learn.planners.joints.goals import Goals
from gcm_learn.planners.joints.lattice_search import Tree, new_tree, plant, search
from gcm_learn.planners.joints.moves import NEVER, Study
from gcm_learn.planners.joints.ways import Way, new_way, trace

SLICE = 100  # moves that are checked between two readings of the clock


class Effort(NamedTuple):
    """Limits of a search."""

    nodes: int
    """Of the lattice over the joints, about."""
    tries: tuple[int, ...]
    """Moves that are checked from the start, from the goals, from the start, ..."""
    weight: float = 1.0
    """Of the motion that is left, beside the time of the catch."""

    def times(self, share: float) -> Effort:
        """Return the lattice with a share of the tries, at least one each."""
        return self._replace(tries=tuple(max(int(share * tries), 1) for tries in self.tries))


@dataclass
class Side:
    """A search from one end, which can be gone on with."""

    study: Study
    goals: Goals
    """Its goals."""
    lattice: JointLattice
    tree: Tree
    weight: float
    caught: Goals
    """The goals of the search from the start."""
    over: bool = False
    """True if all tries are spent."""

    def go_on(self, problem: SpatialProblem, tries: int) -> Way | None:
        """Look at so many moves more, or until the deadline: the way to a catch, if any."""
        study, tree, state = self.study, self.tree, -1
        ends, way = np.zeros(2), new_way(study.goal.size)
        while state < 0 and tries > 0 and not self.over:
            if problem.over:
                return None
            most = problem.slices(SLICE, tries)
            state, goal, left = search(
                study, self.lattice, self.goals, tree, most, NEVER, self.weight, ends
            )
            self.over = state < 0 and left > 0
            tries, problem.nodes = tries - most + left, problem.nodes + most - left
        if state < 0:
            return None
        if study.backward:
            whole = trace_back(study, self.caught, tree, state, ends, way)
        else:
            whole = trace(study, self.goals, tree, state, goal, ends, way)
        return way if whole else None


def from_start(study: Study, goals: Goals, effort: Effort) -> Side:
    """The search from the start to the goals."""
    lattice = joint_lattice(study.scene, effort.nodes)
    tree = new_tree(int(lattice.counts.prod()), study.goal.size, sum(effort.tries))
    side = Side(study, goals, lattice, tree, effort.weight, goals)
    side.over = not plant(study, lattice, goals, tree, NEVER, effort.weight)
    return side


def from_goals(study: Study, goals: Goals, effort: Effort) -> Side:
    """The search from the goals to the start, in time that runs backwards."""
    back = study._replace(scene=reversed_scene(study.scene), backward=True)
    lattice, home = joint_lattice(back.scene, effort.nodes), goal_at_start(back)
    tree = new_tree(
        int(lattice.counts.prod()), study.goal.size, sum(effort.tries) + int(goals.size[0])
    )
    plant_goals(back, lattice, goals, home, tree, effort.weight)
    return Side(back, home, lattice, tree, effort.weight, goals)


def two_sided(problem: SpatialProblem, study: Study, goals: Goals, effort: Effort) -> Way | None:
    """The way that is found first, if any is before the deadline."""
    if goals.size[0] == 0:
        return None
    sides: list[Side] = []
    for tries in effort.tries:
        for k, begun in enumerate((from_start, from_goals)):
            if problem.over:
                return None
            if k == len(sides):
                sides.append(begun(study, goals, effort))
            way = sides[k].go_on(problem, tries)
            if way is not None or sides[k].over:
                return way
    return None
