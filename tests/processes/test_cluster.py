"""A real Dask scheduler with two worker processes, one of which is killed on the way."""

from __future__ import annotations

import os
import signal
import socket
import subprocess
import sys
import time
from dataclasses import replace
from itertools import islice
from pathlib import Path

import pytest

pytest.importorskip("distributed")

from gcm_learn.dataset import generate
from gcm_learn.dataset.folder import Folder
from gcm_learn.errors import ClusterError
from gcm_learn.processes import ClusterCrew
from tests.dataset.conftest import SMALL, SPACE, make_here

ROOT = Path(__file__).parents[2]


def start(*arguments: str) -> subprocess.Popen:
    """Start a part of a cluster."""
    environment = os.environ | {"PYTHONPATH": str(ROOT), "OMP_NUM_THREADS": "1"}
    command = [sys.executable, "-m", "distributed.cli." + arguments[0], *arguments[1:]]
    return subprocess.Popen(
        command, env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
    )


def free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


@pytest.fixture
def cluster():
    """Return the scheduler's address, its process and those of two workers."""
    port = free_port()
    address = f"tcp://127.0.0.1:{port}"
    parts = [start("dask_scheduler", "--host", "127.0.0.1", "--port", str(port), "--no-dashboard")]
    time.sleep(1.0)
    for _ in range(2):
        parts.append(start("dask_worker", address, "--nthreads", "1", "--no-nanny"))
    yield address, *parts
    for part in reversed(parts):
        part.kill()
        part.wait()


@pytest.mark.slow
def test_a_killed_worker_of_a_cluster_costs_nothing_but_time(tmp_path, cluster):
    address, _, *workers = cluster
    spec = replace(SMALL, count=1200)
    make_here(spec, str(tmp_path / "here"))
    made = []

    def progress(records):
        made.append(records)
        if sum(made) >= 200 and workers[0].poll() is None:
            workers[0].send_signal(signal.SIGKILL)

    manifest = generate(spec, tmp_path / "cluster", cluster=address, progress=progress)
    assert workers[0].poll() == -signal.SIGKILL and workers[1].poll() is None
    assert manifest["complete"] and manifest["records"] == 1200
    assert_same(tmp_path)
    assert manifest["runs"][0]["cluster"] == address


def assert_same(folder):
    """What was made here and on the cluster are the same bytes."""
    for name in Folder(folder / "here").names("shards"):
        here, there = (Folder(folder / f).sha256(f"shards/{name}") for f in ("here", "cluster"))
        assert here == there


@pytest.mark.slow
def test_records_in_space_are_those_that_one_process_makes(tmp_path, cluster):
    spec = replace(SPACE, effort=0.25, audit=0.1)
    make_here(spec, str(tmp_path / "here"))
    assert generate(spec, tmp_path / "cluster", cluster=cluster[0])["complete"]
    assert_same(tmp_path)


@pytest.mark.parametrize("after", [pytest.param(0, marks=pytest.mark.slow), 1, 9])
def test_a_cluster_that_goes_away_is_said_in_one_line(after, cluster, capfd):
    address, scheduler, *_ = cluster
    with ClusterCrew(address) as crew, pytest.raises(ClusterError) as caught:
        for _ in islice(found := crew.results(str, range(10_000)), after):
            pass
        scheduler.kill()
        scheduler.wait()
        list(found)
    assert str(caught.value) == f"{address}: the cluster has gone away"
    assert capfd.readouterr().err == ""
