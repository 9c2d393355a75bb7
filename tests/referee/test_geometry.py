"""The referee's geometry by other means: the contract's numbers, scipy, dense samples."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import minimize

from gcm_learn.referee import arm_of as arm_in, bodies_of, judge
from gcm_learn.referee.shapes import inside
from tests import geometry
from tests.referee import answers
from tests.worlds import SHAPES, SWING, ball, body, still

NAO = {
    "kind": "spatial",
    "base": {"origin": [0, 0.098, 0.43], "rotation": [0.9238795, 0, 0, 0.3826834]},
    "upper_arm": [0.105, 0.015, 0], "forearm": [0.1137, 0, -0.01231],
    "joints": [0] * 4, "joint_range": [[-3, 3]] * 4, "max_joint_speed": [8] * 4, "grasp": 0,
}  # fmt: skip
PLANAR_2 = {"kind": "chain", "model": "planar-2", "posture": [0.3, -0.5], "grasp": 0.0}
FLAT = [
    {"kind": "disc", "radius": 0.3},
    {"kind": "polygon", "vertices": [[0, 0], [0.9, 0], [0.9, 0.9], [0.6, 0.2], [0.3, 0.2]]},
]


def at(given, joints):
    """Elbow, hand and axis of one posture."""
    arm, q = geometry.arm_of(given), np.array([joints], dtype=float)
    (hand,), (axis,) = geometry.hand_of(arm, q)
    return geometry.links_of(arm, q)[0][0, 1, 0], hand, axis


@pytest.mark.parametrize(
    ("joints", "elbow", "hand"),
    [
        ((0, 0, 0, -0.0349), (0.06364, 0.182853, 0.43), (0.146794, 0.260397, 0.41769)),
        ((1.4, 0.2, -1.2, -0.6), (-0.013136, 0.135155, 0.331527), (0.048224, 0.174735, 0.243507)),
    ],
)
def test_the_contracts_spatial_arm_is_where_the_contract_says(joints, elbow, hand):
    found = at(NAO, joints)
    assert found[0] == pytest.approx(elbow, abs=6e-7) and found[1] == pytest.approx(hand, abs=6e-7)
    assert found[2] == pytest.approx((found[1] - found[0]) / np.linalg.norm(found[1] - found[0]))


def test_the_contracts_chains_are_where_the_contract_says():
    _, hand, axis = at(answers.CHAIN_ARM, [0.4, 0.25, -0.7])
    assert hand == pytest.approx((1.134107, 2.330568, 0.070547), abs=6e-7)
    assert axis == pytest.approx((-0.242180, -0.596964, -0.764842), abs=6e-7)
    _, hand, _ = at(PLANAR_2, [0.3, -0.5])
    assert hand == pytest.approx((0.889296, 0.064319, 0.0), abs=6e-7)


def test_the_hands_velocity_is_its_derivative():
    arm, h = geometry.arm_of(answers.CHAIN_ARM), 1e-6
    curve, t = (
        geometry.curve_in(answers.CHAIN_PATH),
        np.concatenate([np.linspace(0.01, 0.29), np.linspace(0.31, 0.69)]),
    )
    ahead, behind = (geometry.hand_of(arm, curve.joints(t + side))[0] for side in (h, -h))
    piece, since = curve.pieces(t)
    found = arm.geometry.velocity(curve.joints(t), curve.rates(piece, since), *arm.points["hand"])
    assert found == pytest.approx((ahead - behind) / (2.0 * h), abs=1e-5)


def test_cubic_curves_are_those_of_hermite():
    """Textbook formulas, between samples."""
    curve, path = (
        geometry.curve_in(answers.CHAIN_PATH),
        {k: np.array(v) for k, v in answers.CHAIN_PATH.items()},
    )
    for k, h in enumerate(np.diff(path["time"])):
        s = np.linspace(0.0, 1.0, 30)[:, None]
        first, last = path["joints"][k : k + 2]
        rise, fall = path["rates"][k : k + 2]
        expected = (1 + 2 * s) * (1 - s) ** 2 * first + s * s * (3 - 2 * s) * last
        expected += s * (1 - s) ** 2 * h * rise + s * s * (s - 1) * h * fall
        found = curve.within(np.full(30, k), h * s[:, 0])
        assert found == pytest.approx(expected, abs=1e-12)


@pytest.mark.parametrize("shape", SHAPES + FLAT, ids=lambda shape: shape["kind"])
def test_segments_are_as_near_as_their_nearest_points(shape):
    rng = np.random.default_rng(1)
    a, b = rng.uniform(-1.0, 1.0, (2, 300, 3))
    found, s = geometry.segment_gaps(shape, a, b), np.linspace(0.0, 1.0, 4001)[:, None]
    for k in range(300):
        dense = geometry.point_gaps(shape, a[k] + s * (b[k] - a[k])).min()
        if dense > 0.0 or shape["kind"] != "polygon":
            assert dense - 1e-3 <= found[k] <= dense + 1e-8
        else:  # the depth of a polygon is that in the middle of a crossing
            assert dense - 1e-3 <= found[k] < 1e-9


def test_segments_apart_by_minimising():
    rng = np.random.default_rng(2)
    a, b, c, d = rng.uniform(-1.0, 1.0, (4, 30, 3))
    found = geometry.segments_apart(a, b, c, d)
    for k in range(30):

        def apart(x, k=k):
            return np.linalg.norm(a[k] + x[0] * (b[k] - a[k]) - c[k] - x[1] * (d[k] - c[k]))

        tries = [minimize(apart, x, bounds=[(0, 1)] * 2) for x in ([0.1, 0.9], [0.9, 0.1])]
        assert found[k] == pytest.approx(min(r.fun for r in tries), abs=1e-5)


def test_polygons_know_inside_from_outside():
    bay = [[0, 0], [3, 0], [3, 3], [2, 3], [2, 1], [1, 1], [1, 3], [0, 3]]
    points = np.array([(0.5, 2.0), (1.5, 2.0), (2.5, 2.0), (1.5, 0.5), (4.0, 1.0)])
    found = inside({"kind": "polygon", "vertices": bay}, np.column_stack([points, np.zeros(5)]))
    assert found.tolist() == [True, False, True, True, False]


def test_a_pendulum_swings_as_scipy_says():
    t = np.linspace(0.0, 2.9, 30)
    centre, turn = geometry.poses({"motion": SWING}, t)

    def rate(_, x):
        return [x[1], -9.81 / 1.1 * math.sin(x[0]) - 0.3 * x[1]]

    angle = solve_ivp(rate, (0, 3), [1.2, -2.0], t_eval=t, rtol=1e-12, atol=1e-12).y[0]
    along = np.stack([-np.sin(angle), 0.0 * angle, -np.cos(angle)], axis=1)
    assert centre == pytest.approx(np.array(SWING["pivot"]) + 0.9 * along, abs=1e-8)
    assert turn[:, :, 2] == pytest.approx(along, abs=1e-8)
    assert turn[:, :, 1] == pytest.approx(np.broadcast_to([0.0, 1.0, 0.0], (30, 3)))


def test_bodies_turn_about_the_worlds_axes():
    """A long box along x, first turned a quarter about z, then spinning a quarter about x."""
    half = math.sqrt(0.5)
    motion = still([1.0, 0.0, 0.0], orientation=[half, 0.0, 0.0, half])
    motion |= {"spin": [0.5 * math.pi, 0.0, 0.0], "velocity": [1.0, 0.0, 0.0]}
    box = body("obstacle", "box", {"kind": "box", "half_extents": [0.5, 0.1, 0.2]}, motion)
    assert geometry.signed_distance(box, 0.0, [1.0, 0.6, 0.0]) == pytest.approx(0.1)
    assert geometry.signed_distance(box, 1.0, [2.0, 0.0, 0.6]) == pytest.approx(0.1)
    assert geometry.signed_distance(box, 1.0, [2.0, 0.05, 0.0]) == pytest.approx(-0.1)


def test_bodies_that_hardly_turn_stay_as_they_are():
    motion = still([1.0, 0.0, 0.0], spin=[0.0, 1e-220, 0.0])
    (centre,), (turn,) = geometry.poses({"motion": motion}, [0.5])
    assert centre.tolist() == [1.0, 0.0, 0.0] and turn == pytest.approx(np.eye(3))


def test_sampled_motions_turn_the_short_way_and_rest_at_last():
    half = math.sqrt(0.5)
    motion = {"kind": "sampled", "times": [0, 1], "positions": [[0, 0, 0], [2, 0, 0]]}
    motion["orientations"] = [[1, 0, 0, 0], [-half, 0, 0, -half]]  # a quarter about z
    centre, turn = geometry.poses({"motion": motion}, [0.5, 1.0, 2.0])
    assert centre[:, 0].tolist() == [1.0, 2.0, 2.0]
    assert turn[0] @ [1, 0, 0] == pytest.approx([half, half, 0])
    for last in turn[1:]:
        assert last @ [1, 0, 0] == pytest.approx([0, 1, 0])


def test_a_new_piece_holds_from_its_start():
    pieces = [{"start": 0} | still([0, 0, 0], velocity=[1.0, 0, 0])]
    pieces.append({"start": 1} | still([1, 0, 0], velocity=[0, 2.0, 0]))
    centre, _ = geometry.poses({"motion": {"kind": "piecewise", "pieces": pieces}}, [0.5, 1.0, 2.0])
    assert centre == pytest.approx(np.array([[0.5, 0, 0], [1, 0, 0], [1, 2, 0]]))


@pytest.mark.parametrize("kind", ["quadratic", "piecewise", "sampled", "pendulum"])
def test_bounds_of_bodies_hold(kind, rng):
    """No point of a body gets farther from the middle of an interval than its bound."""
    laws = {"quadratic": still([0, 0, 0], velocity=[1.0, -2.0, 0.5], acceleration=[0, 0, -9.8]),
            "pendulum": SWING}  # fmt: skip
    second = {"start": 0.7} | still([0.7, -1.4, -2.051], velocity=[9.0, 0, 0])
    laws["piecewise"] = {"kind": kind, "pieces": [{"start": 0} | laws["quadratic"], second]}
    laws["quadratic"] = laws["quadratic"] | {"spin": [1.0, 2.0, -3.0]}
    laws["sampled"] = {"kind": kind, "times": [0, 0.2, 1], "positions": rng.normal(size=(3, 3))}
    laws["sampled"]["orientations"] = [[1, 0, 0, 0], [0.8, 0.6, 0, 0], [0.6, 0, 0.8, 0]]
    made = body("obstacle", "", {"kind": "box", "half_extents": [0.3, 0.2, 0.1]}, laws[kind])
    (read,) = bodies_of([made], 1.5)
    corner = np.array([0.3, 0.2, 0.1])
    for _ in range(50):
        low, high = np.sort(rng.uniform(0.0, 1.5, 2))
        middle = np.array([0.5 * (low + high)])
        centre, turn = read.poses(np.concatenate([middle, np.linspace(low, high, 101)]))
        places = centre + turn @ corner
        far = np.linalg.norm(places[1:] - places[0], axis=1).max()
        assert far <= read.ways(np.array([low]), middle, np.array([high]))[0] + 1e-9


@pytest.mark.parametrize(("gap", "caught"), [(0.0399, True), (0.0401, False)])
def test_the_grasp_of_planar_targets(gap, caught):
    situation, solution = answers.planar()
    x, y = solution["trajectory"]["hand"][-1]
    square = {"kind": "polygon", "vertices": [[-0.1, -0.1], [0.1, -0.1], [0.1, 0.1], [-0.1, 0.1]]}
    for shape in (square, {"kind": "disc", "radius": 0.1}):
        situation["bodies"][0]["shape"] = shape
        situation["bodies"][0]["motion"] = answers.LEVEL | {"position": [x + 0.1 + gap, y]}
        assert (judge(situation, solution) == []) == caught


@pytest.mark.parametrize(("gap", "caught"), [(0.0399, True), (0.0401, False)])
def test_the_grasp_of_solids_is_measured_in_the_plane_to_their_cut(gap, caught):
    """A ball whose centre is 0.06 above the plane is cut in a disc of radius 0.08."""
    situation, solution = answers.planar()
    x, y = solution["trajectory"]["hand"][-1]
    situation["plane"] = {"origin": [0, 0, 0], "x": [1, 0, 0], "y": [0, 1, 0]}
    for shape in (ball(0.1), {"kind": "box", "half_extents": [0.08, 0.2, 0.1]}):
        goal = body("target", "goal", shape, still([x + 0.08 + gap, y, 0.06]))
        solid = situation | {"bodies": [goal]}
        assert (judge(solid, solution | {"clearance": None}) == []) == caught
    over = body("target", "goal", ball(0.1), still([x, y, 0.11]))  # it does not meet the plane
    found = judge(situation | {"bodies": [over]}, solution | {"clearance": None})
    assert ["misses" in str(complaint) for complaint in found] == [True]


@pytest.mark.parametrize("tilt", [1e-1, 1e-3, 1e-4])
def test_the_grasp_of_a_plate_that_hardly_meets_the_plane_is_measured_in_the_plane(tilt):
    """Beyond the cut of a tilted plate, 2e-6 thick, the solid stays near for long."""
    situation, solution = answers.planar()
    x, y = solution["trajectory"]["hand"][-1]
    situation["plane"] = {"origin": [0, 0, 0], "x": [1, 0, 0], "y": [0, 1, 0]}
    turn = [np.cos(0.5 * tilt), 0.0, np.sin(0.5 * tilt), 0.0]
    edge = 1e-6 / np.sin(tilt)  # half the width of the cut
    plate = {"kind": "box", "half_extents": [0.1, 0.1, 1e-6]}
    for off, caught in ((-1e-5, True), (1e-5, False)):
        motion = still([x + 0.04 + off + edge, y, 0.0]) | {"orientation": turn}
        solid = situation | {"bodies": [body("target", "goal", plate, motion)]}
        assert (judge(solid, solution | {"clearance": None}) == []) == caught


@pytest.mark.parametrize("case", answers.MADE)
def test_a_catch_at_once_has_one_sample(case):
    situation, solution = answers.MADE[case]()
    solution["trajectory"] = {k: v[:1] for k, v in solution["trajectory"].items()}
    goal = situation["bodies"][0]
    arm = arm_in(situation, {})
    hand = np.array(solution["trajectory"]["hand"][0])
    goal["motion"]["position"] = (arm.plane.lift(hand) if "plane" in situation else hand).tolist()
    goal.pop("approach", None)
    solution |= {"catch_time": 0.0, "catch_body": goal["name"]}
    if "catches" in solution:
        solution["catches"], situation["catch"] = [{"body": goal["name"], "time": 0.0}], "most"
    situation["bodies"] = situation["bodies"][:1]
    assert judge(situation, solution | {"clearance": None}) == []
    goal["motion"]["position"][0] += 0.5
    assert "misses" in str(judge(situation, solution | {"clearance": None})[0])


def test_the_axis_of_a_spatial_arm_is_that_of_its_forearm():
    situation, solution = answers.spatial(version=3)
    _, _, axis = at(answers.SPATIAL_ARM, answers.JOINTS[-1])
    for within, off, kept in ((0.0, 0.0, True), (0.3, 0.29, True), (0.3, 0.31, False)):
        side = np.cross(axis, [0.0, 0.0, 1.0])
        side /= np.linalg.norm(side)
        wanted = math.cos(off) * axis + math.sin(off) * side
        situation["bodies"][0]["approach"] = {"axis": wanted.tolist(), "within": within}
        assert (judge(situation, solution) == []) == kept


def test_catches_at_one_time_stand_in_the_order_of_bodies():
    situation, solution = answers.chain()
    situation["bodies"][1] |= {k: situation["bodies"][0][k] for k in ("motion", "shape")}
    both = [{"body": "second", "time": 0.7}, {"body": "first", "time": 0.7}]
    assert judge(situation, solution | {"catches": both, "catch_body": "first"}) == []
    found = judge(situation, solution | {"catches": both[::-1], "catch_body": "second"})
    assert [str(complaint) for complaint in found] == ["chain: catches: are not in order of time"]
