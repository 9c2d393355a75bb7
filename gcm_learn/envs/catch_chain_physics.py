"""A chain with mass as a Gymnasium environment: one arm, one situation an episode."""

from __future__ import annotations

from gcm_learn.envs.one_arm import OneArm
from gcm_learn.execution import ARENAS


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
