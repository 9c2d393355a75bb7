"""The page's server: this machine only, one secret address, and only the page's own files.

Of the waiting questions of one page and kind, the server answers only the newest.
"""

from __future__ import annotations

import hmac
import json
import secrets
import sys
import threading
from collections.abc import Callable, Collection
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from importlib.resources import files
from typing import Any

from gcm_learn.errors import GcmError
from gcm_learn.planners import in_words
from gcm_learn.situation import JsonTextError, parse

Values = dict[str, Any]
DROPPED: Values = {"dropped": True}
"""Answer to a question after which a newer one came."""


class _Waiting:
    """A question that waits for the worker."""

    def __init__(self, kind: str, question: Values) -> None:
        self.kind, self.question = kind, question
        self.answer = DROPPED
        self.done = threading.Event()


class Newest:
    """Worker that answers questions one after the other, in a thread of its own.

    Parameters
    ----------
    respond : callable
        Takes kind and question, returns the answer; it is never called by two threads at once.
    """

    def __init__(self, respond: Callable[[str, Values], Values]) -> None:
        self._respond = respond
        self._waiting: dict[tuple[str, str], _Waiting] = {}
        self._changed = threading.Condition()
        threading.Thread(target=self._work, name="engine", daemon=True).start()

    def ask(self, kind: str, question: Values, page: str = "") -> Values:
        """Return the answer to a question, or `DROPPED` if a newer one of its kind replaced it.

        Parameters
        ----------
        kind : str
        question : dict
        page : str
            Questions of different pages never replace each other.
        """
        asked = _Waiting(kind, question)
        with self._changed:
            older = self._waiting.pop((page, kind), None)
            self._waiting[page, kind] = asked
            self._changed.notify()
        if older is not None:
            older.done.set()
        asked.done.wait()
        return asked.answer

    def _work(self) -> None:
        while True:
            with self._changed:
                while not self._waiting:
                    self._changed.wait()
                asked = self._waiting.pop(next(iter(self._waiting)))
            try:
                asked.answer = self._respond(asked.kind, asked.question)
            except Exception as error:  # the page goes on, and shows what happened
                asked.answer = {"error": f"unexpected error: {in_words(error)}"}
            asked.done.set()


LOOPBACK = "127.0.0.1"
LARGEST_QUESTION = 1_000_000  # [bytes]
PATIENCE = 30.0  # [s] for a request that began
TYPES = {
    "html": "text/html; charset=utf-8",
    "css": "text/css; charset=utf-8",
    "js": "text/javascript; charset=utf-8",
}
POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; "
    "img-src 'self' data: blob:; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
)
HEADERS = {
    "Content-Security-Policy": POLICY,
    "Referrer-Policy": "no-referrer",  # the address holds the secret
    "X-Content-Type-Options": "nosniff",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Cache-Control": "no-store",
}


class PortError(GcmError, OSError):
    """The port cannot be listened on."""


class Server(ThreadingHTTPServer):
    """HTTP server of the page and of answers to the page's questions.

    Parameters
    ----------
    worker : Newest
        Answers questions.
    kinds : collection of str
        Kinds of questions that it answers.
    start : dict
        Situation as JSON with which the page begins.
    port : int
        0 takes a free one.

    Raises
    ------
    PortError
    """

    daemon_threads = True
    allow_reuse_address = False  # another program on the port is an error on every platform

    def __init__(
        self, worker: Newest, kinds: Collection[str], start: dict[str, Any], port: int = 0
    ) -> None:
        try:
            super().__init__((LOOPBACK, port), Handler)
        except (OSError, OverflowError) as error:
            reason = getattr(error, "strerror", None) or error
            raise PortError(f"port {port}: cannot be listened on ({reason})") from None
        self.worker, self.kinds = worker, frozenset(kinds)
        self.secret = secrets.token_urlsafe(24)
        self.pages = _pages()
        self.pages["given.json"] = (json.dumps(start).encode(), "application/json")
        port = self.server_address[1]
        self.hosts = frozenset(f"{name}:{port}" for name in (LOOPBACK, "localhost"))

    @property
    def address(self) -> str:
        """Address of the page, with the secret."""
        return f"http://{LOOPBACK}:{self.server_address[1]}/{self.secret}/"

    def handle_error(self, request: Any, client_address: Any) -> None:
        """Report errors, but not browsers that went away."""
        if not isinstance(sys.exc_info()[1], OSError):
            super().handle_error(request, client_address)


