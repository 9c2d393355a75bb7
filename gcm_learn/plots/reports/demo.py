"""The whole story in one folder: scenes, figures, films, random situations and a page."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from gcm_learn.families import CAPTION_INSTANTS, PAPER_SCENES, gate_scene, random_planar
from gcm_learn.planners import Plan, broken_promise, solve
from gcm_learn.plots.figures import style
from gcm_learn.plots.figures.film import FILM_DPI, FRAME_TIME, FRAMES, WIDTH, animate
from gcm_learn.plots.figures.paper import draw_figure
from gcm_learn.plots.figures.sheets import engines_figure, mapped, sheets_figure
from gcm_learn.plots.figures.summary import Tally, summary_figure, tally
from gcm_learn.plots.reports.catches import kept_catches
from gcm_learn.plots.reports.film_page import write_film_page
from gcm_learn.plots.reports.page import (
    Picture,
    Section,
    Table,
    number,
    picture_of,
    render,
    section,
    words,
)
from gcm_learn.seeding import rng
from gcm_learn.situation import Situation, write_situations

ENGINES = ("gcm", "marching")
PLANNERS = ("gcm", "marching", "layered", "straight")
EXTRA_FIGURES = {"fig8": ("fig7",)}  # shown in the section of another figure's scene
OPENING = "fig3"  # the scene whose film opens the page
IN_SPACE = 20  # frames of a film of an arm in space, before the look around
WARM_UP = ("fig2", "fig5", "fig8")  # between them they use all compiled code

WORDS = words("demo")
Progress = Callable[[str], None]


@dataclass(frozen=True)
class Solved:
    """A situation and the plans for it, by planner."""

    situation: Situation
    plans: dict[str, Plan]


def build_demo(
    out: Path, seed: int, n_random: int, progress: Progress, beside: Sequence[str] = ()
) -> Path:
    """Solve the paper's scenes and random ones; write pictures and a page about them.

    Parameters
    ----------
    out : Path
        Folder; made when it is missing. Files of an earlier demo are overwritten.
    seed : int
        Root of the random situations.
    n_random : int
        How many of them.
    progress : callable
        Called with a sentence at every step.
    beside : sequence of str
        Pages that will lie in the folder as well: names in `beside` of the words.

    Returns
    -------
    Path
        The page, ``index.html``.
    """
    out.mkdir(parents=True, exist_ok=True)
    progress("Compiling")
    for make in (*(PAPER_SCENES[name] for name in WARM_UP), gate_scene):
        _solved(make(), PLANNERS)  # so that the planning times told below are those of planning
    progress("Solving the paper's scenes")
    scenes = [_solved(make(), ENGINES) for make in PAPER_SCENES.values()]
    write_situations(out / "paper.jsonl", [scene.situation for scene in scenes])
    sections = []
    for scene in scenes:
        progress(f"Drawing {scene.situation.name}")
        sections.append(_scene_section(out, scene))
    sections.append(_overview(scenes))
    progress("Drawing a gate that opens")
    sections.append(_waiting_section(out))
    progress("Drawing arms in space")
    sections.append(_space_section(out))
    if n_random > 0:
        progress(f"Solving {n_random} random situations")
        sections.append(_random_section(out, seed, n_random))
    if beside:
        told = [WORDS["beside"][name] for name in beside]
        sections.append(section(WORDS, "beside", text=told))
    sections.append(section(WORDS, "more"))
    opening = next(_film(scene, "gcm") for scene in scenes if scene.situation.name == OPENING)
    page = out / "index.html"
    page.write_text(render(WORDS["title"], WORDS["lead"], opening, style.KEY, sections), "utf-8")
    return page


def _solved(situation: Situation, planners: Sequence[str]) -> Solved:
    return Solved(situation, {name: solve(situation, name) for name in planners})


def _overview(scenes: Sequence[Solved]) -> Section:
    columns = (
        "scene",
        "paper: contact [τ]",
        *(f"{engine}: contact [τ]" for engine in ENGINES),
        "gcm against paper",
        "gcm: catch [s]",
        "gcm: clearance [forearms]",
        *(f"{engine}: planning [ms]" for engine in ENGINES),
    )
    rows = [_overview_row(scene) for scene in scenes]
    return section(WORDS, "instants", [Table(columns, rows)])


def _overview_row(scene: Solved) -> list[str]:
    name = scene.situation.name
    caption = CAPTION_INSTANTS[name][-1] if name in CAPTION_INSTANTS else None
    contacts = {engine: _contact(scene.plans[engine]) for engine in ENGINES}
    plan, ours = scene.plans["gcm"], contacts["gcm"]
    both = caption is not None and ours is not None
    return [
        name,
        number(caption, ".0f"),
        *(number(contacts[engine], ".0f") for engine in ENGINES),
        f"{100 * (ours / caption - 1):+.1f} %" if both else "–",  # type: ignore[operator]
        number(plan.catch_time, ".3f") if plan.status == "caught" else plan.status,
        number(plan.clearance, ".3f"),
        *(number(scene.plans[engine].planning_ms, ".1f") for engine in ENGINES),
    ]


def _contact(plan: Plan) -> float | None:
    return None if plan.map is None else plan.map.interception_tau


def _scene_section(out: Path, scene: Solved) -> Section:
    name = scene.situation.name
    drawn = (*EXTRA_FIGURES.get(name, ()), name)
    pictures = [_kept(out, figure, draw_figure(figure)) for figure in drawn]
    pictures.append(_film(scene, "gcm"))
    animate(scene.situation, scene.plans["gcm"], out / pictures[-1].file)
    maps = engines_figure(scene.situation, scene.plans)
    caption = WORDS["captions"]["engines"]
    pictures.append(picture_of(maps, out / f"{name}-engines.png", caption))
    return section(WORDS, name, pictures=pictures)


def _kept(out: Path, name: str, figure: Figure, told: Mapping[str, int] | None = None) -> Picture:
    """Write a figure and return its place on the page, with the caption of its name."""
    caption = WORDS["captions"][name].format(**(told or {}))
    return picture_of(figure, out / f"{name}.png", caption)


def _film(scene: Solved, planner: str) -> Picture:
    """Return the place on the page of the film of a planner's movement."""
    plan = scene.plans[planner]
    lasts = scene.situation.horizon if plan.catch_time is None else plan.catch_time
    caption = WORDS["captions"]["film"].format(slower=FRAMES * FRAME_TIME / 1000 / lasts)
    return Picture(f"{scene.situation.name}.gif", caption, round(WIDTH * FILM_DPI))


