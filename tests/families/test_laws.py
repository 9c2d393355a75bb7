"""Families do what they say: geometry of each law, and what planners make of it."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest

from gcm_learn import seeding, situation as records
from gcm_learn.arms import Arm
from gcm_learn.errors import SituationError
from gcm_learn.families import PRESETS, draw, family_names, get_family, layout, preset_families
from gcm_learn.families.pieces import UPRIGHT, PlanarPiece, SpaceRanges, planar_body, solid_body
from gcm_learn.motion.rules import start_clearance
from gcm_learn.planners import get_planner
from gcm_learn.scene.bodies import TOP_SPEED
from gcm_learn.scene.packing import pack, pack_bodies, pose
from tests.judging import judge
from tests.worlds import disc, solid_ball

PLANNERS = [get_planner(name) for name in ("straight", "marching", "search")]
STRATA = "LWQ"
AWAY = disc("away", (9.0, 0.0), role="target", radius=0.1)
AWAY_3D = solid_ball("away", (9.0, 0, 0), role="target", radius=0.1)


def catches(situation):
    """Return the stratum by planners and the catch time of those that catch."""
    plans = [planner.plan(situation) for planner in PLANNERS]
    times = [plan.catch_time for plan in plans if plan.caught]
    found = [letter for letter, plan in zip(STRATA, plans, strict=True) if plan.caught]
    return found[0] if found else "U", times


def random_piece(rng):
    size = (rng.uniform(0.05, 0.3),) if rng.random() < 0.3 else tuple(rng.uniform(0.05, 0.3, 2))
    size = tuple(sorted(size, reverse=True))
    offset = size[0] * rng.integers(2) if len(size) == 2 else 0.0
    moves = rng.random() < 0.5 and offset == 0.0
    velocity, acceleration = rng.uniform(-3, 3, (2, 2)) if moves else np.zeros((2, 2))
    return PlanarPiece(
        "obstacle", "piece", tuple(map(float, size)), tuple(map(float, rng.uniform(-2, 2, 2))),
        rng.uniform(0, 1), tuple(map(float, velocity)), tuple(map(float, acceleration)),
        rng.uniform(-3, 3), rng.uniform(-5, 5), float(offset),
    )  # fmt: skip


def random_arm(rng):
    return Arm(
        tuple(map(float, rng.uniform(0.3, 1.2, 2))), 3.0, rng.uniform(0.9, 1.1),
        "left" if rng.random() < 0.5 else "right", thickness=0.02,
    )  # fmt: skip


@pytest.mark.parametrize("seed", range(40))
def test_what_touches_is_what_the_exact_clearance_says(seed):
    rng = seeding.rng(51, seed)
    piece, arm = random_piece(rng)._replace(when=0.0), random_arm(rng)
    situation = records.Situation("s", 1.0, arm, (AWAY, planar_body(piece)))
    clearance = start_clearance(pack(situation))
    if len(piece.size) == 1:
        assert layout.touches(piece, arm, arm.hand, 0.0) == (clearance <= 0.0)
    elif layout.touches(piece, arm, arm.hand, 0.0):
        assert clearance <= layout.CORNER * piece.size[1]  # a bar is rounded off outwards
    else:
        assert clearance > 0.0


@pytest.mark.parametrize("seed", range(40))
def test_a_solid_is_where_its_planar_twin_is(seed):
    rng = seeding.rng(52, seed)
    piece, arm = random_piece(rng), random_arm(rng)
    flat = records.Situation("s", 1.0, arm, (AWAY, planar_body(piece)))
    firm = solid_body(rng, piece, SpaceRanges(), 3.0, firm=True)
    solid = records.Situation("s", 1.0, arm, (AWAY_3D, firm), UPRIGHT)
    for t in (0.0, 0.4, 1.0):
        (origin, turn), (centre, rotation) = pose(flat, 1, t), pose(solid, 1, t)
        along = turn[:, 0]
        np.testing.assert_allclose(centre, origin + piece.offset * along, atol=1e-6)
        if len(piece.size) == 1:
            continue
        axis = rotation[:, 0] if isinstance(firm.shape, records.Box) else rotation[:, 2]
        np.testing.assert_allclose(axis, along, atol=1e-6)


@pytest.mark.parametrize("seed", range(30))
def test_solids_that_come_through_are_in_the_plane_at_their_time(seed):
    rng = seeding.rng(53, seed)
    piece, arm = random_piece(rng), random_arm(rng)
    space = SpaceRanges(crossing=(1.0, 1.0), lean=(0.5, 0.5))
    body = solid_body(rng, piece, space, 3.0)
    situation = records.Situation("s", 1.0, arm, (AWAY_3D, body), UPRIGHT)
    centre, rotation = pose(situation, 1, piece.when)
    if not piece.offset:
        np.testing.assert_allclose(centre, (*piece.place, 0.0), atol=1e-6)
        speed = pose(situation, 1, piece.when + 0.1)[0][2] / 0.1
        assert abs(speed) == pytest.approx(3.0, rel=1e-6)
    tilted = rotation[:, 2] if isinstance(body.shape, records.Box) or len(piece.size) == 1 else None
    if tilted is not None and not isinstance(body.shape, records.Sphere):
        assert abs(tilted[2]) == pytest.approx(math.cos(0.5), rel=1e-6)


@pytest.mark.parametrize("seed", range(30))
def test_points_on_the_way_are_swept(seed):
    rng = seeding.rng(54, seed)
    arm, meet = random_arm(rng), (-0.6, 1.1)
    event = layout.Event(
        PlanarPiece("target", "t", (0.1,), meet), meet, 2.0 * layout.way_time(arm, meet), 1.0, 1.0
    )
    inside = float(seed % 2)
    (x, y), when = layout.on_the_way(rng, arm, event, (0.2, 0.8), inside)
    s = when / event.when
    hand = tuple(a + s * (b - a) for a, b in zip(arm.hand, meet, strict=True))
    point = PlanarPiece(
        "obstacle", "p", (0.12,), (x, y)
    )  # as far as a hand's length beyond the hand
    assert 0.2 <= s <= 0.8 and layout.touches(point, arm, hand, 0.0)
    if inside:
        ex, ey = layout.elbow_at(arm, hand)
        assert abs(x * ey - y * ex) < 1e-9 and math.hypot(x, y) <= arm.upper_arm + 1e-9
    assert not layout.leaves_room(
        point._replace(place=hand, when=0.0), arm, event._replace(meet=hand)
    )


SOLID = [name for name in family_names("planar") if name.endswith("-solid") or name == "pendulum"]


@pytest.mark.parametrize("name", SOLID)
def test_targets_in_space_come_through_the_plane(name):
    for k in range(15):
        situation = draw(name, 8, k)
        bodies = pack_bodies(situation)
        heights = [abs(pose(situation, 0, t)[0][2]) for t in np.linspace(0, situation.horizon, 25)]
        slack = bodies.rows[0, TOP_SPEED] * situation.horizon / 48  # half of what a step may miss
        assert min(heights) <= situation.bodies[0].shape.bounding_radius + slack


@pytest.mark.parametrize("name", ["static-clutter", "static-clutter-solid"])
def test_clutter_rests(name):
    for k in range(10):
        for body in draw(name, 1, k).bodies:
            assert not any((*body.motion.velocity, *body.motion.acceleration))
            assert not np.any(body.motion.spin)


def test_a_swarm_has_one_heading():
    for k in range(10):
        situation = draw(replace(get_family("crossing-swarm"), spread=(-0.1, 0.1)), 2, k)
        headings = np.array([b.motion.velocity for b in situation.obstacles])
        headings /= np.linalg.norm(headings, axis=1)[:, None]
        assert (headings @ headings.T).min() >= math.cos(0.2) - 1e-9


@pytest.mark.parametrize(("name", "down"), [("falling", (0, -1)), ("falling-solid", (0, 0, -1))])
def test_all_that_falls_falls_under_one_gravity(name, down):
    for k in range(15):
        situation = draw(name, 3, k)
        falls = [b.motion.acceleration for b in situation.bodies if not b.name.startswith("shelf")]
        pull = math.hypot(*falls[0])
        assert 0.15 <= pull / situation.arm.max_hand_speed**2 <= 0.6
        np.testing.assert_allclose(falls, pull * np.array([down] * len(falls)), atol=1e-9)


def test_hinged_bars_keep_one_end_in_place():
    family = replace(get_family("spinning"), hinged=1.0)
    solid = replace(get_family("spinning-solid"), hinged=1.0)
    for k in range(10):
        for body in draw(family, 4, k).obstacles:
            assert body.motion.velocity == (0.0, 0.0) and abs(body.motion.spin) > 0.0
            assert min(x for x, _ in body.shape.vertices) == pytest.approx(0.0, abs=1e-12)
        for body in draw(solid, 4, k).obstacles:
            assert isinstance(body.motion, records.Pendulum) and body.motion.gravity == 0.0
            assert body.motion.hang_distance == pytest.approx(body.shape.half_length)


def test_cords_hang_on_their_pivots_and_end_in_their_balls():
    for k in range(15):
        situation = draw("pendulum", 5, k)
        bodies = {body.name: body for body in situation.bodies}
        for name in [name for name in bodies if name.startswith("cord")]:
            cord, ball = bodies[name].motion, bodies[name.replace("cord", "ball")].motion
            assert replace(cord, hang=None) == ball
            assert cord.hang == bodies[name].shape.half_length == ball.length / 2


def test_the_ball_of_a_pendulum_is_in_the_plane_when_it_may_be_met():
    """The swing is computed back to t = 0: it must come to the plane's middle, without drift."""
    family = replace(get_family("pendulum"), obstacles=(1, 1), wait=(1.0, 1.0))
    for k in range(15):
        situation = draw(family, 6, k)
        arm, when = situation.arm, []
        for t in np.linspace(0.0, situation.horizon, 400):
            centre = pose(situation, 0, t)[0]
            here = layout.way_time(arm, centre[:2])
            when.append(abs(centre[2]) + abs(here - t))
        assert min(when) < 0.02  # the ball is in the plane just as the hand could be there


