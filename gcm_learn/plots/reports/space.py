"""A page on which a movement in space is played, and turned with the mouse."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from markupsafe import Markup
from matplotlib.colors import to_hex

from gcm_learn.arms import forward_in_space
from gcm_learn.errors import MissingExtraError
from gcm_learn.handspace import SpaceLattice
from gcm_learn.maps import CognitiveMap
from gcm_learn.plots.figures import style
from gcm_learn.plots.figures.space import TIME_COLOURS, Scenery
from gcm_learn.plots.figures.space_maps import effective_skin
from gcm_learn.plots.reports.page import fill
from gcm_learn.rendering import (
    BALL,
    HAND,
    JOINT,
    SpatialSituation,
    body_colour,
    body_poses,
    bone_radius,
    faces,
    frame_along,
)
from gcm_learn.situation import Box, Capsule, Cylinder, SolidShape, Sphere

if TYPE_CHECKING:
    from gcm_learn.motion import SpatialTrajectory
    from gcm_learn.planners import Plan

FRAMES = 41
DIGITS = 4  # of numbers on the page, after the first of the reach
SKIN = 40  # cells a side of which the surface of effective obstacles is made
EYE = 1.6  # distance of plotly's camera, in its own unit
KEY = tuple(entry for entry in style.KEY if entry[1] in ("arm", "obstacle", "target"))
IN_HANDS = ((style.EFFECTIVE, "effective obstacle, in hand-space"),)


def write_space_page(
    situation: SpatialSituation, plan: Plan[SpatialTrajectory], path: str | Path
) -> Path:
    """Write a page that shows a plan in space; it holds all that it needs.

    Parameters
    ----------
    situation : Situation
        With a spatial arm.
    plan : Plan
        Of this situation.  When it caught nothing, the arm rests and the world goes on.
    path : str or Path
        File to write.

    Returns
    -------
    Path
        The same.

    Raises
    ------
    MissingExtraError
        Without plotly.
    """
    path = Path(path)
    ending = "the catch" if plan.caught else "the horizon"
    data = page_data(situation, plan)
    told = {
        "title": situation.name,
        "lead": f"{plan.planner}: {plan.message}. Turn it with the mouse; the wheel comes nearer.",
        "data": data,
        "key": KEY if data["hands"] is None else KEY + IN_HANDS,
        "ramp": ",".join(to_hex(TIME_COLOURS(x)) for x in np.linspace(0.0, 1.0, 5)),
        "ending": ending,
        "plotly": Markup(plotly_script()),
    }
    path.write_text(fill("space.html", told), "utf-8")
    return path


def plotly_script() -> str:
    """Plotly's own JavaScript, to be put into a page."""
    try:
        from plotly.offline import get_plotlyjs
    except ImportError:
        raise MissingExtraError("a page of an arm in space", "plotly", "plots") from None
    script: str = get_plotlyjs()
    return script


def page_data(situation: SpatialSituation, plan: Plan[SpatialTrajectory]) -> dict[str, Any]:
    """Collect rigid solids with their poses over time, and paths, for the page to draw.

    Returns
    -------
    dict
        ``times`` (k,) [s]; ``solids``, each with corners (n, 3), triangles (m, 3), centre (k, 3)
        and turn (k, 9), row by row, and whether it is seen in hand-space too; ``ways``; ``box``
        (3, 2), what is shown of the world; ``eye``; ``hands``, what is in hand-space only, None
        where there is no map of it.
    """
    moves = plan.trajectory
    times = np.linspace(0.0, situation.horizon if moves is None else moves.duration, FRAMES)
    solids = [*_bodies(situation, times), *_limb(situation, moves, times)]
    scenery = Scenery(situation, moves)
    return {
        "times": _short(times),
        "solids": solids,
        "ways": [] if moves is None else list(_ways(situation, moves)),
        "box": scenery.box.tolist(),
        "eye": dict(zip("xyz", (EYE * scenery.view.nearer).tolist(), strict=True)),
        "ending": ": caught" if plan.caught else "",
        "hands": _hands(situation, plan.map, times, scenery.box),
    }


def _bodies(situation: SpatialSituation, times: np.ndarray) -> list[dict[str, Any]]:
    centres, turns = body_poses(situation, times)
    return [
        _solid(body.shape, body.name, body_colour(body), centres[:, k], turns[:, k])  # type: ignore[arg-type]
        | {"hands": body.role == "target"}
        for k, body in enumerate(situation.bodies)
    ]


