"""The how-to for a shape: a copy of the package gets one, as `docs/extending.md` says."""

import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import gcm_learn

pytestmark = pytest.mark.slow  # the copy is compiled anew

SOURCE = Path(gcm_learn.__file__).parent
EDITS = {
    "situation/shapes.py": [
        (r"(SolidShape = .*)\n", r"\1 | Pill\n"),
        (r"(SOLID = \(.*)\)\n", r"\1, Pill)\n"),
    ],
    "situation/__init__.py": [
        ('    "Capsule",\n', '    "Capsule",\n    "Pill",\n'),
        ("    Capsule,\n", "    Capsule,\n    Pill,\n"),
    ],
    "situation/schema.py": [
        ("    Capsule,\n", "    Capsule,\n    Pill,\n"),
        (r"    (Capsule)(: dict.*\n)", r"    \1\2    Pill\2"),
    ],
    "scene/bodies.py": [(r"CYLINDER = range\(6\)", "CYLINDER, PILL = range(7)")],
    "scene/shapes/entries.py": [
        ("import ball, box, capsule,", "import ball, box, capsule, pill,"),
        ("import Box, Capsule,", "import Box, Capsule, Pill,"),
        ("    Capsule: capsule.ENTRY,\n", "    Capsule: capsule.ENTRY,\n    Pill: pill.ENTRY,\n"),
    ],
    "scene/shapes/choice.py": [
        ("import ball, box, capsule,", "import ball, box, capsule, pill,"),
        ("BALL, BOX, CAPSULE,", "BALL, BOX, CAPSULE, PILL,"),
        (r"(    if kind == )CAPSULE(:\n        return )capsule(.*\n)", r"\g<0>\1PILL\2pill\3"),
    ],
    "rendering/solids.py": [
        ("import Box, Capsule,", "import Box, Capsule, Pill,"),
        (r"\n}\n", "\n}\nMESHES[Pill] = MESHES[Capsule]\n"),
    ],
}
"""Files of the how-to's steps, and what is put in the place of what."""
ASKED = """
import json, sys
from gcm_learn import paper_scene, solve
from gcm_learn.planners import plan_to_json
from gcm_learn.plots import plan_figure
from gcm_learn.situation import schemas, situation_from_json, situation_to_json
given = json.dumps(situation_to_json(paper_scene("fig8-space")))
assert '"capsule"' in given and "pill" in json.dumps(schemas())
answers = []
for kind in ("capsule", "pill"):
    situation = situation_from_json(json.loads(given.replace('"capsule"', f'"{kind}"')))
    assert f'"{kind}"' in json.dumps(situation_to_json(situation))
    plan = solve(situation, "search")
    plan_figure(situation, plan).savefig(f"{kind}.png")
    answers.append(plan_to_json(plan, situation) | {"planning_ms": 0})
print(json.dumps(answers))
"""


def with_a_pill(folder):
    """Copy the package and add a shape that is a capsule by another name."""
    shutil.copytree(SOURCE, folder / "gcm_learn", ignore=shutil.ignore_patterns("__pycache__"))
    shapes = folder / "gcm_learn" / "situation" / "shapes.py"
    text = shapes.read_text("utf-8")
    record = re.search(r"@dataclass\(frozen=True\)\nclass Capsule:.*?(?=@dataclass)", text, re.S)[0]
    twin = record.replace("class Capsule", "class Pill").replace('"capsule"', '"pill"')
    shapes.write_text(text.replace(record, record + twin), "utf-8")
    kernels = folder / "gcm_learn" / "scene" / "shapes"
    twin = (kernels / "capsule.py").read_text("utf-8").replace("CAPSULE", "PILL")
    (kernels / "pill.py").write_text(twin, "utf-8")
    for name, edits in EDITS.items():
        file = folder / "gcm_learn" / name
        text = file.read_text("utf-8")
        for old, new in edits:
            text, count = re.subn(old, new, text)
            assert count > 0, (name, old)
        file.write_text(text, "utf-8")


def test_a_shape_is_added_as_the_how_to_says(tmp_path):
    with_a_pill(tmp_path)
    done = subprocess.run(
        [sys.executable, "-c", ASKED],
        cwd=tmp_path, capture_output=True, text=True, check=False,
        env=os.environ | {"PYTHONPATH": str(tmp_path), "NUMBA_CACHE_DIR": str(tmp_path / "code")},
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    capsule, pill = json.loads(done.stdout)
    assert capsule == pill and capsule["status"] == "caught"
    assert (tmp_path / "pill.png").stat().st_size > 5000
