"""The report of a comparison: its tables, its failures and their films."""

from __future__ import annotations

import io

import numpy as np
import pytest
from matplotlib.figure import Figure
from PIL import Image

from gcm_learn import families, solve
from gcm_learn.arms import forward_in_space
from gcm_learn.evaluation.contest import compare
from gcm_learn.evaluation.measures import measured
from gcm_learn.evaluation.suites import Entry, draw_suite
from gcm_learn.evaluation.table import Results
from gcm_learn.planners import get_planner
from gcm_learn.plots import write_report
from gcm_learn.plots.figures import comparison as figures
from gcm_learn.plots.figures import failures, style
from gcm_learn.plots.figures.charged import TOGETHER, charged_figure, charged_figures
from gcm_learn.plots.figures.diagram import MissedDiagram
from gcm_learn.plots.reports import tables
from gcm_learn.plots.reports.page import SHARPNESS
from gcm_learn.rendering import body_poses
from tests.rendering.test_rendering import near

NAMES = ["straight", "layered", "clone"]


@pytest.fixture(scope="module")
def entries() -> list[Entry]:
    """Situations of all strata, among them touches of the clone."""
    return draw_suite("demo", 24)


@pytest.fixture(scope="module")
def results(entries) -> Results:
    """What becomes of them."""
    return compare(NAMES, entries, charge=1, workers=1)


@pytest.fixture(scope="module")
def found(results, entries):
    """Failures of the comparison."""
    return failures.failures_of(results, entries)


def with_outcomes(results, method, outcomes, parts):
    """The results with other outcomes of a method."""
    columns = {name: column.copy() for name, column in results.columns.items()}
    here = np.flatnonzero(columns["entrant"] == method)[: len(outcomes)]
    columns["outcome"][here], columns["part"][here] = outcomes, parts
    return Results(columns)


def test_touches_are_told_by_part(results):
    outcomes, parts = ["touched"] * 3 + ["caught"], ["forearm", "forearm", "upper arm", None]
    made = with_outcomes(results, "straight", outcomes, parts)
    mine = made.where((made["entrant"] == "straight") & (np.cumsum(np.ones(len(made))) <= 4))
    m = measured(mine, "straight")
    assert (m.forearm, m.upper_arm, m.collisions.value) == (0.5, 0.25, 0.75)
    (row,) = tables.measures_table(mine).rows
    assert row[2:4] == ["50.0", "25.0"]


def test_all_measures_are_told_by_stratum_and_by_family(results):
    by_stratum, by_family = tables.by_stratum(results), tables.by_family(results)
    assert [table.fold[0] for table in by_stratum] == results.strata
    there = results.where(results["stratum"] != "U")
    assert [table.fold.split()[0] for table in by_family] == there.families
    for table in (*by_stratum, *by_family):
        assert [row[0] for row in table.rows] == NAMES
        assert all(len(row) == len(tables.MEASURES) for row in table.rows)
    share = np.mean(results.of_method("layered")["stratum"] == "W") * 24
    assert f"({share:.0f} situations)" in by_stratum[results.strata.index("W")].fold


def test_bars_of_outcomes_add_up(results):
    figure = figures.outcomes_figure(results)
    for ax in figure.axes[: len(results.strata)]:
        widths = np.array([patch.get_width() for patch in ax.patches])
        assert np.all(widths >= -1e-9)
        assert widths.sum() == pytest.approx(100.0 * len(NAMES))


def test_failures_are_failures_and_somebody_shows_how_to_catch(found, results):
    assert 3 <= len(found) <= failures.MOST
    outcomes = {(r[0], r[1]): r[2] for r in zip(results["entrant"], results["index"],
                                                results["outcome"], strict=True)}  # fmt: skip
    for failure in found:
        assert failure.outcome == outcomes[failure.name, failure.entry.index] != "caught"
        assert failure.entry.stratum != "U"
        assert failure.better == "layered" and failure.example is not None
    touched = [failure for failure in found if failure.outcome == "touched"]
    assert touched and found[0] is touched[0], "who touches comes first"


def test_films_show_different_methods_and_families(found):
    films = failures.failure_film(found)
    assert len(films) == 2  # layered catches all, so that two are left
    assert "touches with the" in films[0][0] and "layered catches (grey)" in films[0][0]
    for _, data in films:
        film = Image.open(io.BytesIO(data))
        assert film.size == (failures.FILM, failures.FILM)
        assert len(data) < 400_000
        moved = []
        for frame in range(film.n_frames):
            film.seek(frame)
            moved.append(np.asarray(film.convert("RGB")))
        assert np.any(moved[0] != moved[-1])
        assert tuple(moved[0][0, -1]) == (255, 255, 255)


def test_failures_in_space_are_drawn_too(tmp_path):
    drawn = [families.draw("window-space", 1, k) for k in range(3)]
    entries = [Entry("mine", k, s, "window-space", "W", 1.0) for k, s in enumerate(drawn)]
    assert all(solve(s, "layered").caught for s in drawn)  # compiles, as slow methods are not shown
    results = compare(["straight", "layered"], entries, charge=0, workers=1)
    found = failures.failures_of(results, entries)
    assert found and {failure.name for failure in found} == {"straight"}
    assert all(f.trajectory is None and f.better == "layered" for f in found)
    failed = len(found)
    for ax in failures.failures_figure(found).axes[:failed]:
        (image,) = ax.images
        assert np.ptp(image.get_array(), axis=(0, 1)).min() > 0.5
    ((caption, data),) = failures.failure_film(found)
    film = Image.open(io.BytesIO(data))
    first = np.asarray(film.convert("RGB"))
    film.seek(film.n_frames - 1)
    assert "layered catches (grey)" in caption
    assert np.any(first != np.asarray(film.convert("RGB")))
    assert '<h2 id="failures">' in write_report(results, entries, tmp_path).read_text()


