"""Panels hold what they promise."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from matplotlib.colors import to_hex, to_rgba
from matplotlib.patches import Circle, FancyArrowPatch, Polygon

from gcm_learn import plots
from gcm_learn.charts.extended import occupied_cells
from gcm_learn.charts.lattice import Lattice
from gcm_learn.families import paper
from gcm_learn.maps import CognitiveMap
from gcm_learn.plots.figures import solid_scene, style
from gcm_learn.plots.figures.hand_space import (
    draw_extended,
    draw_hand_space,
    extended_image,
    lattice_of,
)
from gcm_learn.plots.figures.maps import birth, draw_snapshot, latest_arrival, plot_map, spread
from gcm_learn.plots.figures.workspace import draw_arm, draw_courses, draw_poses, draw_workspace
from tests.rendering.test_rendering import near


def axes():
    return style.new_figure(4, 4).subplots()


def bodies_drawn(ax, colour):
    patches = [p for p in ax.patches if isinstance(p, Polygon)]
    return [p for p in patches if to_hex(p.get_facecolor()) == to_hex(colour)]


def arms_drawn(ax):
    return [line for line in ax.lines if len(line.get_xdata()) == 3 and line.get_linewidth() == 4]


def test_pyplot_is_not_used():
    """No global figure list: pictures may be drawn in threads and without a display."""
    sources = list(Path(plots.__file__).parent.rglob("*.py"))
    assert len(sources) > 10
    assert not [source.name for source in sources if "pyplot" in source.read_text("utf-8")]


def test_workspace_shows_rim_bodies_and_arm():
    situation = paper.fig2()
    ax = draw_workspace(axes(), situation, annulus=True)
    rims = sorted(p.radius for p in ax.patches if isinstance(p, Circle))
    assert rims == [1.0, 2.0]
    assert len(bodies_drawn(ax, style.OBSTACLE)) == 2
    assert len(bodies_drawn(ax, style.TARGET)) == 1
    (limb,) = arms_drawn(ax)
    np.testing.assert_allclose(limb.get_xydata()[[0, 2]], [(0, 0), situation.arm.hand])


def test_arm_is_drawn_with_its_true_segment_lengths():
    situation, ax = paper.fig1(), axes()
    draw_arm(ax, situation.arm, (1.2, 0.3))
    (limb,) = arms_drawn(ax)
    np.testing.assert_allclose(np.linalg.norm(np.diff(limb.get_xydata(), axis=0), axis=1), 1.0)


def test_a_plane_that_misses_shows_no_body():
    ax = draw_workspace(axes(), paper.fig6(), 0.0)
    assert not bodies_drawn(ax, style.OBSTACLE)
    assert not bodies_drawn(ax, style.TARGET)


def test_courses_only_for_what_moves():
    ax = axes()
    draw_courses(ax, paper.fig4(), 0.4)
    assert sum(isinstance(p, FancyArrowPatch) for p in ax.patches) == 1


def test_hand_space_image_is_the_occupied_set():
    situation = paper.fig2()
    image = extended_image(situation, 0.0, n=100)
    occupied = occupied_cells(situation, lattice_of(situation.arm, 100), 0.0)
    assert occupied.any()
    inside = np.hypot(*np.meshgrid(*2 * (lattice_of(situation.arm, 100).centres,))) < 2.0
    np.testing.assert_array_equal((image[..., 3] > 0)[inside], occupied[inside])
    np.testing.assert_allclose(image[occupied][0][:3], to_rgba(style.EXTENDED)[:3])


def test_hand_space_image_goes_on_over_the_rim_and_is_cut_there():
    """An obstacle's image must not end in the steps of the last cells inside the rim."""
    situation, ax = paper.fig2(), axes()
    lattice = lattice_of(situation.arm, 100)
    x, y = np.meshgrid(lattice.centres, lattice.centres)
    at_rim = np.abs(np.hypot(x, y) - 2.0) < lattice.spacing
    image = extended_image(situation, 0.0, n=100)[..., 3] > 0
    beyond = at_rim & (np.hypot(x, y) > 2.0)
    assert image[at_rim & ~beyond].any()
    assert image[beyond].mean() == pytest.approx(image[at_rim & ~beyond].mean(), abs=0.05)
    assert not image[np.hypot(x, y) > 2.0 + 2 * lattice.spacing].any()
    assert draw_extended(ax, situation, 0.0).get_clip_path() is not None