def entry(situation):
    """When the target first comes within what some hand can catch: in closed form."""
    body, arm = situation.targets[0], situation.arm
    if situation.is_solid:
        height, rise = -body.motion.position[1], -body.motion.velocity[1]
        return (abs(height) - body.shape.radius) / abs(rise) if height * rise < 0 else math.inf
    (x, y), (vx, vy) = body.motion.position, body.motion.velocity
    limit = arm.reach + arm.grasp + body.shape.radius
    a, b, c = vx * vx + vy * vy, x * vx + y * vy, x * x + y * y - limit * limit
    return (-b - math.sqrt(b * b - a * c)) / a if c > 0 else 0.0


LATE = ["late-target", "late-target-solid"]


@pytest.mark.parametrize("name", LATE)
def test_no_target_that_is_late_can_be_caught_before_its_entry(name):
    caught = 0
    for k in range(20):
        situation = draw(name, 7, k)
        when = entry(situation)
        assert 0.4 - 1e-6 <= when / situation.horizon <= 0.75 + 1e-6
        if k < 10:
            _, times = catches(situation)
            assert all(t >= when - 1e-6 for t in times)
            caught += bool(times)
    assert caught >= 4


def test_a_cover_is_always_on_the_line_to_the_target():
    for k in range(15):
        situation = draw("behind-mover", 9, k)
        index = [body.name for body in situation.bodies].index("cover")
        hand = np.array(situation.arm.hand)
        shares = []
        for t in np.linspace(0.0, situation.horizon, 7):
            target, cover = (pose(situation, i, t)[0][:2] - hand for i in (0, index))
            shares.append(target @ cover / (target @ target))
            np.testing.assert_allclose(cover, shares[-1] * target, atol=1e-9)
        assert min(shares) >= 0.5 and max(shares) <= 0.85 and np.ptp(shares) < 1e-9


