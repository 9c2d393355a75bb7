"""Many arms as one Gymnasium vector environment; ended episodes begin anew within the step."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space

from gcm_learn import execution
from gcm_learn.envs.one_arm import POOL, box, commands, finite
from gcm_learn.errors import ArenaError


class ManyArms(VectorEnv[np.ndarray, np.ndarray, np.ndarray]):
    """Many arms of an arena as one environment; subclasses name the arena and describe it.

    Parameters
    ----------
    num_envs : int
        Number of arms.
    threads : int
        Threads that share the arms among them.
    situations, pool, pool_seed, body, settings, control, fan, embedding, arm
        As `OneArm` has them.
    render_mode : None
        Many arms are not drawn.
    """

    arena: ClassVar[execution.Arena]
    metadata: ClassVar[dict[str, Any]] = {"autoreset_mode": AutoresetMode.SAME_STEP}

    def __init__(
        self,
        num_envs: int = 1,
        situations: execution.Source | execution.Pool | None = None,
        *,
        pool: int = POOL,
        pool_seed: int = 0,
        body: execution.AnyBody = None,
        settings: execution.ArenaSettings | Mapping[str, Any] | None = None,
        control: str | None = None,
        fan: bool | None = None,
        embedding: bool | None = None,
        arm: str | Path | None = None,
        threads: int = 1,
        render_mode: str | None = None,
    ) -> None:
        for name, value in {"num_envs": num_envs, "threads": threads}.items():
            if value < 1:
                raise ArenaError(f"{name}: must be at least 1 (got {value})")
        if render_mode is not None:
            raise ArenaError("render_mode: many arms are not drawn; make one of them")
        chosen = execution.settings_of(
            self.arena.settings, settings, control=control, fan=fan, embedding=embedding, arm=arm
        )
        made = situations if situations is not None else self.arena.family
        if not isinstance(made, execution.Pool):
            made = execution.pool_of(made, pool, pool_seed, chosen, body)
        plant: Any = self.arena.plant(made, num_envs, chosen, threads)
        self.plant, self.pool, self.settings = plant, plant.pool, chosen
        self.num_envs, self.render_mode = num_envs, None
        self.single_observation_space, self.single_action_space = box(plant), commands(plant)
        self.observation_space = batch_space(self.single_observation_space, self.num_envs)
        self.action_space = batch_space(self.single_action_space, self.num_envs)
        self._everyone = np.arange(self.num_envs)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[np.ndarray, dict[str, Any]]:
        """Begin all episodes; ``options={"index": (num_envs,)}`` says in which situations."""
        if seed is not None:
            from gymnasium.utils import seeding

            self._np_random, self._np_random_seed = seeding.np_random(seed)
        index = (options or {}).get("index")
        places = self._drawn(self.num_envs) if index is None else np.asarray(index, np.int64)
        if places.shape != (self.num_envs,) or np.any((places < 0) | (places >= len(self.pool))):
            raise ArenaError(f"options.index: must be {self.num_envs} numbers of situations")
        self.plant.put(self._everyone, places)
        return self.plant.observations.copy(), {}

    def _drawn(self, count: int) -> np.ndarray:
        return self.np_random.integers(len(self.pool), size=count)

    def step(
        self, actions: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, dict[str, Any]]:
        """Move all arms for a step; actions of another shape, or not finite, are an error."""
        plant, info = self.plant, dict[str, Any]()
        shape = (self.num_envs, plant.commands)
        outcomes = plant.move(finite(actions, shape, f"{type(self).__name__}.step"))
        rewards = plant.rewards
        info["reward_terms"] = dict(zip(execution.TERMS, plant.terms.T.copy(), strict=True))
        over, late = outcomes != execution.RUNNING, outcomes == execution.LATE
        if over.any():
            self._begin_anew(np.flatnonzero(over), over, info)
        return plant.observations.copy(), rewards, over & ~late, late, info

    def _begin_anew(self, arms: np.ndarray, over: np.ndarray, info: dict[str, Any]) -> None:
        """Note how episodes ended, and begin others."""
        plant = self.plant
        last, names = np.empty(self.num_envs, object), np.full(self.num_envs, "", object)
        caught = np.empty(self.num_envs, object)
        for e in arms:
            last[e] = plant.observations[e].copy()
            names[e], caught[e] = execution.OUTCOMES[plant.told.outcomes[e]], plant.caught(int(e))
        info["final_obs"], info["_final_obs"] = last, over
        info["final_info"] = {
            "time": plant.state.time.copy(),
            "outcome": names,
            "is_success": plant.told.outcomes == execution.CAUGHT,
            "index": plant.state.place.copy(),
            "caught": caught,
        }
        info["_final_info"] = over
        plant.put(arms, self._drawn(len(arms)))


class CatchArms(ManyArms):
    """Many arms of `CatchArm` in compiled code; every step equals that of a single arm.

    ``gymnasium.make_vec("gcm_learn:CatchArm-v0", num_envs=64,
    vectorization_mode="vector_entry_point")`` makes it. Actions, observations, rewards,
    ends and arguments are as in `CatchArm`. Several `threads` share the arms, which pays from some
    hundred arms on.

    An arm whose episode ends begins another one within the same step (`AutoresetMode.SAME_STEP`):
    the observation is the new episode's first. The old episode's last one is in
    ``info["final_obs"]``, and ``info["final_info"]`` holds its `time`, `outcome`, `caught` and
    `is_success`.
    """

    arena = execution.ARENAS["CatchArm-v0"]


class CatchArms3D(ManyArms):
    """Many `CatchArm3D`s in compiled code, as `CatchArms` are of `CatchArm`.

    ``gymnasium.make_vec("gcm_learn:CatchArm3D-v0", num_envs=64,
    vectorization_mode="vector_entry_point")`` makes it.
    """

    arena = execution.ARENAS["CatchArm3D-v0"]


class CatchChains(ManyArms):
    """Many `CatchChain`s in compiled code, as `CatchArms` are of `CatchArm`.

    ``gymnasium.make_vec("gcm_learn:CatchChain-v0", num_envs=64,
    vectorization_mode="vector_entry_point")`` makes it.
    """

    arena = execution.ARENAS["CatchChain-v0"]


class CatchArmsPhysics(ManyArms):
    """Many `CatchArmPhysics`, stepped one after the other and observed in compiled code.

    ``gymnasium.make_vec("gcm_learn:CatchArmPhysics-v0", num_envs=16,
    vectorization_mode="vector_entry_point")`` makes it.
    """

    arena = execution.ARENAS["CatchArmPhysics-v0"]


class CatchChainsPhysics(ManyArms):
    """Many `CatchChainPhysics`, stepped one after the other and observed in compiled code.

    ``gymnasium.make_vec("gcm_learn:CatchChainPhysics-v0", num_envs=16,
    vectorization_mode="vector_entry_point")`` makes it.
    """

    arena = execution.ARENAS["CatchChainPhysics-v0"]
