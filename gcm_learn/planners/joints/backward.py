"""Search from the goals to the start, through a scene whose time runs backwards.

A place that is hard to enter is easy to leave.  If goals lie behind a gap, a search from there
finds the gap at once.  If they are shut in, it ends soon.
"""

from __future__ import annotations

import numpy as np

from gcm_learn.arms.limbs import dof
from gcm_learn.charts.joint_lattice import nearest, posture_of
from gcm_learn.compiled import njit
from gcm_learn.planners.joints.goals import Goals
from gcm_learn.planners.joints.lattice_search import note, queue, span_of, spans_at
from gcm_learn.planners.joints.moves import Study, turning_time
from gcm_learn.planners.joints.ways import MOST, write
from gcm_learn.scene import Scene, reverse_pieces
from gcm_learn.scene.bodies import ACCELERATION, POSITION, SPIN, SWING, TURN, VELOCITY, pose_at


def reversed_scene(scene: Scene) -> Scene:
    """The scene in which at t happens what happens in this one at horizon - t."""
    bodies, end = scene.bodies, scene.limits.horizon
    rows, poses = bodies.rows.copy(), np.zeros((bodies.rows.shape[0], 12))
    for b, row in enumerate(rows):
        if row[SWING] >= 0.0:
            continue
        poses[b, 3:] = row[TURN : TURN + 9]  # balls stay as they are
        pose_at(bodies, b, end, poses)
        row[POSITION : POSITION + 3], row[TURN : TURN + 9] = poses[b, :3], poses[b, 3:]
        speed = row[VELOCITY : VELOCITY + 3] + end * row[ACCELERATION : ACCELERATION + 3]
        row[VELOCITY : VELOCITY + 3], row[SPIN : SPIN + 3] = -speed, -row[SPIN : SPIN + 3]
    angles = bodies.angles[:, ::-1] * np.array([1.0, -1.0])
    # the table has one step more than the horizon: its first entry is before t = 0
    last = angles[:, -1:] + bodies.angle_step * angles[:, -1:, ::-1] * np.array([1.0, 0.0])
    angles = np.ascontiguousarray(np.concatenate([angles[:, 1:], last], axis=1))
    reverse_pieces(bodies, rows, angles, end)
    return scene._replace(bodies=bodies._replace(rows=rows, angles=angles))


def goal_at_start(study: Study) -> Goals:
    """The start as the goal of a search backwards: to be met at the end of time."""
    limb, end = study.scene.limb, study.scene.limits.horizon
    return Goals(
        np.array([end]), limb.start[None].copy(), np.zeros(1, np.int64), np.ones(1, np.int64)
    )


@njit
def plant_goals(study, lattice, goals, home, tree, weight):
    """Begin a search backwards: place k is goal k, and moves to the nodes about it are queued."""
    places, posture, end = tree.places, study.posture, study.scene.limits.horizon
    count = goals.size[0]
    places.size[0] = count
    for k in range(count):
        for j in range(dof(study.scene.limb)):
            places.joints[k, j] = goals.joints[k, j]
        spans_at(study, places, k)
    for k in range(count):
        time = end - goals.time[k]
        span = span_of(places, k, time)
        if span < 0 or places.spans[k, span, 0] > time:
            continue
        state = note(tree, k, span, -1, 0.0, time)
        for corner in range(1 << dof(study.scene.limb)):
            node = nearest(lattice, places.joints[k], corner)
            if node < 0:
                continue
            posture_of(lattice, node, posture)
            took = turning_time(study.scene.limits.joint_speed, places.joints[k], posture)
            trial = (node, state, state, time, time + took, 0)
            queue(study, lattice, home, tree, trial, 1e300, weight)


@njit(_nrt=False)
def trace_back(study, goals, tree, state, ends, way):
    """Write the way from the start through a state to a goal; return whether it fits.

    Parameters
    ----------
    ends : (2,) ndarray
        When the move from the state to the start begins and ends, in time that runs backwards [s].
    """
    places, states, end = tree.places, tree.states, study.scene.limits.horizon
    write(way, 0, study.scene.limb.start, 0.0, end - ends[1])
    k, s, came = 1, state, end - ends[0]
    while s >= 0:
        if k == MOST:
            return False
        write(way, k, places.joints[states.place[s]], came, end - states.time[s])
        k, came, last = k + 1, end - states.left[s], states.place[s]
        s = states.via[s]
    way.left[k - 1] = goals.time[last]
    way.body[0] = goals.body[last]
    return True
