"""Situations and an arm as JSON, and a table of changes for which they are refused.

A line of ``refused.jsonl`` is a list: the name of a scene, the path of a field, the message, and
the value to put there; without a value the field is taken away.
"""

import copy
import json
from pathlib import Path

from gcm_learn.errors import FileFormatError
from gcm_learn.situation import read_situations
from tests import refusals

FOLDER = Path(__file__).parent
SCENES = json.loads((FOLDER / "scenes.json").read_text("utf-8"))
PLANAR, SOLID, NAO, MOVING, CHAIN, OLDER, MODEL = (
    SCENES[name] for name in ("planar", "solid", "nao", "moving", "chain", "older", "model")
)
REFUSED = [json.loads(line) for line in (FOLDER / "refused.jsonl").read_text("utf-8").splitlines()]
GONE = object()


def changed(scene, path, value=GONE):
    """Return a copy of `scene` with one field replaced, added or (GONE) taken away."""
    result = copy.deepcopy(scene)
    *steps, last = path
    parent = result
    for step in steps:
        parent = parent[step]
    if value is GONE:
        del parent[last]
    else:
        parent[last] = value
    return result


def refusal(path):
    """Return the one line with which a file is refused."""
    return refusals.refusal(FileFormatError, read_situations, path)
