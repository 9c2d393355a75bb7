"""Work that is shared out: among this process, others beside it, or the workers of a cluster."""

from gcm_learn.processes.cluster import ClusterCrew
from gcm_learn.processes.crew import Crew, Here, OutOfTime, time_limit
from gcm_learn.processes.local import Context, LocalCrew, cores, crew_of, interrupts_held, pool

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