def _pages() -> dict[str, tuple[bytes, str]]:
    """Return the page's files with their kinds, by the name in the address; "" is the page."""
    found = {}
    for file in files(__package__).joinpath("pages").iterdir():
        kind = TYPES.get(file.name.rpartition(".")[2])
        if kind is not None:
            found["" if file.name == "index.html" else file.name] = (file.read_bytes(), kind)
    return found


class Handler(BaseHTTPRequestHandler):
    """Answers a request that is addressed to this machine, from the page, by the secret."""

    protocol_version = "HTTP/1.1"
    timeout = PATIENCE
    disable_nagle_algorithm = True  # or an answer of two packets waits for 40 ms
    wbufsize = -1  # head and body leave together
    server: Server

    def do_GET(self) -> None:
        """Send a file of the page."""
        name = self._name()
        if name is None:
            return
        if name not in self.server.pages:
            self._refuse(HTTPStatus.NOT_FOUND)
        else:
            self._send(*self.server.pages[name])

    def do_POST(self) -> None:
        """Answer a question."""
        name = self._name()
        if name is None:
            return
        if name not in self.server.kinds:
            self._refuse(HTTPStatus.NOT_FOUND)
        elif self.headers.get_content_type() != "application/json" or not self.headers["Origin"]:
            self._refuse(HTTPStatus.FORBIDDEN)
        else:
            self._answer(name)

    def _reject(self) -> None:
        """Refuse any other method."""
        if self._name() is not None:
            self._refuse(HTTPStatus.NOT_FOUND)

    do_HEAD = do_PUT = do_PATCH = do_DELETE = do_OPTIONS = do_TRACE = do_CONNECT = _reject

    def _name(self) -> str | None:
        """Return the part of the path below the secret, or refuse the request."""
        hosts, origins = (self.headers.get_all(name, []) for name in ("Host", "Origin"))
        own = len(hosts) == 1 and hosts[0].lower() in self.server.hosts
        if not own or any(origin.lower() != f"http://{hosts[0].lower()}" for origin in origins):
            self._refuse(HTTPStatus.FORBIDDEN)
            return None
        secret, slash, name = self.path.partition("?")[0].removeprefix("/").partition("/")
        if not slash or not hmac.compare_digest(secret.encode(), self.server.secret.encode()):
            self._refuse(HTTPStatus.NOT_FOUND)
            return None
        return name

    def _answer(self, kind: str) -> None:
        """Read a question, let the worker answer it, and send the answer."""
        length = self.headers["Content-Length"] or ""
        if not (length.isascii() and length.isdigit()):
            self._refuse(HTTPStatus.LENGTH_REQUIRED)
            return
        if len(length) > 12 or int(length) > LARGEST_QUESTION:
            self._refuse(HTTPStatus.REQUEST_ENTITY_TOO_LARGE)
            return
        try:
            question = parse(self.rfile.read(int(length)).decode("utf-8"))
        except (JsonTextError, UnicodeDecodeError):
            question = None
        if not isinstance(question, dict):
            self._refuse(HTTPStatus.BAD_REQUEST)
            return
        page = str(question.pop("page", ""))
        told = self.server.worker.ask(kind, question, page)
        self._send(json.dumps(told, allow_nan=False).encode(), "application/json")

    def _refuse(self, status: HTTPStatus) -> None:
        self.close_connection = True  # a body that was not read would be the next request
        self._send(b"", "text/plain", status)

    def _send(self, body: bytes, kind: str, status: HTTPStatus = HTTPStatus.OK) -> None:
        self.send_response(status)
        for name, value in HEADERS.items():
            self.send_header(name, value)
        self.send_header("Content-Type", kind)
        self.send_header("Content-Length", str(len(body)))
        if self.close_connection:
            self.send_header("Connection", "close")
        self.end_headers()
        if self.command != "HEAD":
            self.wfile.write(body)
        self.wfile.flush()

    def version_string(self) -> str:
        """Return the server's name without versions."""
        return "gcm-learn"

    def log_message(self, format: str, *args: Any) -> None:
        """Say nothing: the terminal has the address only."""
