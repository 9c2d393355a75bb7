"""The first page that a newcomer sees: the paper's scenes, and catches beyond them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from gcm_learn.families import (
    CAPTION_INSTANTS,
    PAPER_SCENES,
    draw,
    gate_scene,
    random_planar,
    thrown_scene,
)
from gcm_learn.maps import build_map, static_twin
from gcm_learn.planners import Plan, broken_promise, solve
from gcm_learn.plots.figures import style
from gcm_learn.plots.figures.film import FILM_DPI, FRAME_TIME, FRAMES, WIDTH, animate
from gcm_learn.plots.figures.maps import plot_plan
from gcm_learn.plots.figures.paper import FIGURES, draw_figure
from gcm_learn.plots.figures.sheets import mapped
from gcm_learn.plots.figures.workspace import draw_movement
from gcm_learn.plots.reports.memory import write_memory_page
from gcm_learn.plots.reports.page import (
    PageTable,
    Picture,
    Section,
    number,
    picture_of,
    render,
    section,
    words,
)
from gcm_learn.recall import has_memory, shipped_memory
from gcm_learn.seeding import rng
from gcm_learn.situation import AnySituation, Situation, write_situations
from gcm_learn.wave import MarchingParams

ENGINES = ("gcm", "marching")
PLANNERS = (*ENGINES, "search", "straight")
SHOWN = tuple(name for name in FIGURES if not name.endswith(("-space", "-body")))
OPENING = "fig3"  # the scene whose film opens the page
SMALL = 320  # [CSS pixels] width of figures that are enlarged by a click
MEMORIES = 400  # points on the page of the memory
TWINNED = ("crossing-swarm", 9, 69)  # family, seed and number of a scene with a twin to look at
COPIES, FRONT = 3, MarchingParams(margin=0.0)  # of each obstacle in the twin; of the maps
WARM_UP = ("fig2", "fig5", "fig8")  # between them they use all compiled code

INSTANTS = (
    "scene", "paper [τ]", "gcm [τ]", "marching [τ]", "catch [s]", "clearance [forearms]",
    "gcm: planning [ms]", "marching: planning [ms]",
)  # fmt: skip
MEASURES = (
    "planner", "caught", "unreachable", "start blocked", "broken promises", "median catch [s]",
    "median clearance [forearms]", "median planning [ms]",
)  # fmt: skip
WORDS = words("demo")
Progress = Callable[[str], None]


def build_demo(out: Path, seed: int, n_random: int, progress: Progress) -> Path:
    """Solve the paper's scenes and random situations; write pictures and a page about them.

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
    scenes = {name: make() for name, make in PAPER_SCENES.items()}
    write_situations(out / "paper.jsonl", [*scenes.values()])
    plans = {name: _solved(scene, ENGINES) for name, scene in scenes.items()}
    opening = _film(out, scenes[OPENING], plans[OPENING]["gcm"])
    sections = [_scenes(out, plans, progress), _twins(out), _beyond(out, progress)]
    if n_random > 0:
        progress(f"Solving {n_random} random situations")
        sections.append(_random(seed, n_random))
    text = WORDS["sections"]["more"]["text"]
    if has_memory():
        progress(f"Drawing {MEMORIES} memories")
        memory = shipped_memory("recall")
        write_memory_page(memory, out / "memory", count=MEMORIES, back="../index.html")
        text = [WORDS["memory"], *text]
    sections.append(section(WORDS, "more", text=text))
    page = out / "index.html"
    page.write_text(render(WORDS["title"], WORDS["lead"], opening, style.KEY, sections), "utf-8")
    return page


def _solved(situation: Situation, planners: Sequence[str]) -> dict[str, Plan]:
    return {name: solve(situation, name) for name in planners}


def _scenes(out: Path, plans: dict[str, dict[str, Plan]], progress: Progress) -> Section:
    """Show the paper's figures, and when hand and target meet."""
    pictures = []
    for name in SHOWN:
        progress(f"Drawing {name}")
        drawn = picture_of(draw_figure(name), out / f"{name}.png", WORDS["captions"][name])
        pictures.append(replace(drawn, width=SMALL))
    rows = [_row(name, found) for name, found in plans.items()]
    return section(WORDS, "scenes", [PageTable(INSTANTS, rows)], pictures)


