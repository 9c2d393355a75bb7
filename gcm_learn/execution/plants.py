"""Plants, pools and situations by what is chosen about the arms."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from gcm_learn.execution.physics.arms import PhysicalArms
from gcm_learn.execution.physics.pool import PhysicalPool
from gcm_learn.execution.plant import KinematicPlant
from gcm_learn.execution.pool import Pool, SpatialPool
from gcm_learn.execution.settings import PhysicalSettings, Settings, SpatialSettings
from gcm_learn.execution.sources import (
    Source,
    physical_situations_of,
    situations_of,
    spatial_situations_of,
)
from gcm_learn.execution.space.plant import SpatialPlant
from gcm_learn.situation import AnySituation

AnyPool = Pool | SpatialPool
AnySettings = Settings | SpatialSettings


def plant_of(
    pool: AnyPool, count: int, settings: AnySettings
) -> KinematicPlant | SpatialPlant | PhysicalArms:
    """Arms of the settings' kind, in the situations of a pool of that kind."""
    if isinstance(settings, PhysicalSettings):
        assert isinstance(pool, PhysicalPool)
        return PhysicalArms(pool, count, settings)
    if isinstance(settings, SpatialSettings):
        assert isinstance(pool, SpatialPool)
        return SpatialPlant(pool, count, settings)
    assert isinstance(pool, Pool)
    return KinematicPlant(pool, count, settings)


def pool_for(settings: AnySettings, situations: Sequence[Any]) -> AnyPool:
    """Situations packed for arms of the settings' kind."""
    if isinstance(settings, PhysicalSettings):
        return PhysicalPool.of(situations)
    return (SpatialPool if isinstance(settings, SpatialSettings) else Pool).of(situations)


def situations_for(
    settings: AnySettings, source: Source, count: int, seed: int
) -> Sequence[AnySituation]:
    """Situations for arms of the settings' kind; see `situations_of`."""
    if isinstance(settings, PhysicalSettings):
        return physical_situations_of(source, count, seed)
    if isinstance(settings, SpatialSettings):
        return spatial_situations_of(source, count, seed)
    return situations_of(source, count, seed)
