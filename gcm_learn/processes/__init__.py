"""Work that is shared out: among this process, others beside it, or the workers of a cluster."""

from gcm_learn.processes.cluster import ClusterCrew
from gcm_learn.processes.crew import Crew, Here
from gcm_learn.processes.limits import OutOfTime, time_limit
from gcm_learn.processes.local import LocalCrew, crew_of
from gcm_learn.processes.spawning import Context, cores, interrupts_held, pool

__all__ = [
    "ClusterCrew",
    "Context",
    "Crew",
    "Here",
    "LocalCrew",
    "OutOfTime",
    "cores",
    "crew_of",
    "interrupts_held",
    "pool",
    "time_limit",
]
