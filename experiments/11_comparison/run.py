"""Compare planners, memories and policies where thinking costs time and percepts are inexact (H1).

python -m experiments 11_comparison charged     W, thinking charged
python -m experiments 11_comparison noise       W and Q, percepts inexact

Writes a sheet, its page and tables into out/. The tables beside this file are of an earlier run,
in which all habits of planning anew were asked.
"""

from __future__ import annotations

import argparse
from pathlib import Path

from gcm_learn.evaluation import Condition, ask, cases, page, pairs, shares

OUT = Path(__file__).parent / "out"
THINKING = [Condition(t) for t in (0.0, 0.02, 0.05, 0.1, 0.2)]
ASKED = {
    "charged": (
        ["straight", "gcm", "marching", "layered", "splines-random", "recall-random", "recall-raw",
         "recall", "hybrid", "ppo-clone", "ppo-clone@20"],
        ("W",), [*THINKING, Condition("own")], ("gcm", "layered"),
    ),
    "noise": (
        ["hybrid", "layered"], ("W", "Q"),
        [Condition(noise=n) for n in (0.0, 0.005, 0.01, 0.02)], ("layered",),
    ),
}  # fmt: skip
"""Entrants, suites, conditions, and controls of the hybrid, by part."""


def main() -> None:
    """Ask, and write what came of it."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("part", choices=ASKED)
    parser.add_argument("--count", type=int, default=300, help="situations in all")
    given = parser.parse_args()
    entrants, suites, conditions, controls = ASKED[given.part]
    found = cases(*suites, count=given.count // len(suites))
    sheet = ask(entrants, found, conditions, keep=OUT / given.part)
    sheet.save(OUT / given.part / "sheet.parquet")
    told = [shares(sheet), pairs(sheet, [("hybrid", other) for other in controls])]
    (OUT / given.part / "table.md").write_text("\n\n".join(map(str, told)) + "\n", "utf-8")
    print(f"Open {page(sheet, OUT / given.part, reference=controls[-1]).as_uri()} in a browser.")


if __name__ == "__main__":
    main()
