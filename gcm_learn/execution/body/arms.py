"""Batches of arms with mass, with the observations and rewards of kinematic arms."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from gcm_learn.errors import ArenaError
from gcm_learn.execution.arena.batch import Batch
from gcm_learn.execution.arena.kernels.joints.observation import settle
from gcm_learn.execution.arena.kernels.world import EXTREME, LATE, MOST, RUNNING
from gcm_learn.execution.arena.pool import Pool, of_one_kind
from gcm_learn.execution.arena.settings import ChainSettings, SpatialSettings
from gcm_learn.execution.body.model import STEP
from gcm_learn.execution.body.motors import FAINT
from gcm_learn.execution.body.plant import PhysicalPlant
from gcm_learn.motion import Movement


@dataclass(frozen=True)
class PhysicalSettings(SpatialSettings):
    """Settings of spatial arms with mass, with the defaults of ``CatchArmPhysics-v0``."""

    control: Literal["joint", "torque"] = "joint"
    """Actions are rates of the joints, which motors servo, or torques."""

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.control not in ("joint", "torque"):
            raise ArenaError(f"control: {self.control!r} is not one of joint, torque")
        if abs(self.dt / STEP - round(self.dt / STEP)) > 1e-9:
            raise ArenaError(f"dt: must be whole steps of physics, of {STEP} s (got {self.dt!r})")

    @property
    def pushed(self) -> bool:
        """True if actions are torques."""
        return self.control == "torque"

    @property
    def width(self) -> int:
        """Length of an observation."""
        return super().width + (2 * self.commands if self.pushed else 0)

    @property
    def straight(self) -> int:
        """Index of the command that leads straight to the target."""
        return self.width - self.commands if self.pushed else super().straight

    def prepared(self, pool: Pool) -> Pool:
        """Return the pool, whether or not its arms can stop in time; refuse arms without mass."""
        of_one_kind(pool.situations[:1], self.kind)
        if not pool.bodies:
            raise ArenaError("situations: the arms of the pool have no bodies")
        return pool


@dataclass(frozen=True)
class ChainPhysicalSettings(ChainSettings, PhysicalSettings):
    """Settings of chains with mass, with the defaults of ``CatchChainPhysics-v0``."""


KEPT = 256
"""Plants that wait for their situations to come again, at most; about a megabyte each."""


class PhysicalArms(Batch):
    """Arms in MuJoCo, each a `PhysicalPlant`.

    Parameters
    ----------
    pool : Pool
        With bodies.
    count : int
    settings : PhysicalSettings
    threads : int
        Must be 1.
    """

    settings: PhysicalSettings

    def __init__(
        self, pool: Pool, count: int, settings: PhysicalSettings, threads: int = 1
    ) -> None:
        if threads != 1:
            raise ArenaError("threads: arms with mass move one after the other")
        super().__init__(pool, count, settings)
        self.plants: dict[int, PhysicalPlant] = {}
        """Of the arms that were put into a situation."""
        self._idle: dict[int, PhysicalPlant] = {}  # by their situations, the oldest first
        self._steps = round(settings.dt / STEP)

    def put(self, arms: np.ndarray, places: np.ndarray) -> None:
        """As `Batch` says."""
        super().put(arms, places)
        self._tell_torques(arms.tolist())

    def way(self, e: int, time: np.ndarray, posture: np.ndarray) -> Movement:
        """As `Batch` says; linear between steps of the physics."""
        return self.plants[e].movement

    def _begin(self, arms: np.ndarray, places: np.ndarray) -> None:
        posture, dof = self.state.posture, self.settings.commands
        for e, s in zip(arms.tolist(), np.asarray(places).tolist(), strict=True):
            plant = self._take(e, s)
            posture[e, :dof], posture[e, dof:] = plant.joints, plant.rates

    def _take(self, e: int, s: int) -> PhysicalPlant:
        """Return a plant of situation s for arm e; keep the arm's old plant for later use."""
        situation, old = self.pool.situations[s], self.plants.pop(e, None)
        if old is not None:
            self._idle[id(old.situation)] = old
            if len(self._idle) > KEPT:
                self._idle.pop(next(iter(self._idle)))
        plant = self._idle.pop(id(situation), None)
        if plant is None:
            plant = PhysicalPlant(situation, self.pool.bodies[s])
        else:
            plant.begin()
        self.plants[e] = plant
        return plant

    def __getstate__(self) -> dict[str, Any]:
        """Return everything but the threads and the plants that wait."""
        return {**super().__getstate__(), "_idle": {}}

    def _play(self, actions: np.ndarray, first: int, last: int) -> None:
        since, wanted = self.state.time.copy(), np.clip(actions, -1.0, 1.0)
        had = self._counts()
        before = self._ways()
        for e in range(first, last):
            self.told.outcomes[e] = self._step(e, wanted[e])
        running = self.told.outcomes == RUNNING
        after = np.where(running, self._ways(), 0.0)
        shares = (self.state.time - since) / self.pool.horizons[self.state.place]
        nearer = before - self.settings.discount * after
        most = self.pool.world.wanted[self.state.place, MOST]
        catches = (self._counts() - had) / most
        settle(self._told, catches, self.settings.weighted, shares, nearer)
        everyone = np.arange(self.count)
        self._kernels.observe(self._world, self._arms, everyone, self._options, self.observations)
        self._tell_torques(range(first, last))

    def _counts(self) -> np.ndarray:
        """Return the numbers of targets that were caught (count,)."""
        return np.count_nonzero(self.state.caught >= 0.0, axis=1)

    def _ways(self) -> np.ndarray:
        """Return the guide's potential of every arm (count,); 0 without a guide."""
        out = np.zeros(self.count)
        if self.settings.weights.guide != 0.0:
            self._kernels.ways_to_go(self._world, self._arms, out)
        return out

    def _step(self, e: int, command: np.ndarray) -> int:
        """Move arm e on by a step: the outcome; the state is that at a catch or a touch."""
        plant, state, dof = self.plants[e], self.state, len(command)
        horizon = plant.situation.horizon
        if state.time[e] >= horizon:  # it is held
            return LATE
        if plant.outcome == RUNNING:
            until = (plant.steps + self._steps) * STEP
            if self.settings.pushed:
                plant.push(command * plant.strongest, until)
            else:
                plant.turn(command * plant.fastest, until)
        last = plant.ended
        state.posture[e, :dof] = plant.joints_log[last]
        state.posture[e, dof:] = plant.rates_log[last]
        state.time[e] = horizon if plant.outcome == LATE else min(last * STEP, horizon)
        for catch in plant.catches:
            state.caught[e, plant.number_of(catch.body)] = catch.time
        return plant.outcome

    def _tell_torques(self, arms: Iterable[int]) -> None:
        """Write holding and servo torques at the ends of observations, if actions are torques."""
        if not self.settings.pushed:
            return
        aim, dof = self.settings.layout.straight, self.settings.commands
        for e in arms:
            plant, row = self.plants[e], self.observations[e]
            joints, rates = np.split(self.state.posture[e], 2)
            holding, most = plant.motors.holding(joints), np.maximum(plant.strongest, FAINT)
            servo = plant.motors.kd * (row[aim : aim + dof] * plant.fastest - rates)
            row[-2 * dof : -dof] = np.clip(holding / most, -EXTREME, EXTREME)
            row[-dof:] = np.clip((holding + servo) / most, -1.0, 1.0)
