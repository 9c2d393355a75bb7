"""First answers of an installed package: the processor time of each, in an empty home.

Run by `make wheel-test` outside of the checkout, with both wheels installed.  It fails if anything
is compiled or kept.
"""

from __future__ import annotations

import os
import resource
import subprocess
import sys
import tempfile
from pathlib import Path

PLAN = "from gcm_learn import families, solve\nprint(solve(families.draw({!r}, 5, 0), {!r}).status)"
STEP = (
    "import gymnasium\nenv = gymnasium.make('gcm_learn:{}')\nenv.reset(seed=0)\n"
    "print(env.step(env.action_space.sample())[1])"
)
ARM = (
    "from dataclasses import replace\nfrom gcm_learn import families, solve\n"
    "print(solve(families.draw('throw-chain', 5, 0, arm='ur5'), 'search').status)"
)
PRESETS = (
    "panda-easy", "panda-crowded", "panda-crowded-accelerated", "space-sequences",
    "panda-sequences",
)  # fmt: skip
FIRST = {
    "plane": PLAN.format("crossing-swarm", "search"),
    "plane, gcm": PLAN.format("crossing-swarm", "gcm"),
    "plane, recall": PLAN.format("crossing-swarm", "recall"),
    "space": PLAN.format("falling-space", "search"),
    "space, recall": PLAN.format("falling-space", "recall"),
    "another arm": ARM,
    **{name: PLAN.format(name, "search") for name in PRESETS},
    "CatchArm-v0": STEP.format("CatchArm-v0"),
    "CatchArm3D-v0": STEP.format("CatchArm3D-v0"),
    "CatchChain-v0": STEP.format("CatchChain-v0"),
}


def children() -> float:
    """Return the processor time of all children that have ended [s]."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def main() -> None:
    """Print a line for each, and end with 1 if something was compiled."""
    compiled = []
    with tempfile.TemporaryDirectory() as home:
        place = {"HOME": home, "XDG_CACHE_HOME": f"{home}/cache", "NUMBA_CACHE_DIR": ""}
        for name, code in FIRST.items():
            before = children()
            done = subprocess.run(
                [sys.executable, "-c", code], env=os.environ | place, cwd=home,
                capture_output=True, text=True, check=False,
            )  # fmt: skip
            kept = list(Path(home).rglob("*.nbc"))
            print(f"{name:28s} {children() - before:5.2f} s  {done.stdout.strip()}")
            if kept or done.returncode:
                compiled.append(name)
                print(done.stderr[-500:], *sorted({path.parent.name for path in kept})[:8])
            for path in kept:
                path.unlink()
    if compiled:
        sys.exit(f"compiled something, or failed: {', '.join(compiled)}")


if __name__ == "__main__":
    main()
