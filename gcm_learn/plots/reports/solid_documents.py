"""Pictures of arms among solids for the README, like the pictures of a planar arm."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any, cast

import numpy as np
from matplotlib.figure import Figure
from PIL import Image

from gcm_learn.arms import Base, Chain, SpatialArm, forward_in_space, hands_along
from gcm_learn.execution import body_for, execute, with_motor_limits
from gcm_learn.families import SPATIAL_SCENES, thrown_scene
from gcm_learn.motion import Movement, as_obstacles, with_stop
from gcm_learn.planners import Plan, solve
from gcm_learn.plots.figures import style
from gcm_learn.plots.figures.execution import animate_execution
from gcm_learn.plots.figures.film import animate, palette_of
from gcm_learn.plots.figures.hand_ball import HandBall, key_of_hand_space
from gcm_learn.plots.figures.scenery import Scenery, draw_courses, draw_poses, time_bar
from gcm_learn.rendering import Camera, JointSituation, body_poses, view_of
from gcm_learn.situation import Body, Situation, SolidQuadratic, Sphere, shipped_arm

ENGINE = "marching"
SHOWN = 0.6  # of the time to the catch: when hand-space is shown
INSTANTS = (0.2, 0.45, 0.7)  # of it: the front's snapshots; the contact follows
BESIDE = np.array([0.28, 0.0])  # [forearms] from a thing to its name
FRAMES, BODY_FRAMES, CELL_FRAMES, VIEWS = 21, 18, 12, 6
WORD = "#b7791f"  # darker than what it names, to be readable
DPI = 140
HOME = (0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785)
APART, HORIZON = 1.0, 1.5  # of the two bases [m], of the two catches [s]


def write_solid_gallery(folder: Path) -> list[Path]:
    """Draw a situation in space, the paper's with a body, and two arms, into a folder.

    Returns
    -------
    list of Path
        The files, in the order in which they tell the story.
    """
    situation = thrown_scene()
    plan: Plan = solve(situation, ENGINE)
    if plan.map is None or plan.trajectory is None:
        raise RuntimeError(f"no catch to show: {plan.message}")
    view = view_of(situation, plan.trajectory)
    scenery = Scenery(situation, plan.trajectory, view)
    hands = HandBall(situation, plan.map, plan.trajectory, view)
    out = []
    for name, figure in (
        ("space-situation", _situation(scenery)),
        ("space-hand-space", _hand_space(scenery, hands)),
        ("space-wave", _wave(plan, hands)),
        ("space-map", _map(situation, plan.trajectory, hands, view)),
    ):
        out.append(folder / f"{name}.png")
        save_light(figure, out[-1])
    out.append(folder / "space-catch.gif")
    animate(situation, plan, out[-1], frames=FRAMES)
    out.append(folder / "space-body.gif")
    scene = SPATIAL_SCENES["fig8-space"]()
    swung = with_motor_limits(scene, body_for(scene.arm))
    done = execute(solve(swung), swung)
    animate_execution(swung, done, out[-1], frames=BODY_FRAMES, views=VIEWS)
    out.append(folder / "two-arms.gif")
    animate(*two_arms(), out[-1], frames=CELL_FRAMES)
    return out


def two_arms() -> tuple[Situation[Chain], Plan]:
    """Return the second arm's situation, with the first arm's links as obstacles, and its plan.

    Two Pandas stand face to face, and their ways to the balls cross. The plan of the second alone
    would run into the first after 0.2 s. All numbers are chosen.
    """
    model = shipped_arm("panda")
    first = Chain(model, joints=HOME, grasp=0.05)
    turned = Base((APART, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0))
    second = Chain(model, joints=HOME, grasp=0.05, base=turned)
    one: Any = Situation("first", HORIZON, first, (_ball((0.64, -0.44, 0.63), (0.0, 0.15, 0.0)),))
    moves = solve(one).trajectory
    if moves is None:
        raise RuntimeError("no catch to show")
    links = as_obstacles(with_stop(one, moves), "first")
    other = _ball((0.29, -0.35, 0.69), (0.0, 0.15, 0.0))
    cell: Any = Situation("second", HORIZON, second, (other, *links))
    return cell, solve(cell)


def _ball(position: tuple[float, float, float], velocity: tuple[float, float, float]) -> Body:
    return Body("target", "ball", Sphere(0.04), SolidQuadratic(position, velocity, (0.0,) * 3))


def save_light(figure: Figure, path: Path, dpi: float = DPI) -> None:
    """Save a picture with shades in few colours, which makes the file three times smaller."""
    buffer = io.BytesIO()
    figure.savefig(buffer, dpi=dpi, format="png")
    picture = Image.open(buffer).convert("RGB")
    light = picture.quantize(palette=palette_of([picture]), dither=Image.Dither.NONE)
    light.save(path, optimize=True)


def _situation(scenery: Scenery) -> Figure:
    figure = style.new_figure(4.2, 4.2)
    ax = figure.subplots()
    scenery.show(ax, 0.0)
    draw_courses(ax, scenery.situation, scenery.end, scenery.view)
    joints = np.asarray(scenery.situation.arm.joints)
    elbow, hand = forward_in_space(cast("SpatialArm", scenery.situation.arm), joints)
    centres, _ = body_poses(scenery.situation, [0.0])
    for place, word, colour, side in (
        ((0.0, 0.0, 0.0), "shoulder", style.INK, -1.3),
        (0.5 * (elbow + hand), "arm", style.ARM, -0.8),
        (centres[0, 0], "ball", style.TARGET, -0.9),
        (centres[0, 1], "post", style.OBSTACLE, 1.2),
    ):
        at = scenery.view.see(np.asarray(place))[:2]
        style.label(ax, at + side * BESIDE, word, colour)
    return figure


def _hand_space(scenery: Scenery, hands: HandBall) -> Figure:
    figure = style.new_figure(8.0, 4.2)
    left, right = figure.subplots(1, 2)
    t = SHOWN * scenery.end
    scenery.show_world(left, t)
    style.title(left, "work-space: an arm among bodies")
    hands.show_world(right, t)
    style.title(right, "hand-space: a point in a ball")
    arm = scenery.situation.arm
    hand = hands_along(arm, arm.joints)[0][0]
    style.label(right, hands.view.see(hand)[:2] + BESIDE, "arm")
    style.label(right, (0.8, -0.75), "extended obstacle", WORD)
    return figure


def _wave(plan: Plan, hands: HandBall) -> Figure:
    assert plan.map is not None and plan.map.interception is not None
    contact = plan.map.interception.time
    figure = style.new_figure(9.6, 3.0)
    panels = figure.subplots(1, len(INSTANTS) + 1)
    for ax, share in zip(panels, (*INSTANTS, 1.0), strict=True):
        hands.show(ax, share * contact, moving=False)
        style.title(ax, f"τ = {share * contact / plan.map.kappa:.0f}")
    style.title(panels[-1], f"τ = {contact / plan.map.kappa:.0f}: contact")
    key_of_hand_space(figure)
    return figure


def _map(situation: JointSituation, moves: Movement, hands: HandBall, view: Camera) -> Figure:
    figure = style.new_figure(8.0, 4.2)
    left, right = figure.subplots(1, 2)
    hands.show_map(left)
    style.title(left, "the map, cut open")
    draw_poses(right, situation, moves, view)
    time_bar(right, moves.duration)
    style.title(right, "the movement (later is darker)")
    return figure
