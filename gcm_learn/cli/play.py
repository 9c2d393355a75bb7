"""``gcm-learn play``: a situation in the browser, changed by hand and answered at once."""

from __future__ import annotations

import threading
import webbrowser
from dataclasses import dataclass
from typing import Annotated, Any

from tyro.conf import Positional

from gcm_learn.cli.failures import CommandFailure
from gcm_learn.cli.options import given, ranged

PORT = ranged(int, "N", 0, 65535, above=False)


@dataclass(frozen=True)
class Play:
    """Open a page on which arm, target and obstacles of a planar situation are dragged.

    Plan, map and film follow at once. The page is served to this machine only, until Ctrl-C.
    """

    file: Annotated[Positional[str | None], given("FILE", "an example")] = None
    """situation to begin with: a .json file, or the first of a .jsonl file"""

    port: Annotated[int, PORT, given("N", "a free one")] = 0
    """port of the page's address"""

    browser: bool = True
    """open the page in a browser; --no-browser only prints its address"""

    def run(self) -> int:
        """Serve the page until Ctrl-C."""
        from gcm_learn.play import KINDS, Newest, Server, example, respond

        start = example() if self.file is None else _first(self.file)
        with Server(Newest(respond), KINDS, start, self.port) as server:
            print(f"Open {server.address} in a browser. Ctrl-C ends it.", flush=True)
            if self.browser:
                threading.Thread(
                    target=webbrowser.open, args=(server.address,), daemon=True
                ).start()
            server.serve_forever()
        return 0


def _first(file: str) -> dict[str, Any]:
    """Return the first situation of a file as JSON; refuse one that the page cannot show."""
    from gcm_learn.errors import SituationError
    from gcm_learn.play import shown
    from gcm_learn.situation import read_situations, situation_to_json

    try:
        return situation_to_json(shown(read_situations(file)[0]))
    except SituationError as error:
        raise CommandFailure(f"{file}: {error}") from None
