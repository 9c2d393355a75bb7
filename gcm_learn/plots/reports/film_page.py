"""A page on which a movement is played, and turned with the mouse."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from markupsafe import Markup
from matplotlib.colors import to_hex

from gcm_learn import rendering
from gcm_learn.errors import MissingExtraError
from gcm_learn.maps import CognitiveMap
from gcm_learn.plots.figures import style
from gcm_learn.plots.figures.hand_ball import effective_skin, fills_ball
from gcm_learn.plots.figures.scenery import TIME_COLOURS, Scenery, cloud_note
from gcm_learn.plots.figures.surfaces import surface_about
from gcm_learn.plots.reports.page import fill
from gcm_learn.situation import Body, Sphere

if TYPE_CHECKING:
    from gcm_learn.motion import Movement
    from gcm_learn.planners import Plan

FRAMES = 41
DIGITS = 4  # of numbers on the page, after the first of the reach
SKIN = 40  # cells a side of which the surface of effective obstacles is made
GROUND = "#dde3ea"
SIGHT = np.pi / 4  # angle of view of plotly's camera
SPARE = 1.04  # times the distance from which all is just in the picture
KEY = tuple(entry for entry in style.KEY if entry[1] in ("arm", "obstacle", "target"))
MISSED = "#a8a2b8"
NOT_CAUGHT = ((MISSED, "target that is not caught"),)
APPROACHED = ((rendering.APPROACH, "approach of a target"),)
WITH_MARGIN = ((rendering.OBSTACLE + "4d", "margin"),)
HELD, PLACED = ((style.INK, "hold"),), ((style.GOOD, "place"),)
FACES = rendering.FACES // 2  # of all clouds on the page, and of all margins
CELLS = 8, 24  # fewest and most along a surface about a cloud or mesh
LEVELS = 4  # distances for which surfaces about clouds and meshes are made
IN_HANDS = ((style.EFFECTIVE, "effective obstacle, in hand-space"),)


def write_film_page(situation: rendering.JointSituation, plan: Plan, path: str | Path) -> Path:
    """Write a page that shows a plan and needs no other files.

    Parameters
    ----------
    situation : Situation
        With an arm that moves in its joints.
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
    if plan.trajectory is not None and plan.trajectory.duration > (plan.catch_time or np.inf):
        ending = "the end"
    data = page_data(situation, plan)
    told = {
        "title": situation.name,
        "lead": f"{plan.planner}: {plan.message}. Turn it with the mouse; the wheel comes nearer.",
        "data": data,
        "key": _key(situation, data),
        "ramp": ",".join(to_hex(TIME_COLOURS(x)) for x in np.linspace(0.0, 1.0, 5)),
        "ending": ending,
        "plotly": Markup(plotly_script()),
    }
    path.write_text(fill("film.html", told), "utf-8")
    return path


def _key(situation: rendering.JointSituation, data: dict[str, Any]) -> tuple[tuple[str, str], ...]:
    """Return the key of the page: colours and their meanings."""
    approached = any(bool(body.approach) for body in situation.bodies)
    missed = any(solid["colour"] == MISSED for solid in data["solids"])
    wide = any(body.margin is not None for body in situation.bodies)
    held, placed = ([t for t in situation.targets if getattr(t, of)] for of in ("hold", "place"))
    told = cloud_note(situation, FACES)
    key = KEY + missed * NOT_CAUGHT + approached * APPROACHED + wide * WITH_MARGIN
    key += bool(held) * HELD + bool(placed) * PLACED + (data["hands"] is not None) * IN_HANDS
    return key + bool(told) * ((rendering.OBSTACLE, told),)


def plotly_script() -> str:
    """Plotly's own JavaScript, to be put into a page."""
    try:
        from plotly.offline import get_plotlyjs
    except ImportError:
        raise MissingExtraError("a page that turns a film", "plotly", "plots") from None
    script: str = get_plotlyjs()
    return script


def page_data(situation: rendering.JointSituation, plan: Plan) -> dict[str, Any]:
    """Collect rigid solids with their poses over time, and paths, for the page to draw.

    Returns
    -------
    dict
        ``times`` (k,) [s], ``solids``, ``ways``, ``catches``, ``held`` (k,) names of what the hand
        holds, ``box`` (3, 2) of the shown world,
        ``zoom`` (k,), ``eye`` in units of the box's longest side, and ``hands``.

    Notes
    -----
    The zoom is the factor by which the box is larger while a target is far away.  The page shows
    ``hands`` in hand-space alone; they are None without a map.

    A solid has corners (n, 3), triangles (m, 3), centre (k, 3) and turn (k, 9), row by row.  Its
    ``hands`` says that it is seen in hand-space, too. It is gone after ``until`` [s].
    A margin has ``levels`` instead, whose corners go ``outward`` (n, 3) by ``wide`` (k,), and the
    index of its ``level`` at each time.

    Catches are listed where several are wanted, with name, time [s] and place (3,).
    """
    moves, situation = plan.trajectory, rendering.with_carries(situation, plan)
    times = np.linspace(0.0, situation.horizon if moves is None else moves.duration, FRAMES)
    caught = _caught(situation, plan)
    solids = [*_bodies(situation, times, caught), *_limb(situation, moves, times)]
    scenery = Scenery(situation, moves)
    box = np.stack(rendering.box_of(situation, scenery.held), axis=1)
    box[2, 0] = rendering.floor_of(situation, scenery.held)
    return {
        "times": _short(times),
        "solids": solids,
        "ways": [] if moves is None else [*_ways(situation, moves), *_holds(plan, moves)],
        "catches": [
            {"name": n, "time": round(c["time"], DIGITS), "place": _short(moves.hand_at(c["time"]))}
            for n, c in (caught or {}).items()
            if moves is not None
        ],
        "held": [_held(plan, t) for t in times],
        "box": box.tolist(),
        "zoom": _short(_zoom(scenery.way, times, box)),
        "eye": dict(zip("xyz", _eye(scenery, box).tolist(), strict=True)),
        "ending": ": caught" if plan.caught else "",
        "hands": _hands(situation, plan.map, times, box),
    }