def test_hand_space_shows_the_arm_as_a_point():
    situation = paper.fig2()
    ax = draw_hand_space(axes(), situation)
    assert not arms_drawn(ax)
    points = [line.get_xydata()[0] for line in ax.lines if len(line.get_xdata()) == 1]
    np.testing.assert_allclose(points, [situation.arm.hand])


def test_map_shows_path_effective_cells_and_hand(planar_case):
    _, plan = planar_case
    ax = plot_map(plan.map, path=plan.trajectory.hand, colour_bar=True)
    assert any(np.array_equal(line.get_xydata(), plan.trajectory.hand) for line in ax.lines)
    red = ax.images[0].get_array()
    np.testing.assert_array_equal(red[..., 3] > 0, plan.map.effective_obstacles)
    np.testing.assert_allclose(red[plan.map.effective_obstacles][0], to_rgba(style.EFFECTIVE))
    assert len(ax.figure.axes) == 2


def test_maps_on_a_common_scale_have_comparable_colours(planar_case):
    """On a scale that is twice as long, the same arrival is paler."""
    _, plan = planar_case
    own = latest_arrival(plan.map)
    assert own == pytest.approx(plan.map.arrival_tau.max())
    darkest = [
        plot_map(plan.map, latest=latest).collections[0].get_facecolor()[-1]
        for latest in (None, own, 2 * own)
    ]
    np.testing.assert_allclose(darkest[0], darkest[1])
    assert darkest[2][:3].sum() > darkest[0][:3].sum() + 0.2


def test_spread_keeps_arrivals_and_goes_on_one_cell(planar_case):
    _, plan = planar_case
    tau, far = plan.map.arrival_tau, spread(plan.map)
    reached = ~np.ma.getmaskarray(tau)
    np.testing.assert_array_equal(far[reached], tau[reached].data)
    grown = np.isfinite(far) & ~reached
    assert grown.any()
    assert np.isfinite(far).sum() < far.size
    assert far[grown].min() > 5.0


def test_spread_goes_round_no_corner_of_a_wall():
    wall = np.zeros((16, 16), dtype=bool)
    wall[8, 9] = True
    arrival = np.ma.masked_all((16, 16))
    arrival[8, 8] = 10.0
    far = spread(
        CognitiveMap(Lattice(16), (0.1, 0.1), arrival, wall, np.zeros_like(wall), None, 1.0, "wave")
    )
    assert far[8, 8] == 10.0
    assert np.isfinite(far[7:10, 7]).all() and np.isfinite(far[[7, 9], 8]).all()
    assert np.isinf(far[[7, 9], 9]).all()


def test_birth_of_frozen_cells_is_when_the_front_came(planar_case):
    _, plan = planar_case
    born = birth(plan.map)[plan.map.effective_obstacles]
    assert np.isfinite(born).all()
    assert born.max() <= plan.map.interception_tau


@pytest.mark.parametrize("tau", [0.0, 60.0, 100.0])
def test_snapshot_shades_what_was_reached_by_then(planar_case, tau):
    situation, plan = planar_case
    ax = draw_snapshot(axes(), situation, plan.map, tau)
    assert ax.get_title() == f"τ = {tau:.0f}"
    shaded = [c for c in ax.collections if to_rgba(style.EXPLORED) in map(tuple, c.get_facecolor())]
    assert bool(shaded) == (tau > 0.0)
    if shaded:
        x, y = shaded[0].get_paths()[0].vertices.T
        reached = plan.map.arrival_tau <= tau
        area = 0.5 * abs(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y))
        assert area == pytest.approx(reached.sum() * plan.map.lattice.spacing**2, rel=0.15)