def opening(situation):
    """When a gate opens, from its motion alone."""
    bodies, rho = {body.name: body for body in situation.bodies}, situation.arm.upper_arm
    gate = bodies.get("bolt", bodies.get("runner"))
    motion = gate.motion
    across = motion.acceleration[1] if situation.is_solid else 0.0
    if abs(across) > 0.0:  # pulled out of the plane
        return math.sqrt(2.0 * gate.shape.half_extents[2] / abs(across))
    place, pull = (np.array(v)[[0, -1]] for v in (motion.position, motion.acceleration))
    if gate.name == "bolt":
        if situation.is_solid:  # its middle is given
            half = getattr(gate.shape, "half_length", 0.0) or gate.shape.half_extents[0]
            place = place - half * place / np.linalg.norm(place)
        return math.sqrt(2.0 * (rho - np.linalg.norm(place)) / np.linalg.norm(pull))
    meet = np.array(pose(situation, 0, 0.0)[0][:2])
    elbow = layout.elbow_at(situation.arm, tuple(meet))
    turn = math.atan2(place[0] * elbow[1] - place[1] * elbow[0], place @ np.array(elbow))
    return math.sqrt(2.0 * np.linalg.norm(place) * math.tan(abs(turn)) / np.linalg.norm(pull))


@pytest.mark.parametrize("name", ["gate", "gate-solid"])
def test_gates_need_waiting(name):
    found = []
    for k in range(20):
        situation = draw(name, 10, k)
        stratum, times = catches(situation)
        found.append(stratum)
        # The hand stops a grasp short of the target, which the arm sees under some angle.
        assert all(t >= 0.8 * opening(situation) for t in times), (k, times, opening(situation))
    assert found.count("Q") >= 10 and found.count("L") + found.count("W") <= 3


