"""The arm with mass as a Gymnasium environment: one arm, one situation an episode."""

from __future__ import annotations

from gcm_learn.envs.one_arm import OneArm
from gcm_learn.execution import ARENAS


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
