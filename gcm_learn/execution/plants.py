"""Plants and pools by what is chosen about the arms."""

from __future__ import annotations

from gcm_learn.execution.plant import KinematicPlant
from gcm_learn.execution.pool import Pool, SpatialPool
from gcm_learn.execution.settings import Settings, SpatialSettings
from gcm_learn.execution.space.plant import SpatialPlant

AnyPool = Pool | SpatialPool
AnySettings = Settings | SpatialSettings


def plant_of(pool: AnyPool, count: int, settings: AnySettings) -> KinematicPlant | SpatialPlant:
    """Arms of the settings' kind, in the situations of a pool of that kind."""
    if isinstance(settings, SpatialSettings):
        assert isinstance(pool, SpatialPool)
        return SpatialPlant(pool, count, settings)
    assert isinstance(pool, Pool)
    return KinematicPlant(pool, count, settings)
