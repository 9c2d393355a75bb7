"""A server of the page on a free port."""

import threading

import pytest

from gcm_learn.play import KINDS, Newest, Server, example, respond


@pytest.fixture(scope="session")
def server():
    """Serve the page in a thread, with the example to begin with."""
    with Server(Newest(respond), KINDS, example()) as made:
        thread = threading.Thread(target=made.serve_forever, daemon=True)
        thread.start()
        yield made
        made.shutdown()
        thread.join()