def _zoom(way: rendering.TargetWay, times: np.ndarray, box: np.ndarray) -> np.ndarray:
    """Return factors (k,) by which a box (3, 2) holds the target's way from times (k,) on."""
    corners = way.corners.reshape(len(way.times), -1, 3)
    away = np.abs(corners - box.mean(axis=1)) / (0.5 * np.ptp(box, axis=1))
    largest = np.maximum.accumulate(away.max(axis=(1, 2))[::-1])[::-1]
    ahead = np.searchsorted(way.times, times, side="right") - 1
    factors: np.ndarray = np.maximum(1.0, largest[ahead])
    return factors


def _eye(scenery: Scenery, box: np.ndarray) -> np.ndarray:
    """Return the place (3,) of plotly's eye from which all that is held is in the picture.

    Its unit is the longest side of the box (3, 2), in whose middle it looks.
    """
    points = np.concatenate([thing.corners.reshape(-1, 3) for thing in scenery.held])
    inside = points[((points >= box[:, 0]) & (points <= box[:, 1])).all(axis=1)]
    away = scenery.view.turned(inside - box.mean(axis=1)) / np.ptp(box, axis=1).max()
    needed = away[:, 2] + np.abs(away[:, :2]).max(axis=1) / np.tan(0.5 * SIGHT)
    eye: np.ndarray = SPARE * needed.max() * scenery.view.nearer
    return eye


def _caught(situation: rendering.JointSituation, plan: Plan) -> dict[str, Any] | None:
    """Return the catches by the names of targets where several are wanted; else None."""
    if situation.catch == "any" or plan.trajectory is None:
        return None
    return {catch["body"]: catch for catch in plan.catches}


def _bodies(
    situation: rendering.JointSituation, times: np.ndarray, caught: dict[str, Any] | None
) -> list[dict[str, Any]]:
    """Return the bodies, and the arrows of their approaches."""
    (centres, turns), ground = (
        rendering.body_poses(situation, times),
        rendering.ground_of(situation),
    )
    out = []
    for k, body in enumerate(situation.bodies):
        seen: dict[str, Any] = {"hands": body.role == "target"}
        missed = caught is not None and body.role == "target" and body.name not in caught
        if caught is not None and body.name in caught:
            seen["until"] = max(t for key, t in caught[body.name].items() if key != "body")
        flat = rendering.has_edges(body.shape)  # type: ignore[arg-type]
        most = rendering.faces_each(situation, FACES)
        corners = rendering.faces(body.shape, most)  # type: ignore[arg-type]
        corners = rendering.drawn_scale(situation, body) * corners
        poses = (centres[:, k], turns[:, k])
        level = ground is not None and body is ground.body
        colour = GROUND if level else MISSED if missed else rendering.body_colour(body)
        out.append(_solid(corners, body.name, colour, *poses, flat=flat) | seen)
        if body.margin is not None and not level:
            out.append(_margin(body, rendering.margin_at(body, times), most, poses))
        if body.approach:
            arrow, name = rendering.approach_corners(situation, body), f"approach of {body.name}"
            out.append(_solid(arrow, name, rendering.APPROACH, *poses, flat=True) | seen)
        if body.place is not None:
            ball, name = rendering.faces(Sphere(body.place.within)), "place of " + body.name
            there = np.tile(body.place.position, (len(times), 1))
            upright = np.broadcast_to(np.eye(3), (len(times), 3, 3))
            place = _solid(ball, name, style.GOOD, there, upright)
            out.append(place | {"opacity": 0.4, "hands": False})
    return out


