"""A kinematic arm that follows trajectories exactly, judged at every instant."""

from __future__ import annotations

from gcm_learn.errors import ArenaError
from gcm_learn.execution.arena.kernels.world import CAUGHT, LATE, RUNNING
from gcm_learn.execution.loop.kinds import LEADS
from gcm_learn.motion import Movement
from gcm_learn.scene import pack
from gcm_learn.situation import AnySituation

JUMP = 1e-6  # distance of arm and trajectory where it is taken up [rad, or forearm lengths]


class ExactPlant:
    """A kinematic arm in its world: a `LedPlant`.

    A catch is the first moment at which a target is within grasp, a collision the first one at
    which the limb touches an obstacle.

    Parameters
    ----------
    situation : Situation
        With one catch.
    """

    def __init__(self, situation: AnySituation) -> None:
        if situation.catch != "any":
            raise ArenaError(f"catch: must be 'any' in the closed loop (got {situation.catch!r})")
        self.situation = situation
        self.time = 0.0
        self.arm = situation.arm
        """As it stands and moves at that time."""
        self.outcome = RUNNING
        self.catch_time: float | None = None
        self._lead = LEADS.of(situation)
        self._events = self._lead.events(pack(situation))

    def follow(self, trajectory: Movement, until: float) -> None:
        """Let the world go on until a time, or until the episode is over.

        Parameters
        ----------
        trajectory : Movement
            On the world's clock; it is now where the arm is.
        until : float
            [s]
        """
        off = self._lead.gap(self.arm, trajectory, self.time)
        if off > JUMP:
            raise ValueError(f"trajectory: is {off:.2g} away from the arm at {self.time:g} s")
        horizon = self.situation.horizon
        end = min(until, horizon)
        if self.outcome == RUNNING and end > self.time:
            self.outcome, self.time = self._events.first(trajectory, self.time, end)
            self.arm = self._lead.led(self.arm, trajectory, self.time)
            self.catch_time = self.time if self.outcome == CAUGHT else None
        if self.outcome == RUNNING and self.time >= horizon:
            self.outcome = LATE
