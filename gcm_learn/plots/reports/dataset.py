"""Page of a dataset's situations and maps, stratum by stratum."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes

from gcm_learn.plots.figures import style
from gcm_learn.plots.figures.kinds import pictures_of
from gcm_learn.plots.reports.page import (
    PageTable,
    Picture,
    Section,
    picture_of,
    render,
    section,
    words,
)

if TYPE_CHECKING:  # who has no pyarrow has no datasets, but all other pictures
    from gcm_learn.dataset import Dataset, Manifest, Record

COLUMNS = 4  # records side by side
EACH = 8  # records of a stratum
SMALL = 360  # pixels a side of a panel before a camera
WORDS = words("dataset")
KEY = tuple(entry for entry in style.KEY if entry[1] != "explored by the wave")


def write_dataset_page(records: Dataset, out: Path, each: int = EACH) -> Path:
    """Draw some records of every stratum and a page that shows them.

    Parameters
    ----------
    records : Dataset
    out : Path
        Folder; made when it is missing.
    each : int
        Records of a stratum, where there are as many.

    Returns
    -------
    Path
        The page, ``index.html``.
    """
    out.mkdir(parents=True, exist_ok=True)
    sections, pictures = [], []
    for stratum in "LWQU":
        chosen = records.where(stratum=stratum)
        if len(chosen) == 0:
            continue
        shown = [chosen[int(k)] for k in _evenly(len(chosen), each)]
        picture = _picture(shown, out / f"{stratum}.png", f"{len(chosen)} records in all.")
        pictures.append(picture)
        sections.append(section(WORDS, stratum, pictures=[picture]))
    sections.append(_numbers(records))
    told = {"name": records.spec.name, "planner": _first_choice(records.spec.planners)}
    title, *lead = [text.format(**told) for text in (WORDS["title"], *WORDS["lead"])]
    opening = next((p for p in pictures if p.file == "W.png"), pictures[0])
    page = out / "index.html"
    page.write_text(render(title, lead, opening, KEY, sections), "utf-8")
    return page


def _evenly(count: int, wanted: int) -> np.ndarray:
    """Positions of `wanted` of `count` records, or of all."""
    return np.unique(np.linspace(0, count - 1, min(count, wanted)).round())


def _first_choice(planners: Sequence[str]) -> str:
    return next((n for n in ("layered", "search", *planners) if n in planners), "layered")


def _picture(records: Sequence[Record], path: Path, caption: str) -> Picture:
    """Draw records into a picture file, each as a situation above its map."""
    bands = -(-len(records) // COLUMNS)
    figure, panels = style.panel_grid(2 * bands * COLUMNS, COLUMNS, (2.9, 3.05))
    for ax in panels:
        ax.axis("off")
    for k, record in enumerate(records):
        place = k + k // COLUMNS * COLUMNS
        draw_record(panels[place], panels[place + COLUMNS], record)
    return picture_of(figure, path, caption)


def draw_record(above: Axes, below: Axes, record: Record) -> None:
    """Draw a record's situation above, and its map with a path, or its movement, below."""
    plans = record.plans
    order = sorted(plans, key=lambda name: name != _first_choice(list(plans)))
    plan = next((plans[name] for name in order if plans[name].caught), None)
    moves = None if plan is None else plan.trajectory
    end = record.situation.horizon if moves is None else moves.duration
    pictures = pictures_of(record.situation, plan)
    pictures.draw_record(above, below, record.map, end, SMALL)
    style.title(above, f"{record.family} {record.index}")
    answered = "no catch" if plan is None or moves is None else f"{plan.planner}: {end:.2f} s"
    style.title(below, answered)


def _numbers(records: Dataset) -> Section:
    """Return the section with a table of the dataset's families and their strata."""
    from gcm_learn.dataset import survey

    manifest = survey(records.folder.url)
    shares = ["all", *(f"{share:.1%}" for share in manifest["shares"].values())]
    rows = [[*_family_row(name, row)] for name, row in manifest["families"].items()]
    columns = ("family", *manifest["shares"])
    listed = [PageTable(columns, [*rows, shares])]
    return section(WORDS, "numbers", listed, told={"sentence": _sentence(manifest)})


def _family_row(name: str, strata: dict[str, int]) -> list[str]:
    total = max(sum(strata.values()), 1)
    return [f"{name} ({total})", *(f"{strata.get(s, 0) / total:.0%}" for s in "LWQU")]


def _sentence(manifest: Manifest) -> str:
    audit = manifest["audit"]
    text = f"{manifest['records']} records of {manifest['bytes_per_record']:.0f} bytes each."
    if audit["records"]:
        share = audit["disagreement"]
        text += f" The oracle labelled {audit['records']} of them; {share:.1%} differ."
    return text