FAMILIES = [(name, 100, 0.65, 0.25) for name in family_names("planar")]
FAMILIES += [(name, 30, 0.5, 0.33) for name in family_names("spatial")]


@pytest.mark.slow
@pytest.mark.parametrize(("name", "count", "most", "least"), FAMILIES)
def test_no_family_is_trivial_or_hopeless(name, count, most, least):
    found = [catches(draw(name, 1, k))[0] for k in range(count)]
    shares = {letter: found.count(letter) / count for letter in "LWQU"}
    assert count == 30 or shares["U"] <= 0.45
    if not name.startswith("random"):
        assert shares["L"] <= most and shares["W"] + shares["Q"] >= least
    if name.startswith(("gate", "door", "window")) or name in LATE:
        assert shares["Q"] >= 0.1


HELD = [name for name in PRESETS if preset_families(name)[0].holds.share]
OVER = 0.7  # s after the horizon, in which holds go on


def place_of(situation, name, t):
    """Return place and axes of a body by its name at a time."""
    names = [body.name for body in situation.bodies]
    return pose(replace(situation, horizon=situation.horizon + OVER), names.index(name), t)


@pytest.mark.parametrize("name", HELD)
def test_what_is_held_ends_at_rest_and_only_movers_have_margins(name):
    for k in range(8):
        situation, holds = draw(name, 3, k), preset_families(name)[0].holds
        unit = math.hypot(*situation.arm.forearm) if situation.is_spatial else situation.arm.reach
        assert situation.end == "rest" and situation.format.endswith("@4")
        for target in situation.targets:
            assert holds.seconds[0] <= target.hold.seconds <= holds.seconds[1]
            low, high = np.array(holds.relative_speed) * unit
            assert low <= target.hold.relative_speed <= high
        for body in situation.obstacles:
            first, last = (np.vstack(place_of(situation, body.name, t)) for t in (0.0, 0.3))
            moves = not np.array_equal(first, last)
            grows = holds.growth[1] > 0.0 or body.name.startswith("person")
            assert (body.margin is not None) == (moves and grows)