def _waiting_section(out: Path) -> Section:
    """Solve a situation in which the hand has to wait."""
    scene = _solved(gate_scene(), PLANNERS)
    write_situations(out / "gate.jsonl", [scene.situation])
    plan = mapped(scene.situation, scene.plans["layered"])
    film = _film(scene, "layered")
    animate(scene.situation, plan, out / film.file)
    first = engines_figure(scene.situation, {name: scene.plans[name] for name in ENGINES})
    pictures = [
        _kept(out, "gate", sheets_figure(scene.situation, plan)),
        film,
        _kept(out, "gate-engines", first),
    ]
    rows = [[name, number(p.catch_time, ".3f"), p.message] for name, p in scene.plans.items()]
    table = Table(("planner", "catch [s]", "answer"), rows)
    return section(WORDS, "waiting", [table], pictures)


def _space_section(out: Path) -> Section:
    """Show catches of arms in space: a film and the movement of each, and pages to turn them on."""
    pictures, rows = [], []
    for situation, plan in kept_catches():
        name, lasts = situation.name, plan.catch_time or situation.horizon
        slower = IN_SPACE * FRAME_TIME / 1000 / lasts
        caption = WORDS["captions"]["space-film"].format(name=name, slower=slower)
        animate(situation, plan, out / f"{name}.gif", frames=IN_SPACE)
        pictures.append(Picture(f"{name}.gif", caption, round(WIDTH * FILM_DPI)))
        rows.append([name, number(plan.catch_time, ".3f"), number(plan.clearance, ".3f")])
        if find_spec("plotly") is not None:
            write_film_page(situation, plan, out / f"{name}.html")
    write_situations(out / "space.jsonl", [situation for situation, _ in kept_catches()])
    found = WORDS["sections"]["space"]["text"]
    text = [*found, *_pages_of(out, [row[0] for row in rows])]
    table = Table(("scene", "catch [s]", "clearance [the arm's unit]"), rows)
    return section(WORDS, "space", [table], pictures, text=text)


def _pages_of(out: Path, names: Sequence[str]) -> list[str]:
    """A sentence that leads to the pages that were written."""
    links = [f"[{name}]({name}.html)" for name in names if (out / f"{name}.html").exists()]
    return [WORDS["captions"]["space-pages"].format(links=", ".join(links))] if links else []


def _random_section(out: Path, seed: int, count: int) -> Section:
    """Solve random situations with all planners and summarise them."""
    solved = [_solved(random_planar(rng(seed, k)), PLANNERS) for k in range(count)]
    tallies = [tally(name, [s.plans[name] for s in solved]) for name in PLANNERS]
    broken = {name: _count_broken(solved, name) for name in PLANNERS}
    told = {"count": count, "seed": seed}
    picture = _kept(out, "random", summary_figure(tallies), told)
    return section(WORDS, "random", [_random_table(tallies, broken)], [picture], told=told)


def _count_broken(solved: Sequence[Solved], planner: str) -> int:
    return sum(broken_promise(s.situation, s.plans[planner]) is not None for s in solved)


def _random_table(tallies: Sequence[Tally], broken: dict[str, int]) -> Table:
    columns = (
        "planner",
        "caught",
        "unreachable",
        "start blocked",
        "broken promises",
        "median catch [s]",
        "median clearance [forearms]",
        "median planning [ms]",
    )
    rows = [
        [
            t.planner,
            *(str(t.counts[status]) for status in ("caught", "unreachable", "start_blocked")),
            str(broken[t.planner]),
            number(_median(t.catch_times), ".3f"),
            number(_median(t.clearances), ".3f"),
            number(_median(t.latencies), ".2f"),
        ]
        for t in tallies
    ]
    return Table(columns, rows)


def _median(values: np.ndarray) -> float | None:
    """Median of the finite values; without obstacles a clearance is infinite."""
    finite = values[np.isfinite(values)]
    return float(np.median(finite)) if finite.size else None