def _margin(
    body: Body, wide: np.ndarray, most: int, poses: tuple[np.ndarray, np.ndarray]
) -> dict[str, Any]:
    """Return a margin (k,) [lengths] about a body: surfaces at a few distances, which move out."""
    at = np.unique(np.linspace(wide[0], wide[-1], LEVELS))
    levels, cells = [], int(np.clip(np.sqrt(most / 12), *CELLS))
    for distance in at.tolist():
        about = surface_about(body.shape, distance, cells) or rendering.shell(body.shape, most)  # type: ignore[arg-type]
        corners, triangles, _ = _welded(np.concatenate(about, axis=2))
        start, outward = _short(corners[:, :3]), _short(corners[:, 3:])
        levels.append({"corners": start, "outward": outward, "triangles": triangles.tolist()})
    nearest = np.abs(wide[:, None] - at).argmin(axis=1).tolist()
    solid = _solid(np.empty((0, 4, 3)), f"margin of {body.name}", rendering.OBSTACLE, *poses)
    margin = {"levels": levels, "level": nearest, "wide": _short(wide), "hands": False}
    return solid | margin | {"opacity": rendering.SHELL}


def _limb(
    situation: rendering.JointSituation, moves: Movement | None, times: np.ndarray
) -> list[dict[str, Any]]:
    """Return the links and balls of the arm."""
    arm = situation.arm
    joints = np.tile(arm.joints, (len(times), 1)) if moves is None else moves.joints_at(times)
    limb, out = rendering.limb_along(arm, joints), []
    for i, radius in enumerate(limb.radii):
        a, b = limb.ends[:, i, 0], limb.ends[:, i, 1]
        turns = np.array([rendering.bone_pose(*ends)[0] for ends in limb.ends[:, i]])
        link = rendering.faces(rendering.bone_shape(radius, rendering.bone_pose(a[0], b[0])[1]))
        out.append(_solid(link, f"link {i}", style.ARM, 0.5 * (a + b), turns))
    upright = np.broadcast_to(np.eye(3), (len(times), 3, 3))
    for ball in rendering.balls_of(limb):
        corners = rendering.faces(Sphere(ball.radius))
        out.append(_solid(corners, ball.name, ball.colour, ball.places, upright))
    return [solid | {"hands": solid["name"] == "hand"} for solid in out]


def _hands(
    situation: rendering.JointSituation,
    known: CognitiveMap | None,
    times: np.ndarray,
    box: np.ndarray,
) -> dict[str, Any] | None:
    """Return the surface of the effective obstacles, with its triangles in order of time.

    ``counts`` (k,) is the number of triangles that are there at each time.
    """
    if known is None or not fills_ball(known):
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
    quads: np.ndarray, name: str, colour: str, centres: np.ndarray, turns: np.ndarray,
    *, flat: bool = False,
) -> dict[str, Any]:  # fmt: skip
    """Return a solid as page data, from its faces (n, 4, 3) and its poses (k, 3) and (k, 3, 3)."""
    corners, triangles, _ = _welded(quads)
    return {
        "name": name, "colour": colour, "flat": flat, "opacity": 1.0,
        "corners": _short(corners), "triangles": triangles.tolist(),
        "centre": _short(centres), "turn": _short(turns.reshape(-1, 9)),
    }  # fmt: skip


def _welded(quads: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return corners (n, 3), triangles (m, 3) and their faces (m,), of faces (k, 4, 3)."""
    rows = np.round(quads.reshape(-1, quads.shape[2]), 9)
    corners, index = np.unique(rows, axis=0, return_inverse=True)
    four = index.reshape(-1, 4)
    triangles = np.concatenate([four[:, [0, 1, 2]], four[:, [0, 2, 3]]])
    real = (np.diff(np.sort(triangles, axis=1), axis=1) > 0).all(axis=1)
    return corners, triangles[real], np.tile(np.arange(len(quads)), 2)[real]


def _ways(situation: rendering.JointSituation, moves: Movement) -> Iterator[dict[str, Any]]:
    """Yield the paths of hand and targets, coloured by time."""
    times = np.linspace(0.0, moves.duration, 2 * FRAMES)
    colours = [to_hex(c) for c in TIME_COLOURS(np.linspace(0.0, 1.0, len(times)))]
    targets = zip(situation.targets, rendering.target_paths(situation, times), strict=True)
    yield _way("hand's path", moves.hand_at(times), colours)
    for body, path in targets:
        yield _way(f"path of {body.name}", path, colours, width=4, dash="dash")


def _holds(plan: Plan, moves: Movement) -> Iterator[dict[str, Any]]:
    """Yield the parts of the hand's path on which the hand holds a target."""
    for one in plan.catches:
        if "held_until" in one:
            path = moves.hand_at(np.linspace(one["time"], one["held_until"], FRAMES))
            yield _way(f"hold of {one['body']}", path, style.INK, width=12)


def _held(plan: Plan, t: float) -> str:
    """Return the name of the target that is held at time t [s], or ""."""
    holds = (one for one in plan.catches if one["time"] <= t <= one.get("held_until", -1.0))
    return next((str(one["body"]) for one in holds), "")


def _way(
    name: str, path: np.ndarray, colours: Any, width: int = 6, dash: str = "solid"
) -> dict[str, Any]:
    """Return a path (k, 3) as a line."""
    axes = {axis: _short(path[:, k]) for k, axis in enumerate("xyz")}
    return {"name": name, "line": {"color": colours, "width": width, "dash": dash}, **axes}


def _short(values: np.ndarray) -> list[Any]:
    """Return numbers with as few digits as a picture needs."""
    return np.round(values, DIGITS).tolist()  # type: ignore[no-any-return]
