"""Page of a sheet, made in one pass over a list of sections."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from gcm_learn.evaluation import measures
from gcm_learn.evaluation.sections import SECTIONS, WORDS, SheetView, opening
from gcm_learn.evaluation.sheet import Sheet
from gcm_learn.plots import pages

PAGE = "index.html"
QUICK = 20.0  # median thinking that counts as quick [ms]


def page(
    sheet: Sheet,
    out: str | Path,
    *,
    reference: str = "",
    marked: Sequence[str] = (),
    back: str = "",
) -> Path:
    """Write the page of a sheet, which needs no other file.

    Parameters
    ----------
    sheet : Sheet
    out : path-like
        Folder; the page is its ``index.html``.
    reference : str, optional
        Entrant with which the others are compared; by default the one that catches most.
    marked : sequence of str
        Entrants whose curves are thick.
    back : str
        Address of the page that links to this one.
    """
    folder = Path(out)
    folder.mkdir(parents=True, exist_ok=True)
    view = SheetView(sheet, reference or measures.best_of(sheet), folder, marked)
    made = []
    for anchor, part_of in SECTIONS:
        part = part_of(view)
        if part.tables or part.pictures:
            told = {"reference": view.reference}
            made.append(pages.section(WORDS, anchor, part.tables, part.pictures, told=told))
    first, *others = opening(view)
    place = folder / PAGE
    lead = [text.format(**_told(view)) for text in WORDS["lead"]]
    text = pages.render(WORDS["title"], lead, first, (), made, back=back, beside=others)
    place.write_text(text, "utf-8")
    return place


def _told(view: SheetView) -> dict[str, str]:
    cases, suites = len(set(view.sheet["key"].tolist())), view.sheet.each("suite")
    return {
        "verdict": verdict(view.plain),
        "entrants": _several(len(view.names), "entrant"),
        "situations": _several(cases, "situation"),
        "suites": ", ".join(suites) if len(suites) < 4 else _several(len(suites), "suite"),
    }


def _several(count: int, noun: str) -> str:
    return f"{count:,} {noun}{'s' * (count != 1)}"


def verdict(sheet: Sheet) -> str:
    """Return sentences that name the entrant with most catches, of all and of quick entrants."""
    there = sheet.reachable
    if not len(there):
        return "None of these situations can be caught."
    found = measures.shares(there, ("entrant",))
    rows = {row[0]: row for row in found.rows}
    share = {name: row[2].value for name, row in rows.items()}
    times = dict(zip(rows, found["median [ms]"], strict=True))
    best = max(share, key=lambda name: share[name])
    text = f"Of what can be caught, {best} catches most: {100 * share[best]:.0f} %"
    text += f", thinking for {times[best]:.3g} ms (median)."
    equals = [name for name in share if share[name] == share[best] and name != best]
    if equals:
        text += f" Just as many: {', '.join(equals)}."
    quick = [name for name in share if times[name] <= QUICK]
    if quick and best not in quick:
        first = max(quick, key=lambda name: share[name])
        text += (
            f" Of those that think for at most {QUICK:.0f} ms, {first} does: "
            f"{100 * share[first]:.0f} % after {times[first]:.3g} ms."
        )
    return text
