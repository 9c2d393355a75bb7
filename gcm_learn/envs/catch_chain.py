"""Chains as Gymnasium environments: one arm, one situation an episode."""

from __future__ import annotations

from gcm_learn.envs.one_arm import OneArm
from gcm_learn.execution import ARENAS


class CatchChain(OneArm):
    """A serial arm of n joints that catches a moving target among moving obstacles.

    An episode is one situation (`gcm_learn.Situation`) with a chain. Its bodies move by their laws
    whatever the arm does. ``gymnasium.make("gcm_learn:CatchChain-v0", arm="ur5")`` makes it.
    Arguments of the constructor go to `make`. Importing `gcm_learn` registers it.

    **Action**, ``Box(-1, 1, (n,))``: rates of the joints for the next `dt` seconds, 1 being the
    joint's greatest speed. Ranges, the limit of the hand's speed and limits of acceleration are
    kept as in `CatchArm3D`.

    **Observation**, ``Box(-10, 10, (7 n + 4 m + 41 + 20 slots,))`` for n joints and m links. A
    Panda has 7 joints and 9 links, so 206 numbers by default. Vectors are in the frame of the arm's
    base, its first frame at the origin. Unit of lengths: `Chain.reach`, a bound of the hand's
    distance. Unit of velocities: the limit of the hand's speed, or a typical greatest speed if that
    is less. It is the root of the sum of squares of what each joint alone gives the hand at most.
    In the unit of times such a hand makes a reach. Joints are in rad, or in lengths if they are
    prismatic. Numbers are cut at 10.

    ======== =========================================================== ============== =======
    from     the arm                                                     range          unit
    ======== =========================================================== ============== =======
    0        joints (n)                                                  -10 ... 10     rad
    n        their rates (n)                                             -1 ... 1       speed
    2n       hand (3)                                                    -1 ... 1       reach
    2n + 3   direction in which the hand reaches (3)                     -1 ... 1       1
    2n + 6   outer ends of the links, `to` in arm files (m x 3)          -1 ... 1       reach
    a        a = 2n + 3m + 6: from the lowest values of the joints (n)   0 ... 10       rad
    a + n    to the highest (n)                                          0 ... 10       rad
    a + 2n   how far the joints turn in a unit of time at most (n)       0 ... 10       rad
    a + 3n   how long they take to full speed, 0 without limits (n)      0 ... 10       time
    a + 4n   radii of the links (m)                                      0 ... 10       reach
    b        b = 6n + 4m + 6: distance before the arm touches itself,    -10 ... 10     reach
             10 without pairs that are checked
    b + 1    grasp                                                       0 ... 10       reach
    b + 2    time left, time of a step                                   0 ... 10       time
    c        c = 6n + 4m + 10: the target that can be met first, 26      as there
             numbers as those of `CatchArm3D` from 35 to 60
    c + 26   the action that takes the hand straight there at full       -1 ... 1       action
             speed (n): damped least squares, joints at an end left out
    d        d = c + 26 + n: whether the target has an approach          0 or 1
    d + 1    direction in which it has to be caught, 0 without (3)       -1 ... 1       1
    d + 4    angle of the hand to it beyond what is allowed, 0 without   -4 ... 4       rad
    d + 5    `slots` obstacles, those nearest to the limb first, 20      as there
             numbers each as those of `CatchArm3D` from 65 on; the
             limb's nearest point is on the axis of a link
    ======== =========================================================== ============== =======

    Links that ignore an obstacle do not count for it. Everything is a function of
    situation, time, joints and rates (`execution.arena.kernels.joints.observation`).

    **End.** A catch or a touch terminates the episode, the horizon truncates it. Links that overlap
    count as a touch, and a catch keeps the target's approach. Both are found by the functions that
    verify plans, between steps too: a catch that is reported here is one that `gcm_learn.planners`
    would report. With several targets an episode goes on as in `CatchArm3D`.

    **Reward**, **info** and **reset** are as in `CatchArm3D`: the sum of ``info["reward_terms"]``
    (catch, touch, haste, guide); `time`, `hand`, `outcome`, `caught` and at the end `is_success`.

    Parameters
    ----------
    situations : str, Path, Family, Situation or sequence of Situation
        A family's name, a dataset's folder, a file, or situations, with chains of as many joints
        and links as `arm`. Families that are named are drawn with `arm`.
    render_mode : {"rgb_array", "human"}, optional
        Neither needs a graphics card.
    arm : str or Path
        Name of an arm that ships, or an arm file; "panda" by default.
    pool : int
        Number of situations that are drawn or read.
    pool_seed : int
        Of the draws.
    settings : ChainSettings or mapping, optional
        Fields of `ChainSettings`, and of `Weights` under "weights".
    """

    arena = ARENAS["CatchChain-v0"]


class CatchChainPhysics(OneArm):
    """A serial arm with masses and motors, in MuJoCo, that catches among moving obstacles.

    `CatchChain` with a body: the same situations, numbers and rewards, moved by the plant of
    `CatchArmPhysics` (`execution.PhysicalPlant`).
    ``gymnasium.make("gcm_learn:CatchChainPhysics-v0", arm="ur5")`` makes it (extra ``sim``).
    Arguments of the constructor go to `make`.

    **Action**, ``Box(-1, 1, (n,))``, for the next `dt` seconds. With `control` "joint": rates of
    the joints, 1 being the joint's greatest speed, to which motors servo them, the arm's weight
    being held. With "torque": torques, 1 being the motor's greatest; weight is not held. A motor
    pushes its joint up to its greatest speed only. Nothing keeps the limit of the hand's speed
    that a situation may have: that is for planners.

    **Observation** is that of `CatchChain`, number by number, and with "torque" 2 n more. A Panda
    has 206 numbers, with "torque" 220. Two groups come out otherwise here: rates of the joints may
    be beyond 1, and times to full speed are never 0, as motors have limits. With "torque", at the
    very end:

    ===== ============================================================== ============== =======
    from  the arm                                                        range          unit
    ===== ============================================================== ============== =======
    -2n   torques that hold the arm's weight here (n)                    -10 ... 10     action
    -n    the action that servos the joints to the rates that lead       -1 ... 1       action
          straight to the target (n)
    ===== ============================================================== ============== =======

    **End.** A catch or a touch terminates the episode, the horizon truncates it. In a catch the
    hand is within grasp of a target and keeps its approach, at a step of the physics (0.002 s);
    continuous time is not verified. A touch is MuJoCo's first contact of a link with an obstacle
    that it does not ignore, or with another link of `self_collision`.

    **Reward**, **info** and **reset** are as in `CatchArm3D`: the sum of ``info["reward_terms"]``
    (catch, touch, haste, guide); `time`, `hand`, `outcome`, `caught` and at the end `is_success`.

    Parameters
    ----------
    situations : str, Path, Family, Situation or sequence of Situation
        As `CatchChain` has them.
    render_mode : {"rgb_array", "human"}, optional
        Neither needs a graphics card.
    arm : str or Path
        Name of an arm that ships, or an arm file; "panda" by default.
    pool : int
        Number of situations that are drawn or read.
    pool_seed : int
        Of the draws.
    body : ChainBody, str or Path, optional
        Of all arms: a body, its file, or the name of one that ships; by default that of the
        shipped arm with the same joints.
    settings : ChainPhysicalSettings or mapping, optional
        Fields of `ChainPhysicalSettings`, and of `Weights` under "weights".

    Raises
    ------
    PhysicsError
        If an arm has no body.
    MissingExtraError
        Without MuJoCo.
    """

    arena = ARENAS["CatchChainPhysics-v0"]
