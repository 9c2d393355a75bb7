"""Arms of two bones as Gymnasium environments: one arm, one situation an episode."""

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


class CatchArmPhysics(OneArm):
    """A four-joint arm with masses and motors, in MuJoCo, that catches among moving obstacles.

    `CatchArm3D` with a body: the same situations, numbers, rewards and outcomes, another plant
    (`execution.PhysicalPlant`). ``gymnasium.make("gcm_learn:CatchArmPhysics-v0")`` makes it (extra
    ``sim``); arguments of the constructor go to `make`.

    **Action**, in the box of `CatchArm3D`, for the next `dt` seconds. With `control` "joint": rates
    of the joints, 1 being the joint's greatest speed, to which motors servo them, the arm's weight
    being held. With "torque": torques, 1 being the motor's greatest; weight is not held. A
    motor pushes its joint up to its greatest speed only. Nothing keeps the limit of the hand's
    speed that a situation may have: that is for planners.

    **Observation**, ``Box(-10, 10, (65 + 20 slots,))``, 145 numbers by default, is that of
    `CatchArm3D`, number by number, and with "torque" 8 more. Obstacles are as seen by the package,
    not by MuJoCo. Two groups come out otherwise here:

    ===== ============================================================== ============== =======
    from  the arm                                                        range          unit
    ===== ============================================================== ============== =======
    4     rates of the joints (4): what is pushed may be too fast        -10 ... 10     speed
    26    how long joints take to full speed (4), never 0: by the        0 ... 10       time
          motors, where the situation has no limits
          (`motor_accelerations`)
    ===== ============================================================== ============== =======

    With "torque", at the very end:

    ===== ============================================================== ============== =======
    -8    torques that hold the arm's weight here (4)                    -10 ... 10     action
    -4    the action that servos the joints to the rates at 61 (4)       -1 ... 1       action
    ===== ============================================================== ============== =======

    **End.** A catch or a touch terminates the episode, the horizon truncates it. In a catch the
    hand is within grasp of a target, by the package's distance at a step of the physics (0.002 s);
    continuous time is not verified. A touch is MuJoCo's first contact of limb and obstacle.

    **Reward** and **info** are as in `CatchArm3D`: the sum of ``info["reward_terms"]`` (catch,
    touch, haste, guide); `time`, `hand`, `outcome`, `caught` and at the end `is_success`.

    **Reset**: ``reset(seed=...)`` draws from the pool; ``reset(options={"situation": s})`` starts
    in that situation, ``options={"index": k}`` in the pool's k-th.

    Parameters
    ----------
    situations : str, Path, Family, Situation or sequence of Situation
        As `CatchArm3D` has them. Arms need a body; of families only arms are drawn that have one.
    render_mode : {"rgb_array", "human"}, optional
        Neither needs a graphics card.
    pool : int
        How many situations are drawn or read.
    pool_seed : int
        Of what is drawn.
    body : ArmBody, str or Path, optional
        Of all arms: a body, its file, or the name of one that comes with the package; by default
        the one of these that fits.
    settings : PhysicalSettings or mapping, optional
        Fields of `PhysicalSettings`, and of `Weights` under "weights".

    Raises
    ------
    PhysicsError
        If an arm has no body.
    MissingExtraError
        Without MuJoCo.
    """

    arena = ARENAS["CatchArmPhysics-v0"]


