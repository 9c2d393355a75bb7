"""The planar arm as a Gymnasium environment: one arm, one situation an episode."""

from __future__ import annotations

from gcm_learn.envs.one_arm import OneArm
from gcm_learn.execution import ARENAS


class CatchArm(OneArm):
    """A two-joint arm that catches a moving target among moving obstacles.

    An episode is one situation (`gcm_learn.Situation`), its bodies moving by their laws whatever
    the arm does. ``gymnasium.make("gcm_learn:CatchArm-v0")`` makes it; arguments of the constructor
    go to `make`. Importing `gcm_learn` registers it.

    **Action**, ``Box(-1, 1, (2,))``: velocity for the next `dt` seconds.

    ======= ==================================================== ==========================
    control first, second number                                 1 means
    ======= ==================================================== ==========================
    hand    away from the shoulder, across (counter-clockwise)   the hand's greatest speed
    joint   shoulder, elbow                                      the joint's greatest speed
    ======= ==================================================== ==========================

    Actions longer than 1 are shortened to 1 (hand) or clipped (joint). The hand goes straight. It
    keeps the limits of planners: of its own speed and, if the situation has them, of the joints'.
    Moves out of the ring or through its hole are shortened. If the elbow is on the left, all is
    mirrored.

    **Observation**, ``Box(-10, 10, (27 + 20 slots,))``, 107 numbers by default. Lengths in
    forearms, velocities in hand speeds, times as the way that the hand can make in them; vectors in
    the frame in which the hand is now on the x axis and the elbow on the right.

    ===== ==============================================================================
    from  the arm
    ===== ==============================================================================
    0     distance of the hand from the shoulder
    1     length of the upper arm
    2-3   elbow
    4-5   thickness, grasp
    6-7   time left, time of a step
    8-9   slowness of shoulder and elbow, 0 without limits
    10    the target that can be met first: place relative to the hand (2), height above the plane
    13    its velocity (2), vertical speed, acceleration (2)
    18    radius of its ball, distance that is missing
    20    whether a straight line meets it in time, time until then
    22    where, relative to the hand (2), direction of that (2), distance from the shoulder
    27    `slots` obstacles, those that come nearest on the straight way first, 20 numbers each:
    +0    there is one (else all are 0)
    +1    place relative to the hand (2), height above the plane
    +4    velocity (2), vertical speed, acceleration (2)
    +9    radius of its ball
    +10   long axis as length and twice its angle (2), turning speed of its end
    +13   distance to the limb now, least distance on the straight way, when (0 to 1), touches then
    +17   distance to the limb if that rests, after 0.3 and 0.6 forearms' time
    +19   its distance from the shoulder then
    end   with ``fan=True``, for 24 directions, the first straight to the meeting, the others
          counter-clockwise, and for resting: how far the hand can go before the limb touches (at
          most 0.9), and how near it comes until then (at most 0.5)
    ===== ==============================================================================

    With ``embedding=True`` there follows how the encoder in the folder of models embeds the
    situation, by what is known at t = 0 (within 100, the same during an episode). `WithMap` of
    `gcm_learn.envs` adds the picture of the situation's cognitive map.

    **End.** A catch or a touch terminates the episode, the horizon truncates it. Both are
    found by the functions that verify plans, between steps too: a catch that is reported here is
    one that `gcm_learn.planners` would report.

    **Reward**, the sum of ``info["reward_terms"]``:

    ===== ================================================================================
    catch `weights.catch` at a catch
    touch minus `weights.touch` at a touch
    haste minus `weights.haste` for each horizon's time
    guide `weights.guide` times how much nearer the step brought the hand, by a map's time to go
          (potential-based; needs maps, so making or resetting takes a few ms a situation)
    ===== ================================================================================

    **Info**: `reward_terms`; `time` [s]; `hand` (2), in the situation's own coordinates; `outcome`
    (running, caught, touched or late); `caught`, the target's name after a catch; at the end
    `is_success`.

    **Reset**: ``reset(seed=...)`` draws from the pool; ``reset(options={"situation": s})`` starts
    in that situation, ``options={"index": k}`` in the pool's k-th.

    Parameters
    ----------
    situations : str, Path, Family, Situation or sequence of Situation
        A family's name, a dataset's folder, a file, or situations.
    render_mode : {"rgb_array", "human"}, optional
    pool : int
        How many situations are drawn or read.
    pool_seed : int
        Of what is drawn.
    settings : Settings or mapping, optional
        Fields of `Settings`, and of `Weights` under "weights".
    control : {"hand", "joint"}
    fan, embedding : bool
        These three for short.
    """

    arena = ARENAS["CatchArm-v0"]
