"""The report of a comparison: one page that holds its pictures, and the figures for elsewhere."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from gcm_learn.evaluation import compare, draw_suite
from gcm_learn.evaluation.suites import Entry, suite_file
from gcm_learn.evaluation.table import Results
from gcm_learn.evaluation.verdict import verdict, who
from gcm_learn.plots.figures import comparison as figures
from gcm_learn.plots.figures.failures import FILM, failure_film, failures_figure, failures_of
from gcm_learn.plots.reports import tables
from gcm_learn.plots.reports.page import Picture, Section, Table, embedded, picture_of, render
from gcm_learn.policies.planner import actor_names
from gcm_learn.recall.shipped import has_memory

PAGE = "report.html"
TITLE = "Who catches what"
OPENING = (
    "Share of situations that are caught, by what they take; the lines are 95 % intervals, "
    "crosses the share in which an obstacle is touched."
)
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
        Of `compare_blurred`.

    Returns
    -------
    Path
        The page; it needs no other file.
    """
    reference = reference or _best(results)
    opening = _embed(figures.rates_figure(results), out / "rates.png", OPENING)
    sections = [
        _who(results),
        _numbers(results, out),
        _paired(results, reference, out),
        *_thinking(results, out),
        *_blurred(noise, out),
        _by_family(results, out),
        *_failures(results, entries, out),
        *_learning(results, out),
    ]
    text = render(TITLE, _lead(results), opening, (), sections)
    page = out / PAGE
    page.write_text(text, "utf-8")
    return page


def _best(results: Results) -> str:
    rates = {n: np.mean(results.of_entrant(n)["outcome"] == "caught") for n in results.entrants}
    return max(rates, key=lambda name: rates[name])


def _lead(results: Results) -> list[str]:
    one = results.of_entrant(results.entrants[0])
    counts = ", ".join(
        f"{int((one['stratum'] == s).sum())} of {s} ({tables.STRATA[s]})" for s in results.strata
    )
    names = sorted(set(one["suite"].tolist()))
    suites = f"suite{'s' * (len(names) > 1)} {', '.join(names)}"
    return [
        verdict(results),
        f"{len(results.entrants)} methods, all on the same {len(one)} situations of the "
        f"{suites}: {counts}. The oracle has decided the strata.",
        "A planner's catch has been verified before it counts, and what it cannot verify it "
        "declines; an actor (a trained network that acts step by step) is not verified and may "
        "touch. With `@20` an actor's path is tried out with the predictor, up to 20 times, and "
        "verified before the hand moves. Intervals are of 95 %.",
    ]


def _who(results: Results) -> Section:
    """A line for each method, and what it is made of."""
    rows = [list(row) for row in who(results.entrants)]
    made = tables.costs_table(results.entrants)
    told = (
        "The second table tells what some have learned and hold: remembered catches, or the "
        "weights of a network; steps are those in the arena, minutes by the clock. Who is not in "
        "it plans anew, from nothing but the situation."
    )
    text = [] if made is None else [told]
    both = [Table(("method", "what it does"), rows), *([] if made is None else [made])]
    return Section("who", "Who they are", text, both)


def _numbers(results: Results, out: Path) -> Section:
    """What becomes of the situations, and tables of everything measured."""
    text = [
        "Tables: catches by stratum, then everything over all situations that can be caught. Time "
        "is that of the catch over the oracle's, where both catch (median); path and clearance are "
        "medians of catches, peaks the fastest hand and the 95 % quantile of the fastest joint. "
        "Latency is processor time on one core before the hand moves (of actors, for one step).",
        "To decline an unreachable situation is to touch nothing in it.",
    ]
    there = figures.reachable(results)
    outcomes = figures.outcomes_figure(results)
    moves = figures.moves_figure(there)
    pictures = [
        _embed(outcomes, out / "outcomes.png", "What becomes of the situations of each stratum."),
        _embed(
            moves, out / "moves.png",
            "How catches are thought out and made. Dots are medians, thick lines the middle half, "
            "thin ones all but 5 % at either end.",
        ),
    ]  # fmt: skip
    listed = [tables.strata_table(results), tables.measures_table(there)]
    return Section("numbers", "In numbers", text, [*listed, *tables.by_stratum(results)], pictures)


def _paired(results: Results, reference: str, out: Path) -> Section:
    text = [
        f"Each against {reference}, on the reachable situations: difference of catch rates with a "
        "bootstrap interval stratified by family, situations that only one of the two catches, and "
        "the exact test of McNemar."
    ]
    strata = [s for s in results.strata if s != "U"]
    folded = [
        tables.pairs_table(figures.of_stratum(results, s), reference, f"{s}: {tables.STRATA[s]}")
        for s in strata
    ]
    pictures = []
    if len(results.entrants) > 1:
        figure = figures.pairs_figure(results, reference)
        caption = f"Points that each catches more or less than {reference}, by stratum."
        pictures.append(_embed(figure, out / "pairs.png", caption))
    listed = [tables.pairs_table(results, reference), *folded]
    return Section("pairs", "In pairs", text, listed, pictures)


