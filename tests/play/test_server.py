"""The page's server answers the page on this machine, and nobody else."""

import http.client
import json
import os
import signal
import socket
import subprocess
import sys
from pathlib import Path

import pytest

from gcm_learn.cli import main
from gcm_learn.play import Newest, Server
from gcm_learn.play.server import LARGEST_QUESTION, LOOPBACK, PortError

ROOT = Path(__file__).parents[2]
JSON = {"Content-Type": "application/json"}


def asked(server, method="GET", path=None, body=None, headers=None, host=None):
    """Send a request; `{}` in a path stands for the secret."""
    port = server.server_address[1]
    connection = http.client.HTTPConnection(LOOPBACK, port, timeout=20)
    given = {"Host": host or f"{LOOPBACK}:{port}", **(headers or {})}
    connection.request(method, (path or "/{}/").format(server.secret), body, given)
    response = connection.getresponse()
    text = response.read()
    connection.close()
    return response, text


def posted(server, kind="draw", question=None, **headers):
    """Send a question as the page does."""
    origin = {"Origin": server.address.rpartition("/")[0].rpartition("/")[0]}
    body = json.dumps(question or {"name": "gate"})
    return asked(server, "POST", f"/{{}}/{kind}", body, {**JSON, **origin, **headers})


def test_it_sends_the_page_and_answers(server):
    response, text = asked(server)
    assert response.status == 200 and b"<!doctype html>" in text
    assert "default-src 'none'" in response.headers["Content-Security-Policy"]
    assert response.headers["Referrer-Policy"] == "no-referrer"
    for file in (ROOT / "gcm_learn" / "play" / "pages").glob("*.[cj]s*"):
        if file.suffix != ".json":
            assert asked(server, path=f"/{{}}/{file.name}")[1] == file.read_bytes()
    response, text = posted(server)
    assert response.status == 200 and json.loads(text)["situation"]["name"] == "gate-0000000"
    assert server.server_address[0] == LOOPBACK and len(server.secret) >= 32


PORT = "{port}"
REFUSED = [
    ({"path": "/"}, 404),
    ({"path": "/wrong/"}, 404),
    ({"path": "/{}"}, 404),
    ({"path": "/{}/nothing.js"}, 404),
    ({"path": "/{}/../server.py"}, 404),
    ({"path": "/{}/%2e%2e/server.py"}, 404),
    ({"path": "/{}//etc/passwd"}, 404),
    ({"path": "/{}/start.json"}, 404),
    ({"method": "PUT"}, 404),
    ({"method": "OPTIONS"}, 404),
    ({"method": "HEAD"}, 404),
    ({"host": "evil.example"}, 403),
    ({"host": "127.0.0.1:1"}, 403),
    ({"host": "127.0.0.1.evil.example:80"}, 403),
    ({"headers": {"Origin": "http://evil.example"}}, 403),
    ({"headers": {"Origin": "null"}}, 403),
    ({"method": "POST", "path": "/{}/draw", "body": "{}", "headers": JSON}, 403),  # no Origin
]


@pytest.mark.parametrize(("request_", "status"), REFUSED, ids=lambda x: str(x)[:50])
def test_it_refuses_everything_else(server, request_, status):
    response, text = asked(server, **request_)
    assert (response.status, text) == (status, b"")


QUESTIONS = [
    ({"kind": "nothing"}, 404),
    ({"Content-Type": "text/plain"}, 403),
    ({"Origin": "http://localhost:1"}, 403),
    ({"Content-Length": str(LARGEST_QUESTION + 1)}, 413),
    ({"Content-Length": "9" * 5000}, 413),
    ({"Content-Length": "-1"}, 411),
    ({"Content-Length": "1"}, 400),
]


@pytest.mark.parametrize(("change", "status"), QUESTIONS, ids=lambda x: str(x)[:50])
def test_it_refuses_questions_that_the_page_does_not_ask(server, change, status):
    assert posted(server, **change)[0].status == status


def test_a_request_for_two_hosts_is_refused(server):
    port = server.server_address[1]
    with socket.create_connection((LOOPBACK, port), timeout=20) as line:
        hosts = f"Host: {LOOPBACK}:{port}\r\nHost: evil.example\r\n"
        line.sendall(f"GET /{server.secret}/ HTTP/1.1\r\n{hosts}\r\n".encode())
        assert line.recv(100).startswith(b"HTTP/1.1 403")


def test_a_port_that_is_taken_is_one_line(server, capsys):
    port = server.server_address[1]
    with pytest.raises(PortError):
        Server(Newest(lambda kind, question: {}), (), {}, port)
    assert main(["play", "--no-browser", "--port", str(port)]) == 2
    assert capsys.readouterr().err.startswith(f"gcm-learn: port {port}: cannot be listened on")


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--port", "70000"], "--port 70000: must be at least 0 and at most 65535"),
        (["solid.jsonl"], "solid.jsonl: bodies: this page shows planar arms"),
        (["missing.json"], "missing.json: cannot be read"),
    ],
)
def test_mistakes_end_before_anything_is_served(arguments, said, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(["draw", "gate-solid", "--out", "solid.jsonl"]) == 0
    assert main(["play", "--no-browser", *arguments]) == 2
    assert said in capsys.readouterr().err


@pytest.mark.skipif(not hasattr(os, "killpg"), reason="no groups of processes")
def test_ctrl_c_ends_it_in_one_line(tmp_path):
    scene = tmp_path / "scene.jsonl"
    assert main(["draw", "gate", "--out", str(scene)]) == 0
    run = subprocess.Popen(
        [sys.executable, "-m", "gcm_learn", "play", "--no-browser", str(scene)],
        env={**os.environ, "PYTHONPATH": str(ROOT)}, cwd=tmp_path, text=True,
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, start_new_session=True,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
    )  # fmt: skip
    assert run.stdout is not None
    address = run.stdout.readline().split()[1]
    host, secret = address.removeprefix("http://").rstrip("/").split("/")
    connection = http.client.HTTPConnection(host, timeout=20)
    connection.request("GET", f"/{secret}/given.json")
    assert json.loads(connection.getresponse().read())["name"] == "gate-0000000"
    os.killpg(run.pid, signal.SIGINT)
    _, error = run.communicate(timeout=60.0)
    assert (run.returncode, error) == (130, "gcm-learn: interrupted\n")
