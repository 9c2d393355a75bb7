"""The report of a comparison: one page that holds its pictures, and the figures for elsewhere."""

from __future__ import annotations

import base64
import io
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from gcm_learn.evaluation.blurred import blurred
from gcm_learn.evaluation.measures import Interval, Measures, declines, measured, pairs
from gcm_learn.evaluation.suites import Entry
from gcm_learn.evaluation.table import Results
from gcm_learn.plots import comparison_figures as figures
from gcm_learn.plots.comparison_words import verdict, who
from gcm_learn.plots.failures import failure_film, failures_figure
from gcm_learn.plots.page import Picture, Section, Table, render

PAGE = "report.html"
TITLE = "Who catches what"
SCALE, SHARPNESS = 80, 1.5  # [CSS pixels per inch], pixels of an image per CSS pixel
STRATA = {
    "L": "a straight line works",
    "W": "a way round is needed",
    "Q": "waiting is needed",
    "U": "no catch is possible",
}


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
        Entrant that the others are compared with; by default the one that catches most.
    noise : Results, optional
        Of `compare_blurred`.

    Returns
    -------
    Path
        The page; it needs no other file.
    """
    reference = reference or _best(results)
    opening = _kept(figures.rates_figure(results), out / "rates.png", _opening_caption(results))
    sections = [
        _who(results),
        _numbers(results),
        _paired(results, reference),
        *_thinking(results, out),
        *_blurred(noise),
        _speed(results, out),
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
        f"{int((one['stratum'] == s).sum())} of {s} ({STRATA[s]})" for s in results.strata
    )
    suites = ", ".join(sorted(set(one["suite"].tolist())))
    return [
        verdict(results),
        f"{len(results.entrants)} ways to catch, all on the same {len(one)} situations of the "
        f"suite {suites}: {counts}. The oracle has decided the strata.",
        "A planner's catch has been verified before it counts, and what it cannot verify it "
        "declines; an actor (a trained network that acts step by step) is not verified and may "
        "touch. With `@20` an actor's way is tried out with the predictor, up to 20 times, and "
        "verified before the hand moves. Bars are 95 % intervals.",
    ]


def _opening_caption(results: Results) -> str:
    return (
        "Share of situations that are caught, by what they take; the lines are 95 % intervals, "
        "crosses the share in which an obstacle is touched."
    )


def percent(interval: Interval | None) -> str:
    """A share with its interval, in per cent."""
    if interval is None or not np.isfinite(interval.value):
        return "–"
    low, high = 100 * interval.low, 100 * interval.high
    return f"{100 * interval.value:.1f} ({low:.0f}–{high:.0f})"


def _number(value: float, form: str = ".2f") -> str:
    return format(value, form) if np.isfinite(value) else "–"


def _who(results: Results) -> Section:
    """A line for each entrant."""
    rows = [list(row) for row in who(results.entrants)]
    return Section("who", "Who they are", [], [Table(("entrant", "what it does"), rows)])


def _numbers(results: Results) -> Section:
    """Tables of everything measured: over reachable situations, and by stratum."""
    reachable = results.where(results["stratum"] != "U")
    columns = (
        "entrant", "caught [%]", "touched [%]", "of these forearm [%]", "time / oracle",
        "way [forearms]", "clearance", "peak hand [1/s]", "peak joint [rad/s]",
        "latency, median [ms]", "95 %",
    )  # fmt: skip
    rows = [_row(measured(reachable, name)) for name in results.entrants]
    strata = [s for s in results.strata if s != "U"]
    extra = ("declines of U [%]",) if "U" in results.strata else ()
    by_stratum = []
    for name in results.entrants:
        cells = [percent(measured(_of(results, s), name).caught) for s in strata]
        by_stratum.append([name, *cells, *([percent(declines(results, name))] if extra else [])])
    headings = ("entrant", *(f"{s} caught [%]" for s in strata), *extra)
    text = [
        "First over all situations that can be caught at all, then by stratum. Times are those of "
        "the catch over the oracle's, where both catch; latency is processor time on one core "
        "before the hand moves (of actors, for one step).",
        "To decline an unreachable situation is to touch nothing in it.",
    ]
    tables = [Table(columns, rows), Table(headings, by_stratum)]
    return Section("numbers", "In numbers", text, tables)


def _of(results: Results, stratum: str) -> Results:
    return results.where(results["stratum"] == stratum)


def _row(m: Measures) -> list[str]:
    return [
        m.entrant, percent(m.caught), percent(m.touched), _number(100 * m.forearm, ".0f"),
        _number(m.ratio, ".3f"), _number(m.length), _number(m.clearance, ".3f"),
        _number(m.peak_hand), _number(m.peak_joint, ".0f"), _number(m.latency, ".1f"),
        _number(m.latency_95, ".1f"),
    ]  # fmt: skip


def _paired(results: Results, reference: str) -> Section:
    columns = ("entrant", "caught less [points]", "95 %", "only it", f"only {reference}", "p")
    rows = []
    for pair in pairs(results, reference):
        d = pair.difference
        span = f"{100 * d.low:.1f} to {100 * d.high:.1f}"
        p = f"{pair.p:.3f}" if pair.p >= 1e-3 else f"{pair.p:.0e}"
        more = f"{100 * d.value:+.1f}"
        rows.append([pair.first, more, span, str(pair.only_first), str(pair.only_second), p])
    text = [
        f"Each against {reference}, on the reachable situations: difference of catch rates with a "
        "bootstrap interval stratified by family, situations that only one of the two catches, and "
        "the exact test of McNemar."
    ]
    return Section("pairs", "In pairs", text, [Table(columns, rows)])


def _thinking(results: Results, out: Path) -> list[Section]:
    """Charged thinking, if it was measured."""
    figure = figures.charged_figure(results)
    if figure is None:
        return []
    rows = []
    for name in results.entrants:
        cells = [percent(measured(_of(results, s), name).own) for s in results.strata if s != "U"]
        rows.append([name, *cells])
    columns = ("entrant", *(f"{s}, own latency [%]" for s in results.strata if s != "U"))
    text = [
        "The world runs while an agent thinks: its hand rests, and what it does begins so much "
        "later. The table charges every entrant its own latency of that situation."
    ]
    caption = "Catches of reachable situations over the time that thinking takes."
    picture = _kept(figure, out / "charged.png", caption)
    return [Section("thinking", "While they think", text, [Table(columns, rows)], [picture])]


def _blurred(noise: Results | None) -> list[Section]:
    """Inexact perception, if it was measured."""
    if noise is None:
        return []
    rows = [
        [b.entrant, f"{b.noise:g}", b.way if b.noise else "exact", percent(b.caught),
         _number(100 * b.touched, ".1f"), _number(100 * b.lost, ".1f")]
        for b in blurred(noise)
    ]  # fmt: skip
    columns = ("entrant", "deviation [forearms]", "plans", "caught [%]", "touched [%]", "lost")
    text = [
        "Places of bodies are seen with errors of this standard deviation, velocities with twice "
        "the number in hand speeds, every 50 ms anew; the world judges what the hand does. "
        "Lost are points of what is caught with exact perception. Looks are joined by Kalman's "
        "filter; with a margin the limb is planned as thicker by twice the deviation of what is "
        "known. Reachable situations."
    ]
    return [Section("noise", "When they see inexactly", text, [Table(columns, rows)])]


def _speed(results: Results, out: Path) -> Section:
    caption = "Median latency and catches of reachable situations."
    picture = _kept(figures.latency_figure(results), out / "latency.png", caption)
    return Section("speed", "How fast they think", [], (), [picture])


def _by_family(results: Results, out: Path) -> Section:
    caption = "Catches of reachable situations by family [%]."
    picture = _kept(figures.families_figure(results), out / "families.png", caption)
    return Section("families", "By family", [], (), [picture])


def _failures(results: Results, entries: Sequence[Entry], out: Path) -> list[Section]:
    """Touches and misses, drawn, and two of them as films."""
    figure = failures_figure(results, entries)
    if figure is None:
        return []
    caption = "Bodies at the end, the arm where it touched; the ring is where it happened."
    pictures = [_kept(figure, out / "failures.png", caption)]
    film = failure_film(results, entries)
    if film is not None:
        name, pixels, data = film
        pictures.append(Picture(_embedded(data, "gif"), name, pixels))
    text = ["Reachable situations in which an actor touched an obstacle."]
    return [Section("failures", "What goes wrong", text, (), pictures)]


def _learning(results: Results, out: Path) -> list[Section]:
    figure = figures.learning_figure(results.entrants)
    if figure is None:
        return []
    caption = "Catches of validation situations during training."
    picture = _kept(figure, out / "learning.png", caption)
    return [Section("learning", "How they learned", [], (), [picture])]


def _kept(figure: Figure, path: Path, caption: str) -> Picture:
    """Write a figure, and embed it."""
    buffer = io.BytesIO()
    figure.savefig(buffer, dpi=SHARPNESS * SCALE, format="png")
    path.write_bytes(buffer.getvalue())
    width = round(SCALE * figure.get_figwidth())
    return Picture(_embedded(buffer.getvalue(), "png"), caption, width)


def _embedded(data: bytes, kind: str) -> str:
    return f"data:image/{kind};base64,{base64.b64encode(data).decode()}"
