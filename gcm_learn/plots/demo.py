"""The whole story in one folder: scenes, figures, films, random situations and a page."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from gcm_learn.families.examples import gate_scene
from gcm_learn.families.paper import CAPTION_INSTANTS, PAPER_SCENES
from gcm_learn.families.random_planar import random_planar
from gcm_learn.planners import solve
from gcm_learn.planners.plan import Plan
from gcm_learn.plots import style, words
from gcm_learn.plots.animation import FILM_DPI, FRAME_TIME, FRAMES, WIDTH, animate
from gcm_learn.plots.figures import draw_figure
from gcm_learn.plots.maps import draw_colour_bar, latest_arrival, plot_map
from gcm_learn.plots.page import Picture, Section, Table, render
from gcm_learn.plots.recheck import broken_promise
from gcm_learn.plots.sheets import sheets_figure
from gcm_learn.plots.summary import STATUSES, Tally, summary_figure, tally
from gcm_learn.plots.waits import draw_waits
from gcm_learn.plots.workspace import draw_targets
from gcm_learn.seeding import rng
from gcm_learn.situation import Situation, write_situations

ENGINES = ("gcm", "marching")
PLANNERS = ("gcm", "marching", "layered", "straight")
EXTRA_FIGURES = {"fig8": ("fig7",)}  # shown in the section of another figure's scene
OPENING = "fig3"  # the scene whose film opens the page
SCALE = 80  # [CSS pixels per inch] of figures on the page
SHARPNESS = 1.5  # pixels of an image per CSS pixel
WARM_UP = ("fig2", "fig5", "fig8")  # between them they use all compiled code

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
        Pages that will lie in the folder as well: names in `words.BESIDE`.

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
    if n_random > 0:
        progress(f"Solving {n_random} random situations")
        sections.append(_random_section(out, seed, n_random))
    if beside:
        told = [words.BESIDE[name] for name in beside]
        sections.append(Section("beside", "Memory, and who catches what", told))
    sections.append(Section("more", "Your own situations", words.MORE))
    opening = next(_film(scene, "gcm") for scene in scenes if scene.situation.name == OPENING)
    page = out / "index.html"
    page.write_text(render(words.TITLE, words.LEAD, opening, style.KEY, sections), "utf-8")
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
    return Section("instants", "Instants of contact", words.READING, [Table(columns, rows)])


def _overview_row(scene: Solved) -> list[str]:
    name = scene.situation.name
    caption = CAPTION_INSTANTS[name][-1] if name in CAPTION_INSTANTS else None
    contacts = {engine: _contact(scene.plans[engine]) for engine in ENGINES}
    plan, ours = scene.plans["gcm"], contacts["gcm"]
    both = caption is not None and ours is not None
    return [
        name,
        _number(caption, ".0f"),
        *(_number(contacts[engine], ".0f") for engine in ENGINES),
        f"{100 * (ours / caption - 1):+.1f} %" if both else "–",  # type: ignore[operator]
        _number(plan.catch_time, ".3f") if plan.status == "caught" else plan.status,
        _number(plan.clearance, ".3f"),
        *(_number(scene.plans[engine].planning_ms, ".1f") for engine in ENGINES),
    ]


def _contact(plan: Plan) -> float | None:
    return None if plan.map is None else plan.map.contact_tau


def _number(value: float | None, form: str) -> str:
    return "–" if value is None or not np.isfinite(value) else format(value, form)


def _scene_section(out: Path, scene: Solved) -> Section:
    name = scene.situation.name
    heading, text = words.SCENES[name]
    pictures = [
        _save(draw_figure(figure), out / f"{figure}.png", words.CAPTIONS[figure])
        for figure in (*EXTRA_FIGURES.get(name, ()), name)
    ]
    film = _film(scene, "gcm")
    animate(scene.situation, scene.plans["gcm"], out / film.file)
    pictures.append(film)
    maps = engines_figure(scene.situation, scene.plans)
    pictures.append(_save(maps, out / f"{name}-engines.png", words.ENGINES))
    return Section(name, f"{heading} (Fig. {name[3:]})", [text], pictures=pictures)


def _film(scene: Solved, planner: str) -> Picture:
    """Return the place on the page of the film of a planner's movement."""
    plan = scene.plans[planner]
    lasts = scene.situation.horizon if plan.catch_time is None else plan.catch_time
    caption = words.FILM.format(slower=FRAMES * FRAME_TIME / 1000 / lasts)
    return Picture(f"{scene.situation.name}.gif", caption, round(WIDTH * FILM_DPI))


