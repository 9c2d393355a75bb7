"""Whom to ask for work that may be done anywhere."""

from __future__ import annotations

from gcm_learn.processes.cluster import ClusterCrew
from gcm_learn.processes.crew import Crew, Here
from gcm_learn.processes.local import LocalCrew
from gcm_learn.processes.spawning import cores


def crew_of(workers: int | None = None, cluster: str | None = None) -> Crew:
    """Whoever does the work.

    Parameters
    ----------
    workers : int, optional
        Processes on this machine: one for each core by default, for one this process itself.
    cluster : str, optional
        Address of a Dask scheduler, ``tcp://host:port``, whose workers are used instead.
    """
    if cluster is not None:
        return ClusterCrew(cluster)
    workers = workers or cores()
    return Here() if workers == 1 else LocalCrew(workers)