def _thinking(results: Results, out: Path) -> list[Section]:
    """Charged thinking, if it was measured."""
    figure = figures.charged_figure(results)
    if figure is None:
        return []
    strata = figures.charged_strata(results)
    text = [
        "The world runs while an agent thinks: its hand rests, and what it does begins so much "
        "later. The last column charges every method its own latency of that situation. "
        f"Measured on situations of {', '.join(strata)}."
    ]
    caption = (
        "Catches over the time that thinking takes, by stratum; stars: with the own latency "
        "charged, at its median."
    )
    picture = _embed(figure, out / "charged.png", caption)
    folded = [
        tables.charged_table(figures.of_stratum(results, s), f"{s}: {tables.STRATA[s]}")
        for s in (strata if len(strata) > 1 else ())
    ]
    listed = [tables.charged_table(figures.reachable(results)), *folded]
    return [Section("thinking", "While they think", text, listed, [picture])]


def _blurred(noise: Results | None, out: Path) -> list[Section]:
    """Inexact perception, if it was measured."""
    if noise is None:
        return []
    text = [
        "Places of bodies are seen with errors of this standard deviation, velocities with twice "
        "the number in hand speeds, every 50 ms anew; the world judges what the hand does. "
        "Lost are points of what is caught with exact perception. Observations are joined by "
        "Kalman's filter; with a margin the limb is planned as thicker by twice the deviation "
        "of what is known. Reachable situations."
    ]
    caption = (
        "Catches over the standard deviation of what is seen, by how it is dealt with; dashed: "
        "touches."
    )
    picture = _embed(figures.noise_figure(noise), out / "noise.png", caption)
    table = tables.noise_table(noise)
    return [Section("noise", "When they see inexactly", text, [table], [picture])]


def _by_family(results: Results, out: Path) -> Section:
    there = figures.reachable(results)
    caption = "Caught by family [%]; in brackets, how many situations."
    pictures = [_embed(figures.families_figure(there), out / "families.png", caption)]
    if np.any(there["outcome"] == "touched"):
        figure = figures.families_figure(there, "touched")
        caption = "Touched an obstacle by family [%]; nothing is written where nobody did."
        pictures.append(_embed(figure, out / "families-touched.png", caption))
    text = ["Reachable situations. Everything that is measured is in the folded tables."]
    return Section("families", "By family", text, tables.by_family(results), pictures)


def _failures(results: Results, entries: Sequence[Entry], out: Path) -> list[Section]:
    """Touches and misses, drawn, and some of them as films."""
    found = failures_of(results, entries)
    if not found:
        return []
    caption = (
        "Where it ended; pale: where bodies began. A ring marks the touch; who declined rested. "
        "Grey: the path of a method that catches, and its arm if it has not done so before."
    )
    pictures = [_embed(failures_figure(found), out / "failures.png", caption)]
    for words, data in failure_film(found):
        pictures.append(Picture(embedded(data, "gif"), words, FILM))
    text = ["Reachable situations in which an obstacle was touched, or that were not caught."]
    return [Section("failures", "What goes wrong", text, (), pictures)]


def _learning(results: Results, out: Path) -> list[Section]:
    figure = figures.learning_figure(results)
    if figure is None:
        return []
    caption = (
        "Course of training, on each one's own situations set apart for validation; dashed: "
        "touched. The best was kept."
    )
    picture = _embed(figure, out / "learning.png", caption)
    return [Section("learning", "How they learned", [], (), [picture])]


def _embed(figure: Figure, path: Path, caption: str) -> Picture:
    return picture_of(figure, path, caption, embed=True)


def shipped_methods() -> list[str]:
    """Planners, those with a memory if one is there, and all trained actors."""
    names = list(PLANNERS)
    if has_memory():
        names += RECALLING
    for actor in actor_names():
        names += [actor, actor + TRIED]
    return names


def build_comparison(
    out: Path, count: int, progress: Callable[[str], None], workers: int | None = None
) -> Path | None:
    """Compare what is shipped; returns the page, or None if no suite is shipped either."""
    if suite_file("demo") is None:
        return None
    entries = draw_suite("demo", count)
    names = shipped_methods()
    progress(f"Comparing {', '.join(names)} on {count} situations")
    results = compare(names, entries, charge=CHARGED, workers=workers)
    out.mkdir(parents=True, exist_ok=True)
    progress("Drawing the comparison")
    return write_report(results, entries, out)
