"""Work comes out the same whoever does it; who cannot do it says so in one line."""

import os
import socket
import sys
from functools import partial

import pytest

pytest.importorskip("distributed")

from gcm_learn.cli import main
from gcm_learn.errors import ClusterError, MissingExtraError
from gcm_learn.processes import ClusterCrew, Here, LocalCrew, cluster, crew_of
from tests.processes.work import deadly, late, wrong


@pytest.fixture(params=["here", "local", "cluster"])
def crew(request, scheduler):
    """One crew of each kind, at work."""
    kinds = {"here": Here, "local": lambda: LocalCrew(2), "cluster": lambda: ClusterCrew(scheduler)}
    with kinds[request.param]() as made:
        yield made


def test_results_come_in_order_or_with_their_numbers(crew):
    assert list(crew.map(late, range(12))) == [k * k for k in range(12)]
    found = dict(crew.results(late, [3, 0, 5]))
    assert found == {0: 9, 1: 0, 2: 25}
    assert list(crew.map(late, [])) == []


def test_what_is_left_early_is_left(crew):
    """Tasks are taken as they are done, and a crew can be asked again."""
    taken = []
    for _ in crew.results(late, (taken.append(k) or k for k in range(1000))):
        break
    assert len(taken) < 20
    assert list(crew.map(late, [4])) == [16]


def test_errors_of_the_work_come_through(crew):
    with pytest.raises(ZeroDivisionError, match="three"):
        list(crew.map(wrong, range(5)))


def test_what_kills_its_process_is_done_at_home():
    with LocalCrew(1, ahead=1) as crew:
        assert list(crew.map(partial(deadly, os.getpid()), range(3))) == [0, 1, 2]
        assert crew.rebuilt == 3


def test_who_is_asked():
    assert isinstance(crew_of(1), Here) and isinstance(crew_of(3), LocalCrew)
    assert crew_of(3).workers == 3 and crew_of(5, "tcp://there:1").address == "tcp://there:1"


def test_a_worker_with_other_sources_is_refused(scheduler, monkeypatch):
    told = iter(["ours", *["theirs"] * 100])
    monkeypatch.setattr(cluster, "sources", lambda: next(told))
    with ClusterCrew(scheduler) as crew, pytest.raises(ClusterError, match="other sources"):
        list(crew.map(str, [1]))


@pytest.fixture
def nowhere(monkeypatch):
    """Return an address at which nothing answers."""
    monkeypatch.setattr(cluster, "CONNECT", 1)
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return f"tcp://127.0.0.1:{probe.getsockname()[1]}"


COMMANDS = {
    "generate": ["data/sample/spec.toml"],
    "memory make": ["data/sample"],
    "train encoder": ["data/sample"],
    "compare": ["straight", "--on", "gate", "--count", "2"],
}


@pytest.mark.parametrize("command", COMMANDS)
@pytest.mark.parametrize("missing", [False, True])
def test_no_cluster_and_no_dask_are_said_in_one_line(
    command, missing, nowhere, tmp_path, monkeypatch, capsys
):
    if missing:
        monkeypatch.setitem(sys.modules, "distributed", None)
    out = tmp_path / "out"
    given = [*command.split(), *COMMANDS[command], "--out", str(out), "--cluster", nowhere]
    assert main(given) in (1, 2)
    said = capsys.readouterr().err
    wanted = "pip install 'gcm_learn[cluster]'" if missing else f"{nowhere}: no scheduler answers"
    assert wanted in said and said.count("\n") == 1


def test_the_extra_is_named(monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(MissingExtraError, match=r"^--cluster needs dask and distributed: pip"):
        ClusterCrew("tcp://there:1").__enter__()
