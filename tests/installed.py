"""First answers of an installed package: the processor time of each, in an empty home.

Run by `make wheel-test` outside of the checkout, with both wheels installed.  It fails if one has
no answer, if anything is compiled, or if anything is written.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from pathlib import Path

from gcm_learn.families import PRESETS, draw
from gcm_learn.situation import write_situations

PLAN = "from gcm_learn import families, solve\nplan = solve(families.draw({!r}, 5, {}), {!r})"
FILE = (
    "from gcm_learn import solve\nfrom gcm_learn.situation import read_situations\n"
    "plan = solve(read_situations('FILE')[0])"
)
STEP = (
    "import gymnasium\nenv = gymnasium.make('gcm_learn:{}')\nenv.reset(seed=0)\n"
    "env.step(env.action_space.sample())"
)
TOLD = (
    "\nimport time\nprint(time.process_time(), plan.message if 'plan' in globals() else 'stepped')"
)
FIRST = {
    **{f"plane, {name}": PLAN.format("crossing-swarm", 0, name) for name in ("search", "gcm")},
    **{
        f"{family}, {name}": PLAN.format(family, 0, name)
        for family in ("crossing-swarm", "falling-space", "panda-crowded")
        for name in ("recall", "hybrid")
    },
    "space": "from gcm_learn import paper_scene, solve\nplan = solve(paper_scene('fig8-space'))",
    "xArm6 from a file": FILE,
    **{f"{name}, {k}": PLAN.format(name, k, "search") for name in PRESETS for k in range(6)},
    **{name: STEP.format(name) for name in ("CatchArm-v0", "CatchArm3D-v0", "CatchChain-v0")},
}


def main() -> None:
    """Print a line for each, and end with 1 if something was compiled or is wrong."""
    wrong = []
    with tempfile.TemporaryDirectory() as home, tempfile.TemporaryDirectory() as files:
        file = Path(files, "xarm6.jsonl")
        write_situations(file, [draw("throw-chain", 5, 0, arm="xarm6")])
        places = dict.fromkeys(("HOME", "XDG_CACHE_HOME", "XDG_DATA_HOME", "LOCALAPPDATA"), home)
        environment = os.environ | places | {"NUMBA_CACHE_DIR": ""}
        for name, code in FIRST.items():
            done = subprocess.run(
                [sys.executable, "-c", code.replace("FILE", str(file)) + TOLD],
                env=environment, cwd=home, capture_output=True, text=True, check=False,
            )  # fmt: skip
            used, _, message = done.stdout.strip().partition(" ")
            print(f"{name:28s} {float(used or 'nan'):5.2f} s  {message}", flush=True)
            written = sorted(path for path in Path(home).rglob("*") if path.is_file())
            if written or done.returncode or done.stderr:
                wrong.append(name)
                print(done.stderr[-500:], *sorted({path.parent.name for path in written})[:8])
            for path in written:
                path.unlink()
    if wrong:
        sys.exit(f"compiled or wrote something, or failed: {', '.join(wrong)}")


if __name__ == "__main__":
    main()
