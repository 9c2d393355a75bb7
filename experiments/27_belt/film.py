"""Film of the first seconds of a minute at the belt, by search, by memory and by cover.

python -m experiments 27_belt/film                              film.gif
python -m experiments 27_belt/film --seconds 60 --out whole.gif
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
import run
import world
from PIL import Image, ImageDraw, ImageFont

from gcm_learn import Body
from gcm_learn.plots import style
from gcm_learn.plots.figures.film import write_film
from gcm_learn.rendering import (
    Camera,
    Faces,
    Window,
    arm_faces,
    body_colour,
    body_poses,
    camera_from,
    rgb,
    solid_faces,
    staged,
    with_carries,
)

HERE = Path(__file__).resolve().parent
SEED, BUDGET, FRAME = 0, 0.02, 0.1  # charged; from frame to frame [s]
PIXELS, STRIP = 260, 58
GREY = "#aab4c2"
FALL = 0.35  # for which a part is seen to fall [s]
VIEW: Camera = camera_from(28.0, 24.0, (0.3, -0.05, 0.3), 4.0)
WINDOW = Window(np.array([0.0, -0.05]), 0.66)


@lru_cache(maxsize=8)
def _carried(leg: int, done: run.Run) -> Any:
    """Return the situation of a leg in which the part goes with the hand."""
    _, situation, plan = done.legs[leg]
    return with_carries(situation, plan)


def colour_of(body: Body) -> np.ndarray:
    """Return the colour of parts, of boxes, and of what rests."""
    rests = body.role == "obstacle" and not any(body.motion.velocity)
    return rgb(GREY if rests else body_colour(body))


def things(done: run.Run, t: float) -> list[Faces]:
    """Return the faces of bodies and arm at t [s]."""
    minute, begun = done.minute, [k for k, leg in enumerate(done.legs) if leg[0] <= t]
    gone, joints = {done.legs[k][1].name for k in begun}, np.array(world.HOME)
    shown = world.of("film", (*minute.near(t, gone), *world.at_rest(), *minute.boxes(t)))
    found = [
        solid_faces(shown, body, place, turn)._replace(colours=colour_of(body))
        for body, place, turn in zip(
            shown.bodies, *(rows[0] for rows in body_poses(shown, [0.0])), strict=True
        )
    ]
    if begun:
        since, _, plan = done.legs[begun[-1]]
        moves: Any = plan.trajectory
        last, after = moves.duration, max(0.0, t - since - moves.duration)
        joints = moves.joints_at(np.array([min(t - since, last)]))[0]
        if after < FALL:
            carried = _carried(begun[-1], done)
            places, turns = body_poses(carried, [min(t - since, last)])
            drop = np.array([0.0, 0.0, -0.5 * 9.81 * after**2])
            found.append(solid_faces(carried, carried.bodies[0], places[0, 0] + drop, turns[0, 0]))
    return [*found, *arm_faces(world.PANDA, joints)]


def panel(name: str, done: run.Run, t: float) -> Image.Image:
    """Return the picture of one planner's arm at t [s], with its counts so far."""
    seen = np.rint(255 * staged(VIEW, WINDOW, 0.0, things(done, t), PIXELS)[::-1]).astype(np.uint8)
    image = Image.new("RGB", (PIXELS, PIXELS + STRIP), "white")
    image.paste(Image.fromarray(seen), (0, STRIP))
    minute, gone = done.minute, {leg[1].name for leg in done.legs if leg[0] <= t}
    binned = sum(leg[0] + leg[2].trajectory.duration <= t for leg in done.legs)
    missed = sum(minute.along(n, t) > world.LAST and n not in gone for n in minute.parts)
    write, font = ImageDraw.Draw(image), ImageFont.load_default(15)
    write.text((10, 8), name, style.INK, ImageFont.load_default(18))
    write.text((10, 34), f"in the bin {binned}", style.GOOD, font)
    write.text((97, 34), f"missed {missed}", style.EFFECTIVE, font)
    write.text((170, 34), f"thinks {1e3 * done.thinks:.0f} ms", style.INK, font)
    return image


def frames(runs: dict[str, run.Run], count: int) -> Iterator[Image.Image]:
    """Yield pictures of all planners side by side."""
    for k in range(count):
        image = Image.new("RGB", (PIXELS * len(runs), PIXELS + STRIP))
        for column, (name, done) in enumerate(runs.items()):
            image.paste(panel(name, done, FRAME * k), (PIXELS * column, 0))
        yield image


def main() -> None:
    """Run, and write the film."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seconds", type=float, default=15.0, help="of the film, at most 60")
    parser.add_argument("--out", type=Path, default=HERE / "film.gif")
    given = parser.parse_args()
    minute, runs = world.Minute(SEED), {}
    for name, ask in run.entrants().items():
        run.at_the_belt(minute, ask, run.BUDGETS[-1])  # for nothing: kernels are loaded
        runs[f"by {name}"] = run.at_the_belt(minute, ask, BUDGET)
    images, pause = list(frames(runs, round(given.seconds / FRAME))), round(1e3 * FRAME)
    write_film(images, given.out, pause, pause)


if __name__ == "__main__":
    main()