def test_limits_of_jerk_of_an_arm_file_count_where_targets_are_held(tmp_path):
    model = records.shipped_arm("panda")
    joints = (replace(j, max_acceleration=10.0, max_jerk=4e3) for j in model.joints)
    path = tmp_path / "smooth.json"
    path.write_text(json.dumps(records.arm_to_json(replace(model, joints=tuple(joints)))), "utf-8")
    assert draw("panda-belt", 1, 0, arm=str(path)).arm.max_joint_jerk == (4e3,) * 7
    assert draw("throw-chain", 1, 0, arm=str(path)).arm.max_joint_jerk is None
    with pytest.raises(SituationError, match="needs limits of acceleration"):
        draw("panda-belt", 1, 0, arm="panda")


def test_a_part_on_a_turntable_goes_round_and_on_after_the_horizon():
    for k in range(5):
        situation = draw("panda-turntable", 4, k)
        middle, _ = place_of(situation, "turntable", 0.0)
        times = np.linspace(0.0, situation.horizon + OVER, 40)
        out = np.array([place_of(situation, "target", t)[0] for t in times]) - middle
        turned = np.unwrap(np.arctan2(out[:, 1], out[:, 0]))
        rate = turned[1] / times[1] - turned[0] / times[1]
        np.testing.assert_allclose(turned, turned[0] + rate * times, atol=1e-6)
        np.testing.assert_allclose(np.hypot(*out[:, :2].T), np.hypot(*out[0, :2]), rtol=1e-6)
        np.testing.assert_allclose(out[:, 2], out[0, 2], atol=1e-9)
        assert 0.5 <= abs(rate) <= 3.0


def test_a_giver_goes_on_as_one_with_what_it_holds_out():
    for k in range(5):
        situation = draw("panda-handover", 4, k)
        giver = ("target", "finger 1", "finger 2", "palm", "forearm")
        ends = situation.horizon + np.array([0.0, OVER])
        moved = [np.subtract(*(place_of(situation, n, t)[0] for t in ends)) / -OVER for n in giver]
        np.testing.assert_allclose(moved, moved[:1] * 5, atol=1e-9)
        assert 0.05 <= np.linalg.norm(moved[0]) / situation.arm.reach <= 0.2


@pytest.mark.parametrize("name", ["panda-belt", "panda-bin", "ur5-belt"])
def test_places_are_over_the_middle_of_a_bin(name):
    placed = 0
    for k in range(6):
        situation = draw(name, 5, k)
        target = situation.targets[0]
        if target.place is None:
            continue
        placed += 1
        bottom, axes = place_of(situation, "bin bottom", 0.0)
        walls = [body for body in situation.bodies if body.name.startswith("bin wall")]
        rims = [w.motion.position[2] + w.shape.half_extents[2] for w in walls]
        off = axes.T @ (np.array(target.place.position) - bottom)
        np.testing.assert_allclose(off[:2], 0.0, atol=1e-9)
        assert len(walls) == 4 and target.place.position[2] > max(rims)
        assert set(target.ignore) <= {"belt", "bottom"}
    assert placed >= 4


@pytest.mark.parametrize("name", ["panda-belt", "ur5-belt"])
def test_boxes_lie_on_their_belt(name):
    for k in range(5):
        situation = draw(name, 6, k)
        belt = next((body for body in situation.bodies if body.name == "belt"), None)
        if belt is not None:
            part = situation.targets[0]
            bottom = part.motion.position[2] - part.shape.half_extents[2]
            assert bottom == pytest.approx(belt.motion.position[2] + belt.shape.half_extents[2])
            _, axes = place_of(situation, "belt", 0.0)
            assert abs((axes.T @ part.motion.velocity)[1:]).max() < 1e-9


@pytest.mark.slow
@pytest.mark.parametrize("name", HELD)
def test_no_preset_of_holds_is_trivial_or_hopeless_and_all_promises_are_kept(name):
    plans = [(s, PLANNERS[2].plan(s)) for s in (draw(name, 1, k) for k in range(40))]
    assert 12 <= sum(plan.caught for _, plan in plans) <= 38
    assert not any(judge(*pair) for pair in plans)
