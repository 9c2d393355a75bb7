"""A kinematic arm that follows trajectories exactly, judged at every instant."""

from __future__ import annotations

from gcm_learn.execution.arena.kernels.world import CAUGHT, RUNNING
from gcm_learn.execution.arena.wanted import Catch, wanted_of, without
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
    most : int, optional
        Number of catches that are enough, see `wanted_of`.
    """

    def __init__(self, situation: AnySituation, most: int | None = None) -> None:
        self.situation, self.wanted = situation, wanted_of(situation, most)
        self.time = 0.0
        self.arm = situation.arm
        """As it stands and moves at that time."""
        self.outcome = RUNNING
        self.catches: list[Catch] = []
        """Targets that were caught, in order."""
        self._lead = LEADS.of(situation)
        self._left = situation
        self._events = self._lead.events(pack(situation))

    @property
    def catch_time(self) -> float | None:
        """Time of the last catch of an episode that is a success [s]."""
        return self.catches[-1].time if self.outcome == CAUGHT else None

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
        while self.outcome == RUNNING and end > self.time:
            outcome, self.time, body = self._events.first(trajectory, self.time, end)
            self.arm = self._lead.led(self.arm, trajectory, self.time)
            if outcome == CAUGHT:
                self.catches.append(Catch(self._left.bodies[body].name, self.time))
                if len(self.catches) < self.wanted.most:
                    self._leave_out(self.catches[-1])
                    continue
            self.outcome = outcome
        if self.outcome == RUNNING and self.time >= horizon:
            self.outcome = self.wanted.at_horizon(len(self.catches))

    def _leave_out(self, catch: Catch) -> None:
        """Go on without a target that was caught."""
        self._left = without(self._left, [catch])
        self._events = self._lead.events(pack(self._left))