def engines_figure(situation: Situation, plans: dict[str, Plan]) -> Figure:
    """Draw the maps of several engines side by side.

    Parameters
    ----------
    situation : Situation
    plans : dict of str to Plan
        By planner; those without a map leave their panel empty.

    Returns
    -------
    Figure
    """
    figure = style.new_figure(0.6 + 3.0 * len(plans), 3.5)
    panels = figure.subplots(1, len(plans), squeeze=False)[0]
    maps = [plan.map for plan in plans.values() if plan.map is not None]
    latest = max((latest_arrival(cognitive_map) for cognitive_map in maps), default=0.0)
    for ax, (name, plan) in zip(panels, plans.items(), strict=True):
        ax.axis("off")
        if plan.map is not None:
            ax.axis("on")
            path = None if plan.trajectory is None else plan.trajectory.hand
            plot_map(plan.map, ax, path, latest=latest)
            draw_targets(ax, situation, plan.catch_time)
        if plan.map is not None and plan.trajectory is not None:
            draw_waits(ax, plan.trajectory)
        style.title(ax, f"{name}: {plan.status.replace('_', ' ')}")
    if latest > 0.0:
        draw_colour_bar(panels, latest)
    return figure


def _waiting_section(out: Path) -> Section:
    """Solve a situation in which the hand has to wait."""
    scene = _solved(gate_scene(), PLANNERS)
    write_situations(out / "gate.jsonl", [scene.situation])
    plan = scene.plans["layered"]
    film = _film(scene, "layered")
    animate(scene.situation, plan, out / film.file)
    first = engines_figure(scene.situation, {name: scene.plans[name] for name in ENGINES})
    pictures = [
        _save(sheets_figure(scene.situation, plan), out / "gate.png", words.SHEETS),
        film,
        _save(first, out / "gate-engines.png", words.GATE_SHUT),
    ]
    rows = [[name, _number(p.catch_time, ".3f"), p.message] for name, p in scene.plans.items()]
    table = Table(("planner", "catch [s]", "answer"), rows)
    return Section("waiting", "Beyond the paper: waiting", words.WAITING, [table], pictures)


def _save(figure: Figure, path: Path, caption: str) -> Picture:
    """Write a figure and return its place on the page."""
    figure.savefig(path, dpi=SHARPNESS * SCALE)
    return Picture(path.name, caption, round(SCALE * figure.get_figwidth()))


def _random_section(out: Path, seed: int, count: int) -> Section:
    """Solve random situations with all planners and summarise them."""
    solved = [_solved(random_planar(rng(seed, k)), PLANNERS) for k in range(count)]
    tallies = [tally(name, [s.plans[name] for s in solved]) for name in PLANNERS]
    broken = {name: _count_broken(solved, name) for name in PLANNERS}
    caption = f"{count} random planar situations, seed {seed}. {words.SPREADS}"
    picture = _save(summary_figure(tallies), out / "random.png", caption)
    return Section(
        "random",
        f"{count} random situations",
        [words.RANDOM],
        [_random_table(tallies, broken)],
        [picture],
    )


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
            *(str(t.counts[status]) for status in STATUSES),
            str(broken[t.planner]),
            _number(_median(t.catch_times), ".3f"),
            _number(_median(t.clearances), ".3f"),
            _number(_median(t.latencies), ".2f"),
        ]
        for t in tallies
    ]
    return Table(columns, rows)


def _median(values: np.ndarray) -> float | None:
    """Median of the finite values; without obstacles a clearance is infinite."""
    finite = values[np.isfinite(values)]
    return float(np.median(finite)) if finite.size else None
