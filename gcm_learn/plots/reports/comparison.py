"""The report of a comparison: one page that holds its pictures, and the figures for elsewhere."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from gcm_learn.evaluation import Entry, Results, compare, draw_suite, suite_file, verdict, who
from gcm_learn.plots.figures import charged
from gcm_learn.plots.figures import comparison as figures
from gcm_learn.plots.figures.failures import FILM, failure_film, failures_figure, failures_of
from gcm_learn.plots.reports import tables
from gcm_learn.plots.reports.page import (
    Picture,
    Section,
    Table,
    embedded,
    picture_of,
    render,
    section,
    words,
)
from gcm_learn.policies import actor_names
from gcm_learn.recall import has_memory

PAGE = "report.html"
WORDS = words("comparison")
PLANNERS = ("straight", "gcm", "marching", "layered")
RECALLING = ("recall", "hybrid")
TRIED = "@20"  # actors are shown as they act, and tried out
CHARGED = 3  # situations of each stratum for which thinking is charged


def write_report(
    results: Results,
    entries: Sequence[Entry],
    out: Path,
    reference: str | None = None,
    noise: Results | None = None,
    back: str = "",
) -> Path:
    """Write the page and its figures.

    Parameters
    ----------
    results : Results
    entries : sequence of Entry
        The situations of the results.
    out : Path
        Folder, which must be there; the page is ``report.html``, figures are also ``.png`` files.
    reference : str, optional
        Method that the others are compared with; by default the one that catches most.
    noise : Results, optional
        Of `compare_under_noise`.
    back : str
        Address of the page that links to this one.

    Returns
    -------
    Path
        The page; it needs no other file.
    """
    reference = reference or _best(results)
    opening = _kept(out, "rates", figures.rates_figure(results))
    sections = [
        _who(results),
        _numbers(results, out),
        _paired(results, reference, out),
        *_thinking(results, out),
        *_under_noise(noise, out),
        _by_family(results, out),
        *_failures(results, entries, out),
        *_learning(results, out),
    ]
    page = out / PAGE
    text = render(WORDS["title"], _lead(results), opening, (), sections, back=back)
    page.write_text(text, "utf-8")
    return page


def _best(results: Results) -> str:
    rates = {n: np.mean(results.of_method(n)["outcome"] == "caught") for n in results.methods}
    return max(rates, key=lambda name: rates[name])


def _kept(out: Path, name: str, figure: Figure, about: str = "", *, number: int = 0) -> Picture:
    """Write a figure, or one of many, and put it into the page with the caption of its name."""
    caption = WORDS["captions"][name].format(about=about)
    file = f"{name}-{number}.png" if number else f"{name}.png"
    return picture_of(figure, out / file, caption, embed=True)


def _lead(results: Results) -> list[str]:
    one = results.of_method(results.methods[0])
    strata = ", ".join(
        f"{int((one['stratum'] == s).sum())} of {s} ({tables.STRATA[s]})" for s in results.strata
    )
    names = sorted(set(one["suite"].tolist()))
    told = {
        "verdict": verdict(results),
        "methods": len(results.methods),
        "count": len(one),
        "suites": f"suite{'s' * (len(names) > 1)} {', '.join(names)}",
        "strata": strata,
    }
    return [text.format(**told) for text in WORDS["lead"]]


def _who(results: Results) -> Section:
    """A line for each method, and what it is made of."""
    known = [name for name in results.methods if name not in results.given]
    listed = [Table(("method", "what it does"), [list(row) for row in who(known)])]
    made = tables.costs_table(known)
    if made is None:
        return section(WORDS, "who", listed, text=())
    return section(WORDS, "who", [*listed, made])


def _numbers(results: Results, out: Path) -> Section:
    """Outcomes of the situations, and tables of all measures."""
    there = figures.reachable(results)
    pictures = [
        _kept(out, "outcomes", figures.outcomes_figure(results)),
        _kept(out, "moves", figures.moves_figure(there)),
    ]
    listed = [tables.strata_table(results), tables.measures_table(there)]
    faults = tables.faults_table(results)
    listed += [faults] if faults else []
    return section(WORDS, "numbers", [*listed, *tables.by_stratum(results)], pictures)


def _paired(results: Results, reference: str, out: Path) -> Section:
    folded = [
        tables.pairs_table(figures.of_stratum(results, s), reference, f"{s}: {tables.STRATA[s]}")
        for s in figures.catchable_strata(results)
    ]
    pictures = []
    if len(results.methods) > 1:
        drawn = figures.pairs_figure(results, reference)
        pictures.append(_kept(out, "pairs", drawn, reference))
    listed = [tables.pairs_table(results, reference), *folded]
    return section(WORDS, "pairs", listed, pictures, told={"reference": reference})


def _thinking(results: Results, out: Path) -> list[Section]:
    """Charged thinking, if it was measured: a chart, or a chart for each of many methods."""
    drawn = charged.charged_figures(results)
    if not drawn:
        return []
    strata = charged.charged_strata(results)
    folded = [
        tables.charged_table(figures.of_stratum(results, s), f"{s}: {tables.STRATA[s]}")
        for s in (strata if len(strata) > 1 else ())
    ]
    listed = [tables.charged_table(figures.reachable(results)), *folded]
    pictures = [_kept(out, "charged", drawn[0])] if len(drawn) == 1 else [
        _kept(out, "charged-many", figure, figure.axes[0].get_title(), number=k)
        for k, figure in enumerate(drawn, 1)
    ]  # fmt: skip
    told = {"strata": ", ".join(strata), "many": WORDS["many"] if len(drawn) > 1 else ""}
    return [section(WORDS, "thinking", listed, pictures, told=told)]


def _under_noise(noise: Results | None, out: Path) -> list[Section]:
    """Inexact perception, if it was measured."""
    if noise is None:
        return []
    picture = _kept(out, "noise", figures.noise_figure(noise))
    return [section(WORDS, "noise", [tables.noise_table(noise)], [picture])]


def _by_family(results: Results, out: Path) -> Section:
    there = figures.reachable(results)
    pictures = [_kept(out, "families", figures.families_figure(there))]
    if np.any(there["outcome"] == "touched"):
        drawn = figures.families_figure(there, "touched")
        pictures.append(_kept(out, "families-touched", drawn))
    return section(WORDS, "families", tables.by_family(results), pictures)


def _failures(results: Results, entries: Sequence[Entry], out: Path) -> list[Section]:
    """Touches and misses, drawn, and some of them as films."""
    found = failures_of(results, entries)
    if not found:
        return []
    pictures = [_kept(out, "failures", failures_figure(found))]
    for caption, data in failure_film(found):
        pictures.append(Picture(embedded(data, "gif"), caption, FILM))
    return [section(WORDS, "failures", (), pictures)]


def _learning(results: Results, out: Path) -> list[Section]:
    figure = figures.learning_figure(results)
    if figure is None:
        return []
    return [section(WORDS, "learning", (), [_kept(out, "learning", figure)])]


def shipped_methods() -> list[str]:
    """Planners, those with a memory if one is there, and all trained actors."""
    names = list(PLANNERS)
    if has_memory():
        names += RECALLING
    for actor in actor_names():
        names += [actor, actor + TRIED]
    return names


def build_comparison(
    out: Path,
    count: int,
    progress: Callable[[str], None],
    workers: int | None = None,
    *,
    back: str = "",
) -> Path | None:
    """Compare the shipped methods; return the page, None without a shipped suite.

    `back` is the address of the page that links to the report.
    """
    if suite_file("demo") is None:
        return None
    entries = draw_suite("demo", count)
    names = shipped_methods()
    progress(f"Comparing {', '.join(names)} on {count} situations")
    results = compare(names, entries, charge=CHARGED, workers=workers)
    out.mkdir(parents=True, exist_ok=True)
    progress("Drawing the comparison")
    return write_report(results, entries, out, back=back)
