"""Memories that are replayed instead of bent."""

from __future__ import annotations

import numpy as np

from gcm_learn.planners.completion import Problem, attempt_of, checked, first_catch_on, timed
from gcm_learn.recall import Waypoints, path_of

RIM = 1e-3  # distance that hands keep from the rims of the ring [forearm lengths]


def replayed(problem: Problem, trace: Waypoints, moved: bool) -> bool:
    """Whether a remembered path catches in a canonical situation without being bent.

    Its directions are turned to the hand's anyhow, for situations are canonical. If `moved`, it is
    shifted so that it starts at the hand; else the hand goes straight to its start first. Times are
    kept but where the arm is too slow for them, and it ends where a target first is within grasp.
    """
    arm = problem.situation.arm
    time, hand = path_of(trace, arm)
    if moved:
        hand = hand + (np.asarray(arm.hand) - hand[0])
    else:
        late = float(np.hypot(*(hand[0] - arm.hand))) / arm.max_hand_speed
        time, hand = np.concatenate([[0.0], time + late]), np.vstack([arm.hand, hand])
        if late < 1e-6:
            time, hand = time[1:] - time[1], hand[1:]
    radius = np.maximum(np.hypot(*hand.T), 1e-9)
    inside = np.clip(radius, arm.inner_reach + RIM, arm.reach - RIM)
    hand = hand * (inside / radius)[:, None]
    hand[0] = arm.hand
    time, hand = timed(arm, time, hand)
    t, body = first_catch_on(problem, time, hand)
    if body < 0 or t > problem.situation.horizon:
        return False
    k = int(np.searchsorted(time, t, side="left"))
    end = [np.interp(t, time, hand[:, a]) for a in (0, 1)]
    attempt = attempt_of(problem, np.append(time[:k], t), np.vstack([hand[:k], [end]]), body)
    return checked(problem, attempt)[0] is not None