class CatchArm3D(OneArm):
    """A four-joint arm in space that catches a moving target among moving obstacles.

    An episode is one situation (`gcm_learn.Situation`) with a spatial arm, its bodies moving by
    their laws whatever the arm does. ``gymnasium.make("gcm_learn:CatchArm3D-v0")`` makes it;
    arguments of the constructor go to `make`. Importing `gcm_learn` registers it.

    **Action**, ``Box(-1, 1, (4,))``: rates of the joints for the next `dt` seconds, 1 being the
    joint's greatest speed. Ranges end a joint's turn. Under a limit of the hand's speed, faster
    actions are scaled down. Under limits of acceleration the rates are reached at the end of
    the step, as nearly as possible. They leave the joints the way to stop before their ranges end,
    within the hand's limit.

    **Observation**, ``Box(-10, 10, (65 + 20 slots,))``, 145 numbers by default. Vectors are in the
    frame of the arm's base, the shoulder at the origin. Unit of lengths: the arm's reach, both
    bones in line. Unit of velocities: the fastest that the hand can be, by its own limit or by what
    the joints allow at most. Unit of times: that in which such a hand makes a reach. Numbers
    are cut at 10.

    ===== ============================================================== ============== =======
    from  the arm                                                        range          unit
    ===== ============================================================== ============== =======
    0     joints (4)                                                     -10 ... 10     rad
    4     their rates (4)                                                -1 ... 1       speed
    8     hand (3)                                                       -1 ... 1       reach
    11    elbow (3)                                                      -1 ... 1       reach
    14    from the lowest angles of the joints' ranges (4)               0 ... 10       rad
    18    to the highest (4)                                             0 ... 10       rad
    22    how far the joints turn in a unit of time at most (4)          0 ... 10       rad
    26    how long they take to full speed, 0 without limits (4)         0 ... 10       time
    30    length of the upper arm                                        0 ... 1        reach
    31    thickness, grasp                                               -10 ... 10     reach
    33    time left, time of a step                                      0 ... 10       time
    35    the target that can be met first: centre, from the hand (3)    -10 ... 10     reach
    38    its velocity (3)                                               -10 ... 10     speed
    41    its acceleration (3)                                           -10 ... 10     s. / t.
    44    its centre after 0.5, 1 and 2 units of time, but not after     -10 ... 10     reach
          the horizon, from the hand as it is now (3 x 3)
    53    radius of its ball                                             0 ... 10       reach
    54    distance that is missing for a catch, below 0 inside           -10 ... 10     reach
    55    whether the hand can meet it in time, as it seems              0 or 1
    56    where, from the hand (3); at the horizon, if it cannot         -10 ... 10     reach
    59    when                                                           0 ... 10       time
    60    how far that is from the shoulder                              0 ... 10       reach
    61    the action that takes the hand straight there at full speed    -1 ... 1       action
          (4): damped least squares, joints at an end left out
    65    `slots` obstacles, those nearest to the limb first, 20 each:
    +0    there is one (else all are 0)                                  0 or 1
    +1    the limb's nearest point (3)                                   -1 ... 1       reach
    +4    from there to the obstacle's nearest point (3)                 -10 ... 10     reach
    +7    distance before it counts as a touch                           -10 ... 10     reach
    +8    velocity of its nearest point, seen from the limb's (3)        -10 ... 10     speed
    +11   its centre, from the hand (3)                                  -10 ... 10     reach
    +14   radii of the balls about its centre that hold it, and that     0 ... 10       reach
          it holds
    +16   distance to the limb if that rests, after 0.5 and 1 units of   -10 ... 10     reach
          time, but not after the horizon
    +18   the same if the limb follows the action at 61 meanwhile        -10 ... 10     reach
    end   with ``settings={"fan": True}``, a frame of actions, four unit -1 ... 1       action
          vectors: the action at 61, what moves the elbow and not the
          hand, what moves the hand outward, what is orthogonal (4 x 4)
    end   then of 30 actions (see `fan.py` among kernels of joints: that at 61,
          turned towards the others, half of it, rest), 3 each:
    +0    how long the limb is free on it, 1.2 are looked at             0 ... 1.2      time
    +1    least clearance until then, 0 if it touches                    0 ... 0.15     reach
    +2    distance that is missing for a catch then, 1 at most           -10 ... 1      reach
    ===== ============================================================== ============== =======

    Distances above half a reach are to the ball that holds an obstacle. Everything is a
    function of situation, time, joints and rates (`execution.arena.kernels.joints.observation`).

    **End.** A catch or a touch terminates the episode, the horizon truncates it. Both are found by
    the functions that verify plans, between steps too: a catch that is reported here is one that
    `gcm_learn.planners` would report. A situation that asks for `all` or `most` of its targets goes
    on until all are caught. A caught target is gone, and the target above is one that is left. At
    the horizon one catch makes a success of `most`, and terminates the episode.

    **Reward**, the sum of ``info["reward_terms"]``:

    ===== ================================================================================
    catch `weights.catch` at a catch; with several targets each pays its share
    touch minus `weights.touch` at a touch
    haste minus `weights.haste` for each horizon's time
    guide `weights.guide` times how much nearer the step brought the hand to where it can
          meet the target, in two reaches (potential-based)
    ===== ================================================================================

    **Info**: `reward_terms`; `time` [s]; `hand` (3), in the world; `outcome` (running, caught,
    touched or late); `caught`, the names of caught targets in order; at the end `is_success`.

    **Reset**: ``reset(seed=...)`` draws from the pool; ``reset(options={"situation": s})`` starts
    in that situation, ``options={"index": k}`` in the pool's k-th.

    Parameters
    ----------
    situations : str, Path, Family, Situation or sequence of Situation
        A family's name, a dataset's folder, a file, or situations, with spatial arms.
    render_mode : {"rgb_array", "human"}, optional
        Neither needs a graphics card.
    pool : int
        How many situations are drawn or read.
    pool_seed : int
        Of what is drawn.
    settings : SpatialSettings or mapping, optional
        Fields of `SpatialSettings`, and of `Weights` under "weights".
    """

    arena = ARENAS["CatchArm3D-v0"]
