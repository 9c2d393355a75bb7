"""Tasks done by this process, by other local processes, or by the workers of a cluster."""

from gcm_learn.processes.cluster import ClusterCrew as ClusterCrew
from gcm_learn.processes.crew import (
    Crew as Crew,
    Here as Here,
    OutOfTime as OutOfTime,
    time_limit as time_limit,
)
from gcm_learn.processes.local import (
    Context as Context,
    LocalCrew as LocalCrew,
    cores as cores,
    crew_of as crew_of,
    interrupts_held as interrupts_held,
    pool as pool,
)