def test_snapshot_shows_only_effective_cells_of_the_past(planar_case):
    situation, plan = planar_case
    early = draw_snapshot(axes(), situation, plan.map, 30.0)
    late = draw_snapshot(axes(), situation, plan.map, plan.map.interception_tau)
    counts = [max((to_red(image) for image in ax.images), default=0) for ax in (early, late)]
    assert counts[0] < counts[1] == plan.map.effective_obstacles.sum()


def test_snapshot_draws_the_front_only_where_it_moves(planar_case):
    situation, plan = planar_case
    tau = 100.0
    ax = draw_snapshot(axes(), situation, plan.map, tau)
    wanted = to_rgba(style.FRONT)
    (front,) = [c for c in ax.collections if wanted in map(tuple, c.get_edgecolor())]
    line = np.concatenate([path.vertices for path in front.get_paths()])
    stuck = plan.map.effective_obstacles & (birth(plan.map) <= tau)
    assert stuck.any()
    x, y = np.meshgrid(plan.map.lattice.centres, plan.map.lattice.centres)
    cells = np.stack([x[stuck], y[stuck]], axis=-1)
    nearest = np.abs(line[:, None] - cells).max(axis=-1).min(axis=1)
    assert nearest.min() >= 0.9 * plan.map.lattice.spacing


def to_red(image):
    array = image.get_array()
    return int((np.abs(array - to_rgba(style.EFFECTIVE)).max(axis=-1) < 1e-9).sum())


def test_poses_are_on_the_trajectory_and_get_darker(planar_case):
    situation, plan = planar_case
    ax = draw_poses(axes(), situation, plan.trajectory, count=3)
    arms = arms_drawn(ax)
    times = np.linspace(0.0, plan.trajectory.duration, 3)
    hands = np.array([arm.get_xydata()[2] for arm in arms])
    np.testing.assert_allclose(hands, plan.trajectory.hand_at(times))
    lightness = [sum(to_rgba(arm.get_color())[:3]) for arm in arms]
    assert lightness == sorted(lightness, reverse=True)


def test_a_solid_scene_shows_bodies_plane_and_arm():
    situation = paper.fig5()
    image = np.asarray(solid_scene.draw_scene(axes(), situation).images[0].get_array())
    for colour in (style.OBSTACLE, style.TARGET, style.ARM):
        assert near(image, colour) > 0.0005
    glass = 1.0 - solid_scene.GLASS_ALPHA * (1.0 - np.array(to_rgba(solid_scene.GLASS[0])[:3]))
    assert (np.abs(image - glass).max(axis=-1) < 0.05).mean() > 0.2


def test_a_planar_situation_has_no_solid_scene():
    with pytest.raises(ValueError, match="planar"):
        solid_scene.draw_scene(axes(), paper.fig4())


def test_solid_scenes_can_share_a_window_and_show_courses():
    situation, panels = paper.fig8(), list(style.new_figure(8, 4).subplots(1, 2))
    window = solid_scene.scene_window(situation, (0.0, 0.6))
    for ax, t in zip(panels, (0.0, 0.6), strict=True):
        solid_scene.draw_scene(ax, situation, t, window=window)
    solid_scene.draw_course(panels[0], situation, 0, 0.6)
    assert panels[0].get_xlim() == panels[1].get_xlim() == window.extent[:2]
    assert panels[0].lines and not panels[1].lines


def test_path_has_arrow_heads_that_point_along_it():
    ax = axes()
    style.draw_path(ax, np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]]), heads=2)
    heads = [p for p in ax.patches if isinstance(p, FancyArrowPatch)]
    ends = [p.get_path().vertices for p in heads]
    assert len(ends) == 2


def test_a_path_of_one_place_draws_no_arrow():
    ax = axes()
    style.draw_path(ax, np.zeros((2, 2)))
    assert not ax.patches
