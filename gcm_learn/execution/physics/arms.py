"""Arms with mass side by side, told and paid as the kinematic ones in space are."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

from gcm_learn.arms import JOINTS
from gcm_learn.arms.spatial_limb import limb_at
from gcm_learn.compiled import njit
from gcm_learn.execution.batch import Batch
from gcm_learn.execution.physics.model import STEP
from gcm_learn.execution.physics.plant import PhysicalPlant
from gcm_learn.execution.physics.pool import PhysicalPool
from gcm_learn.execution.settings import PhysicalSettings
from gcm_learn.execution.space.meeting import way_to_go
from gcm_learn.execution.space.observation import AIM, EXTREME, observe_in_space
from gcm_learn.execution.space.plant import observe_all
from gcm_learn.execution.space.world import (
    HORIZON,
    SpatialOptions,
    SpatialState,
    SpatialWorld,
    view_in,
    views_for,
)
from gcm_learn.execution.stepping import GUIDE, pay
from gcm_learn.execution.world import LATE, RUNNING, Told

KEPT = 256
"""Plants that wait for their situations to come again, at most; about a megabyte each."""


class PhysicalArms(Batch):
    """Arms in MuJoCo, each a `PhysicalPlant`.

    Parameters
    ----------
    pool : PhysicalPool
    count : int
    settings : PhysicalSettings
    """

    commands = JOINTS

    def __init__(self, pool: PhysicalPool, count: int, settings: PhysicalSettings) -> None:
        self.pool, self.settings = pool, settings
        super().__init__(count, settings.width, 1)
        self.state = SpatialState(
            np.zeros(count, np.int64), np.zeros((count, 8)), np.zeros((count, 3)), np.zeros(count)
        )
        self.plants: dict[int, PhysicalPlant] = {}
        """Of the arms that were put somewhere."""
        self._idle: dict[int, PhysicalPlant] = {}  # by their situations, the oldest first
        self._arms, self._options = tuple(self.state), settings.options
        self._told, self._world = tuple(self.told), tuple(pool.world)
        self._before = np.zeros(count)
        self._steps = round(settings.dt / STEP)
        self._pushed = settings.control == "torque"

    @property
    def bounds(self) -> np.ndarray:
        """As `Batch` says."""
        return np.full(self.settings.width, EXTREME, np.float32)

    @property
    def posture(self) -> np.ndarray:
        """Joints [rad] and their rates [rad/s] (count, 8)."""
        return self.state.posture

    def put(self, arms: np.ndarray, places: np.ndarray) -> None:
        """As `Batch` says."""
        state, self._world = self.state, tuple(self.pool.world)  # the pool may be another now
        state.place[arms], state.time[arms] = places, 0.0
        for e, s in zip(arms.tolist(), np.asarray(places).tolist(), strict=True):
            plant = self._take(e, s)
            state.posture[e, :JOINTS], state.posture[e, JOINTS:] = plant.joints, plant.rates
        observe_all(self._world, self._arms, arms, self._options, self.observations)
        self._tell_torques(arms.tolist())

    def _take(self, e: int, s: int) -> PhysicalPlant:
        """The plant of situation s, for arm e, which lays its old one down for the next to come."""
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
        """All but the threads and what is idle."""
        return {**super().__getstate__(), "_idle": {}}

    def hold(self, arms: np.ndarray) -> None:
        """As `Batch` says."""
        self.state.time[arms] = self.pool.world.limits[self.state.place[arms], HORIZON]

    def _play(self, actions: np.ndarray, first: int, last: int) -> None:
        since, wanted = self.state.time.copy(), np.clip(actions, -1.0, 1.0)
        if self.settings.weights.guide != 0.0:
            _ways_to_go(self._world, self._arms, self._before)
        for e in range(first, last):
            self.told.outcomes[e] = self._step(e, wanted[e])
        _settle(self._world, self._arms, self._options, self._told, since, self._before)
        self._tell_torques(range(first, last))

    def _step(self, e: int, command: np.ndarray) -> int:
        """Move arm e on by a step: the outcome; the state is that at a catch or a touch."""
        plant, state = self.plants[e], self.state
        horizon = plant.situation.horizon
        if state.time[e] >= horizon:  # it is held
            return LATE
        if plant.outcome == RUNNING:
            until = (plant.steps + self._steps) * STEP
            if self._pushed:
                plant.push(command * plant.strongest, until)
            else:
                plant.turn(command * plant.fastest, until)
        last = plant.ended
        state.posture[e, :JOINTS] = plant.joints_log[last]
        state.posture[e, JOINTS:] = plant.rates_log[last]
        state.time[e] = horizon if plant.outcome == LATE else min(last * STEP, horizon)
        return plant.outcome

    def _tell_torques(self, arms: Iterable[int]) -> None:
        """Write what motors have to know into the ends of observations, if they are pushed."""
        if not self._pushed:
            return
        for e in arms:
            plant, row = self.plants[e], self.observations[e]
            joints, rates = np.split(self.state.posture[e], 2)
            holding = plant.motors.holding(joints)
            servo = plant.motors.kd * (row[AIM : AIM + JOINTS] * plant.fastest - rates)
            row[-2 * JOINTS : -JOINTS] = np.clip(holding / plant.strongest, -EXTREME, EXTREME)
            row[-JOINTS:] = np.clip((holding + servo) / plant.strongest, -1.0, 1.0)


@njit(nogil=True)
def _ways_to_go(world, state, out):
    """Write the guide's potential of every arm."""
    worlds, states = SpatialWorld(*world), SpatialState(*state)
    room = views_for(worlds, states, 0, states.place.size)
    for e in range(states.place.size):
        view = view_in(worlds, states.place[e], room)
        out[e] = way_to_go(view, states.time[e], states.posture, e)


@njit(nogil=True)
def _settle(world, state, options, told, since, before):
    """Pay every arm for the step that it has made since `since` [s], and tell it where it is."""
    worlds, states, how = SpatialWorld(*world), SpatialState(*state), SpatialOptions(*options)
    out = Told(*told)
    room = views_for(worlds, states, 0, states.place.size)
    for e in range(states.place.size):
        s, time = states.place[e], states.time[e]
        view, outcome, after = view_in(worlds, s, room), out.outcomes[e], 0.0
        if how.weights[GUIDE] != 0.0 and outcome == RUNNING:
            after = way_to_go(view, time, states.posture, e)
        share = (time - since[e]) / worlds.limits[s, HORIZON]
        pay(out, e, outcome, share, how.weights, before[e] - how.discount * after)
        row = out.observations[e]
        observe_in_space(view, time, states.posture, e, how, row)
        _, _, _, x, y, z = limb_at(view.scene.limb, view.joints[0])
        states.hand[e, 0], states.hand[e, 1], states.hand[e, 2] = x, y, z