def _row(name: str, plans: dict[str, Plan]) -> list[str]:
    """Return instants of contact, and the plan of the paper's lattice."""
    plan, maps = plans["gcm"], [plans[engine].map for engine in ENGINES]
    contacts = [None if made is None else made.interception_tau for made in maps]
    return [
        name,
        number(CAPTION_INSTANTS.get(name, (None,))[-1], ".0f"),
        *(number(contact, ".0f") for contact in contacts),
        number(plan.catch_time, ".3f"),
        number(plan.clearance, ".3f"),
        *(number(plans[engine].planning_ms, ".1f") for engine in ENGINES),
    ]


def _twins(out: Path) -> Section:
    """Draw a catch among moving bodies, the same catch in the static twin, and both maps."""
    plan, scenes = twins()
    figure, panels = style.panel_grid(4, 2, (3.1, 3.3))
    for ax, title in zip(panels, WORDS["twins"], strict=True):
        ax.set_title(title)
    for k, scene in enumerate(scenes):
        draw_movement(panels[2 * k], scene, plan)
        plot_plan(panels[2 * k + 1], scene, plan, build_map(scene, FRONT))
    drawn = picture_of(figure, out / "twins.png", WORDS["captions"]["twins"])
    return section(WORDS, "twins", pictures=[drawn])


def twins() -> tuple[Plan, list[Any]]:
    """Return a plan, and a list of the situation planned for and this situation's static twin."""
    scene: Any = draw(*TWINNED)
    plan = solve(scene, "marching")
    return plan, [scene, static_twin(scene, build_map(scene, FRONT), COPIES)]


def _beyond(out: Path, progress: Progress) -> Section:
    """Film a hand that waits, and an arm in space."""
    progress("Planning for a gate that opens, and for an arm in space")
    gate, thrown = gate_scene(), thrown_scene()
    waits = mapped(gate, solve(gate))
    pictures = [_film(out, gate, waits), _film(out, thrown, solve(thrown))]
    write_situations(out / "beyond.jsonl", [gate, thrown])
    return section(WORDS, "beyond", pictures=pictures)


def _film(out: Path, situation: AnySituation, plan: Plan) -> Picture:
    """Film a plan and return the film's place on the page."""
    animate(situation, plan, out / f"{situation.name}.gif")
    lasts = plan.catch_time or situation.horizon
    caption = WORDS["films"][situation.name].format(slower=FRAMES * FRAME_TIME / 1000 / lasts)
    return Picture(f"{situation.name}.gif", caption, round(WIDTH * FILM_DPI))


def _random(seed: int, count: int) -> Section:
    """Solve random situations with all planners and say in numbers how they fared."""
    situations = [random_planar(rng(seed, k)) for k in range(count)]
    rows = [_fared(name, situations) for name in PLANNERS]
    told = {"count": count, "seed": seed}
    return section(WORDS, "random", [PageTable(MEASURES, rows)], told=told)


def _fared(name: str, situations: Sequence[Any]) -> list[str]:
    """Return a planner's row."""
    plans = [solve(situation, name) for situation in situations]
    broken = sum(broken_promise(s, p) is not None for s, p in zip(situations, plans, strict=True))
    caught = [plan for plan in plans if plan.caught]
    statuses = [plan.status for plan in plans]
    return [
        name,
        *(str(statuses.count(status)) for status in ("caught", "unreachable", "start_blocked")),
        str(broken),
        number(_median([plan.catch_time for plan in caught]), ".3f"),
        number(_median([plan.clearance for plan in caught]), ".3f"),
        number(_median([plan.planning_ms for plan in plans]), ".2f"),
    ]


def _median(values: Sequence[float | None]) -> float | None:
    """Return the median of the finite values; without obstacles a clearance is infinite."""
    found = np.array(values, dtype=float)
    finite = found[np.isfinite(found)]
    return float(np.median(finite)) if finite.size else None
