"""Ask map-guided, retrieved, learned and planned catches about the same situations (H18).

python -m experiments 24_all_methods SEED [--count N] [--on W,Q,natural]   goes on where it stopped

Writes a sheet and its page into out/, and table.md and figure.png beside this file.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path

import numpy as np

from gcm_learn.artifacts import shipped
from gcm_learn.evaluation import Condition, Entrant, Sheet, Table, ask, cases, page, pairs, shares
from gcm_learn.plots import sheet_figures

HERE = Path(__file__).parent
OUT, MODELS = HERE / "out", shipped("models")
SUITES, CONDITIONS = ("L", "W", "Q", "U", "natural"), [Condition(), Condition(0.02)]
ROWS = {
    "gcm": "map", "ppo-guide": "learned by a map", "recall": "retrieved", "recall-map": "retrieved",
    "ppo": "learned", "ppo-clone": "learned", "search": "planned", "marching": "planned",
}  # fmt: skip
OTHERS = {
    "ppo, seed 1": "scratch-1", "ppo, seed 2": "scratch-2", "clone of search": "clone-search",
    "ppo, 0.6 M steps": "ppo-former",
}  # fmt: skip
"""Entrants of the hypothesis alone, by their folders in `others/`."""
PAIRS = [
    *((name, "search") for name in [*ROWS, *OTHERS] if name != "search"),
    ("ppo", "clone of search"), ("ppo", "ppo, 0.6 M steps"), ("ppo-guide", "ppo"),
    ("ppo-clone", "ppo"), ("recall-map", "recall"),
]  # fmt: skip
HEAD = ["entrant", "kind", "W and Q, 0 ms [%]", "W and Q, 20 ms [%]", "natural, 20 ms [%]",
        "touched [%]", "median [ms]", "training [h]"]  # fmt: skip
TRAINED = {
    "recall": ["encoder"], "recall-map": ["encoder", "encoder-map"], "ppo": ["ppo"],
    "ppo-guide": ["ppo-guide"], "ppo-clone": [HERE / "others/clone-search", "ppo-clone"],
}  # fmt: skip


def hours(name: str) -> str:
    """Return the hours of a processor in the logs of what an entrant learned from."""
    if name not in TRAINED:
        return "–"
    logs = [(MODELS / folder / "log.jsonl").read_text("utf-8") for folder in TRAINED[name]]
    last = [json.loads(log.splitlines()[-1]) for log in logs]
    return f"{sum(row.get('processor', row['seconds']) for row in last) / 3600:.2f}"


def first(sheet: Sheet) -> Table:
    """Return the table of README: W and Q pooled, and the natural mix."""
    both = sheet.where((sheet["suite"] == "W") | (sheet["suite"] == "Q"))
    parts = [both.where(thinking="0 ms"), both.where(thinking="20 ms"),
             sheet.where(suite="natural", thinking="20 ms")]  # fmt: skip
    found = [shares(part) for part in parts]
    told = [dict(zip(table["entrant"], table.text(), strict=True)) for table in found]
    caught, touched, median = (
        found[0].columns.index(word) for word in ("caught [%]", "touched [%]", "median [ms]")
    )
    return Table(HEAD, [
        [name, kind, *(rows[name][caught] for rows in told), told[1][name][touched],
         told[1][name][median], hours(name)]
        for name, kind in ROWS.items()
    ])  # fmt: skip


def slow(sheet: Sheet) -> Table:
    """Return the 99 % quantiles of processor times, by suite."""
    suites, rows = sheet.each("suite"), []
    for name in sheet.each("entrant"):
        parts = [sheet.where(entrant=name, suite=suite) for suite in suites]
        rows.append([name, *(float(np.quantile(p["ms"] * p["factor"], 0.99)) for p in parts)])
    return Table(["99 % [ms]", *suites], rows)


def main() -> None:
    """Ask, and write what came of it."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("seed", type=lambda text: int(text, 16), help="hexadecimal")
    parser.add_argument("--count", type=int, default=300, help="situations of each suite")
    parser.add_argument("--on", default=",".join(SUITES), help="suites")
    given = parser.parse_args()
    found = cases(*given.on.split(","), count=given.count, seed=given.seed)
    who = [Entrant(name, name) for name in ROWS]
    who += [Entrant(name, str(HERE / "others" / folder)) for name, folder in OTHERS.items()]
    sheet = ask(who, found, CONDITIONS, keep=OUT)
    sheet.save(OUT / "sheet.parquet")
    counted = sheet.where((sheet["suite"] == "W") | (sheet["suite"] == "Q"))
    told = [first(sheet), shares(sheet, ("suite", "entrant")), slow(sheet),
            pairs(counted, PAIRS), pairs(counted, PAIRS, "suite")]  # fmt: skip
    (HERE / "table.md").write_text("\n\n".join(map(str, told)) + "\n", "utf-8")
    ours = shares(counted.where(thinking="20 ms"))
    spans = dict(zip(ours["entrant"], ours["caught [%]"], strict=True))
    colours = sheet_figures.colours_of(list(spans))
    shown = {name: spans[name] for name in ROWS}
    figure = sheet_figures.spans_figure("W and Q, 20 ms charged", "caught [%]", shown, colours)
    figure.savefig(HERE / "figure.png", dpi=130)
    print(f"Open {page(sheet, OUT, reference='search').as_uri()} in a browser.")


if __name__ == "__main__":
    main()