def _limb(
    situation: SpatialSituation, moves: SpatialTrajectory | None, times: np.ndarray
) -> list[dict[str, Any]]:
    """The bones and balls of the arm."""
    arm = situation.arm
    joints = np.tile(arm.joints, (len(times), 1)) if moves is None else moves.joints_at(times)
    elbow, hand = forward_in_space(arm, joints)
    shoulder, radius = np.broadcast_to(arm.base.origin, elbow.shape), bone_radius(arm)
    out = []
    for name, a, b in (("upper arm", shoulder, elbow), ("forearm", elbow, hand)):
        length = float(np.linalg.norm(b[0] - a[0]))
        turns = np.array([frame_along(way / length) for way in b - a])
        bone = Capsule(radius, length / 2)
        out.append(_solid(bone, name, style.ARM, 0.5 * (a + b), turns))
    upright = np.broadcast_to(np.eye(3), (len(times), 3, 3))
    for name, centre, size, colour in (
        ("shoulder", shoulder, BALL, style.INK), ("elbow", elbow, BALL, JOINT),
        ("hand", hand, HAND, style.ARM),
    ):  # fmt: skip
        out.append(_solid(Sphere(size * radius), name, colour, centre, upright))
    return [solid | {"hands": solid["name"] == "hand"} for solid in out]


def _hands(
    situation: SpatialSituation, known: CognitiveMap | None, times: np.ndarray, box: np.ndarray
) -> dict[str, Any] | None:
    """The surface of effective obstacles, its triangles in order of time, and what is shown.

    ``counts`` (k,) says how many of the triangles there are at each time.
    """
    if known is None or not isinstance(known.chart, SpaceLattice):
        return None
    quads, since = effective_skin(known, SKIN)
    corners, triangles, face = _welded(quads)
    order = np.argsort(since[face], kind="stable")
    centre, reach = np.asarray(situation.arm.base.origin)[:, None], situation.arm.reach
    shown = [np.minimum(box[:, :1], centre - reach), np.maximum(box[:, 1:], centre + reach)]
    return {
        "name": "effective obstacle", "colour": style.EFFECTIVE, "corners": _short(corners),
        "triangles": triangles[order].tolist(), "box": np.hstack(shown).tolist(),
        "counts": np.searchsorted(since[face][order], times, side="right").tolist(),
    }  # fmt: skip


def _solid(
    shape: SolidShape, name: str, colour: str, centres: np.ndarray, turns: np.ndarray
) -> dict[str, Any]:
    """A solid with its poses (k, 3) and (k, 3, 3)."""
    flat = isinstance(shape, Box | Cylinder)
    corners, triangles, _ = _welded(faces(shape, np.inf))
    return {
        "name": name, "colour": colour, "flat": flat, "opacity": 1.0,
        "corners": _short(corners), "triangles": triangles.tolist(),
        "centre": _short(centres), "turn": _short(turns.reshape(-1, 9)),
    }  # fmt: skip


def _welded(quads: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Quadrilaterals (k, 4, 3) as corners (n, 3), triangles (m, 3) of them, and whose (m,)."""
    corners, index = np.unique(np.round(quads.reshape(-1, 3), 9), axis=0, return_inverse=True)
    four = index.reshape(-1, 4)
    triangles = np.concatenate([four[:, [0, 1, 2]], four[:, [0, 2, 3]]])
    real = (np.diff(np.sort(triangles, axis=1), axis=1) > 0).all(axis=1)
    return corners, triangles[real], np.tile(np.arange(len(quads)), 2)[real]


def _ways(situation: SpatialSituation, moves: SpatialTrajectory) -> list[dict[str, Any]]:
    """Paths of hand and targets, coloured by time."""
    times = np.linspace(0.0, moves.duration, 2 * FRAMES)
    colours = [to_hex(c) for c in TIME_COLOURS(np.linspace(0.0, 1.0, len(times)))]
    centres, _ = body_poses(situation, times)
    paths = [("hand's way", moves.hand_at(times), False)]
    paths += [
        (f"way of {body.name}", centres[:, k], True)
        for k, body in enumerate(situation.bodies)
        if body.role == "target"
    ]
    return [
        {"name": name, "colours": colours, "dashed": dashed,
         **{axis: _short(path[:, k]) for k, axis in enumerate("xyz")}}
        for name, path, dashed in paths
    ]  # fmt: skip


def _short(values: np.ndarray) -> list[Any]:
    """Numbers with so few digits as a picture needs."""
    return np.round(values, DIGITS).tolist()  # type: ignore[no-any-return]