@pytest.mark.parametrize("touches", [True, False])
def test_films_of_failures_among_solids_show_the_target_from_the_start(touches):
    situation = families.paper_scene("fig8")
    caught = get_planner("gcm").plan(situation).trajectory
    missed = MissedDiagram(situation, caught if touches else None, caught, touches)
    for share in (0.0, 0.5, 1.0):
        ax = Figure().subplots()
        missed.show(ax, share * caught.duration, 200, caught.duration)
        (image,) = ax.images
        assert near(np.asarray(image.get_array()), style.TARGET) > 1e-4
        marks = [line for line in ax.lines if line.get_marker() == "o"]
        assert len(marks) == (touches and share == 1.0)


def test_without_an_example_a_failure_in_space_ends_when_its_target_is_closest():
    situation = families.draw("late-target-space", 1, 0)
    entry = Entry("mine", 0, situation, "late-target-space", "W", 1.0)
    failure = failures.Failure("straight", entry, "declined", None, None, "", None)
    hand = forward_in_space(situation.arm, situation.arm.joints)[1]
    (target,) = (k for k, body in enumerate(situation.bodies) if body.role == "target")

    def away(t):
        return np.linalg.norm(body_poses(situation, [t])[0][0, target] - hand)

    assert 0.0 <= failure.duration <= situation.horizon
    others = np.linspace(0.0, situation.horizon, 7)
    assert away(failure.duration) <= min(map(away, others)) + 0.05 * situation.arm.reach
    assert len(failures.failures_figure([failure]).axes[0].images) == 1


def test_one_page_holds_everything(results, entries, tmp_path):
    text = write_report(results, entries, tmp_path).read_text()
    assert "src=" in text and all(part.startswith("data:") for part in text.split('src="')[1:])
    assert len(text) < 4_000_000
    for anchor in ("who", "numbers", "pairs", "thinking", "families", "failures", "learning"):
        assert f'<h2 id="{anchor}">' in text
    assert text.count("<details>") == len(tables.by_family(results)) + 4 + 3 + 3
    quiet = Results({**results.columns, "outcome": np.full(len(results), "caught", object)})
    assert '<h2 id="failures">' not in write_report(quiet, entries, tmp_path).read_text()


def of_many(results, count):
    """The results of a method under so many names."""
    mine = results.of_method("layered")
    columns = {n: np.concatenate([v] * count) for n, v in mine.columns.items()}
    names = [f"method {k}" for k in range(count)]
    columns["entrant"] = np.repeat(names, len(mine)).astype(object)
    return Results(columns, dict.fromkeys(names, "layered"))


def test_many_methods_have_a_chart_each_with_the_others_in_grey(results):
    many = of_many(results, TOGETHER + 1)
    drawn = charged_figures(many)
    assert [figure.axes[0].get_title() for figure in drawn] == many.methods
    for name, figure in zip(many.methods, drawn, strict=True):
        (ax,) = figure.axes
        colours = [line.get_color() for line in ax.lines if len(line.get_xdata()) > 1]
        assert colours == [style.FAINT] * TOGETHER + [figures.colour_of(many, name)]
        assert ax.get_ylim() == (-2, 104)
    (together,) = charged_figures(of_many(results, TOGETHER))
    assert len(together.axes) == len(results.strata) - 1


def test_charts_of_many_methods_are_readable_on_a_phone(results, entries, tmp_path, browser):
    path = write_report(of_many(results, TOGETHER + 1), entries, tmp_path)
    page = browser.new_page(viewport={"width": 400, "height": 800})
    page.goto(path.as_uri())
    assert page.evaluate("document.documentElement.scrollWidth") <= 400
    charts = page.locator("#thinking ~ .row").first.get_by_role("img")
    assert charts.count() == TOGETHER + 1
    for chart in charts.all():
        natural = chart.evaluate("image => image.naturalWidth") / SHARPNESS
        assert chart.bounding_box()["width"] > 0.95 * natural  # not made smaller
    first = page.locator("#thinking ~ .row").first.get_by_title("Enlarge").first
    first.focus()
    page.keyboard.press("Enter")
    assert page.locator("#large img").get_attribute("alt") == "method 0"
    page.keyboard.press("Escape")
    page.keyboard.press("Tab")
    assert page.evaluate("document.activeElement.querySelector('img').alt") == "method 1"
    page.close()


def test_what_was_not_measured_is_left_out(results):
    columns = dict(results.columns)
    for name in columns:
        if name.startswith("charged"):
            columns[name] = np.full(len(results), None, object)
    assert charged_figure(Results(columns)) is None and charged_figures(Results(columns)) == []
    planners = results.where(results["entrant"] != "clone")
    assert figures.learning_figure(planners) is None
    assert figures.learning_figure(results) is not None


def test_a_family_that_is_not_there_has_no_row(results):
    figure = figures.families_figure(results)
    rows = [label.get_text().split()[0] for label in figure.axes[0].get_yticklabels()]
    assert rows == results.where(results["stratum"] != "U").families
    assert set(rows) <= set(families.family_names())
