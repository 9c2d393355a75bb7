"""Promises at every instant: limits to what the contract grants, and contacts between samples."""

import math

import numpy as np
import pytest
from scipy.optimize import minimize

from gcm_learn.referee import examine, judge
from gcm_learn.referee.planar_arm import HandMotion, joint_rates, read_planar
from gcm_learn.situation import situation_from_json
from tests import geometry
from tests.planar_geometry import elbow_of, point_distances
from tests.referee.answers import SPATIAL_ARM, TIME, chain, planar, spatial
from tests.worlds import SHAPES, ZERO, ball, body, law, still

GRANTED = 1e-6  # relative, by the contract


def words(situation, solution):
    return " | ".join(map(str, judge(situation, solution)))


def chains_of(situation, solution):
    """The arm, and the curves of its joints."""
    return geometry.arm_of(situation["arm"]), geometry.curve_in(solution["trajectory"])


def granted(make, field, value):
    """Complaints when a limit is a hair below a value, within what is granted and beyond it."""
    results = []
    for share in (0.5, 2.0):
        situation, solution = make()
        place = situation["arm"]
        for key in field[:-1]:
            place = place[key]
        place[field[-1]] = value / (1.0 + share * GRANTED)
        results.append(words(situation, solution))
    return results


def most(make, order):
    """Largest derivatives of the joints, by dense samples of the curves."""
    _, curve = chains_of(*make())
    rows = []
    for piece, span in zip(curve.powers, curve.spans, strict=True):
        s = np.linspace(0.0, span, 20_001)
        rows.append([np.abs(np.polynomial.Polynomial(c).deriv(order)(s)).max() for c in piece])
    return np.max(rows, axis=0)


@pytest.mark.parametrize("near", [1e-2, 1e-4, 1e-6])
def test_a_hand_that_passes_the_shoulder_turns_the_arm_as_fast_as_it_is_near(near):
    """With equal segments the shoulder turns with the direction of the hand where it is nearest."""
    situation, _ = planar()
    situation["arm"]["upper_arm"] = 1.0
    path = np.array([[-0.31, near], [0.5, near]])
    rates = joint_rates(read_planar(situation), np.array([0.0, 0.81]), path)
    assert rates[0, 0] == pytest.approx(1.0 / near, rel=1e-4)


@pytest.mark.parametrize("smooth", [False, True])
@pytest.mark.parametrize("joint", range(4))
def test_joint_speeds_are_kept_to_the_granted_hair(smooth, joint):
    def make():
        return spatial(smooth)

    fine, broken = granted(make, ("max_joint_speed", joint), float(most(make, 1)[joint]))
    assert fine == "" and f"joint {joint} moves too fast" in broken


@pytest.mark.parametrize("joint", range(4))
def test_accelerations_are_kept_to_the_granted_hair(joint):
    def make():
        return spatial(True)

    fine, broken = granted(make, ("max_joint_acceleration", joint), float(most(make, 2)[joint]))
    assert fine == "" and f"joint {joint} accelerates too much" in broken


@pytest.mark.parametrize("smooth", [False, True])
@pytest.mark.parametrize("joint", range(3))
def test_limits_of_chains_are_kept_to_the_granted_hair(smooth, joint):
    def make():
        return chain(smooth)

    fast = ("model", "joints", joint, "max_speed")
    fine, broken = granted(make, fast, float(most(make, 1)[joint]))
    assert fine == "" and f"joint {joint} moves too fast" in broken


@pytest.mark.parametrize("smooth", [False, True])
@pytest.mark.parametrize(("joint", "side"), [(0, 1), (1, 0), (1, 1), (2, 1), (3, 0), (3, 1)])
def test_ranges_are_kept_between_samples_too(smooth, joint, side):
    situation, solution = spatial(smooth)
    _, curve = chains_of(situation, solution)
    q = curve.joints(np.union1d(np.linspace(0.0, 0.7, 200_001), TIME))[:, joint]
    end = float(q.max() if side else q.min())
    for share, fine in ((0.5, True), (2.0, False)):
        inward = abs(end) * share * GRANTED * (-1 if side else 1)
        situation["arm"]["joint_range"][joint][side] = end + inward
        assert (f"joint {joint} leaves its range" in words(situation, solution)) != fine


@pytest.mark.parametrize("span", [1e-6, 1e-10, 1e-13, 1e-15])
def test_rates_do_not_leap_in_however_short_a_time(span):
    """A short piece hides an acceleration from differences of joints, but not from rates."""
    situation, solution = chain()
    path = solution["trajectory"]
    for name in path:
        path[name].insert(1, list(path[name][0]) if name != "time" else span)
    path["rates"][1] = [1.0, 0.3, 0.5]
    assert "joint 1" in words(situation, solution)


@pytest.mark.parametrize("make", [spatial, chain], ids=["spatial", "chain"])
@pytest.mark.parametrize("smooth", [False, True])
def test_the_hands_speed_is_kept_to_the_granted_hair(make, smooth):
    situation, solution = make(smooth)
    arm, curve = chains_of(situation, solution)
    fastest, h = 0.0, 1e-5
    for k, span in enumerate(curve.spans):
        s = np.linspace(0.0, span, 4001)
        ahead, behind = (
            geometry.hand_of(arm, curve.within(np.full(4001, k), s + d))[0] for d in (h, -h)
        )
        fastest = max(fastest, float(np.linalg.norm(ahead - behind, axis=1).max() / (2.0 * h)))
    fine, broken = granted(lambda: make(smooth), ("max_hand_speed",), fastest)
    assert fine == "" and "the hand is too fast" in broken


@pytest.mark.parametrize("make", [planar, spatial, chain], ids=["planar", "spatial", "chain"])
def test_the_grasp_is_exact(make):
    for off in (-3e-6, 3e-6):
        situation, solution = make()
        goal = situation["bodies"][0]
        hand = np.array(solution["trajectory"]["hand"][-1])
        away = goal["shape"]["radius"] + situation["arm"]["grasp"] + off
        goal["motion"]["position"] = (hand - [0.0, away, 0.0][: len(hand)]).tolist()
        assert ("misses" in words(situation, solution)) == (off > 0.0)


@pytest.mark.parametrize("smooth", [False, True])
@pytest.mark.parametrize("off", [-1e-6, 1e-6])
def test_thickness_is_kept_between_samples(smooth, off):
    """A ball that the elbow passes nearest in the middle of a piece."""
    situation, solution = spatial(smooth, thickness=0.0)
    arm, curve = chains_of(situation, solution)
    shoulder = np.array(SPATIAL_ARM["base"]["origin"])
    middle = geometry.links_of(arm, curve.joints(np.array([0.21])))[0][0, 1, 0]
    centre = middle + 0.3 * (middle - shoulder) / np.linalg.norm(middle - shoulder)
    situation["bodies"][1] = body("obstacle", "post", ball(0.1), still(centre))

    def gap(t):
        t = np.clip(np.atleast_1d(t)[:1], 0.0, 0.7)
        return geometry.least_at(situation, arm, t, curve.joints(t))[0]

    found = minimize(gap, [0.21], method="Nelder-Mead", options={"xatol": 1e-9, "fatol": 1e-12})
    room = min(float(found.fun), *(gap(at) for at in np.linspace(0.0, 0.7, 50)))
    situation["arm"]["thickness"] = room + off
    assert ("touch" in words(situation, solution | {"clearance": -off})) == (off > 0.0)


def test_a_bullet_between_samples_is_seen():
    """It crosses the forearm within a thousandth of a second, half way between two samples."""
    situation, solution = spatial(thickness=0.0)
    arm, curve = chains_of(situation, solution)
    moment = 0.5123
    elbow, hand = geometry.links_of(arm, curve.joints(np.array([moment])))[0][1, :, 0]
    spot = 0.4 * elbow + 0.6 * hand
    across = np.cross(hand - elbow, [0.3, 0.5, 0.7])
    velocity = 900.0 * across / np.linalg.norm(across)
    motion = still(spot - moment * velocity, velocity=velocity.tolist())
    situation["bodies"][1] = body("obstacle", "bullet", ball(1e-3), motion)
    assert "bullet touch" in words(situation, solution)
    motion["position"] = (spot + 0.9 * (hand - elbow) - moment * velocity).tolist()
    assert "touch" not in words(situation, solution)


@pytest.mark.parametrize("part", ["upper arm", "forearm"])
def test_a_bullet_between_samples_of_the_hand_is_seen(part):
    situation, solution = planar()
    path, moment = solution["trajectory"], 0.5512
    hand = np.array([np.interp(moment, path["time"], x) for x in np.transpose(path["hand"])])
    angle = np.interp(moment, path["time"], np.array(path["joints"])[:, 0])
    elbow = 1.2 * np.array([np.cos(angle), np.sin(angle)])
    spot = 0.5 * elbow if part == "upper arm" else 0.3 * elbow + 0.7 * hand
    velocity = 500.0 * np.array([elbow[1] - hand[1], hand[0] - elbow[0]])
    beyond = hand + 0.2 * (hand - elbow)
    motion = {"kind": "quadratic", "position": (spot - moment * velocity).tolist()}
    motion |= {"velocity": velocity.tolist(), "acceleration": [0.0, 0.0]}
    situation["arm"]["thickness"] = 0.0
    for shape in (
        {"kind": "disc", "radius": 1e-3},
        {"kind": "polygon", "vertices": [[-1e-3, 0.0], [1e-3, 0.0], [0.0, 2e-3]]},
    ):
        situation["bodies"][1] = body("obstacle", "bullet", shape, motion)
        assert "bullet touch" in words(situation, solution)
        off = motion | {"position": (beyond - moment * velocity).tolist()}
        situation["bodies"][1] = body("obstacle", "bullet", shape, off)
        assert "touch" not in words(situation, solution)


def at_a_moment(place, t):
    """Motions that are at a place at t only, under every law."""
    place, way = np.array(place), np.array([0.5, -3.0, 2.0])
    start = place - t * way
    pieces = [{"start": 0.0} | still(start, velocity=way.tolist())]
    pieces.append({"start": t} | still(place, velocity=(-way).tolist()))
    swing = {"kind": "pendulum", "axis": [0, 1, 0], "down": [0, 0, -1], "length": 0.5, "rate": 8.0}
    swing |= {"gravity": 9.8, "angle": -1.0, "pivot": ZERO}
    centre, _ = geometry.poses({"motion": swing}, [t])
    return {
        "quadratic": still(start, velocity=way.tolist()),
        "piecewise": {
            "kind": "piecewise",
            "pieces": [{k: v for k, v in piece.items() if k != "kind"} for piece in pieces],
        },
        "sampled": {
            "kind": "sampled",
            "times": [0.0, t, 2.0 * t],
            "positions": [start.tolist(), place.tolist(), start.tolist()],
        },
        "pendulum": swing | {"pivot": (place - centre[0]).tolist()},
    }


@pytest.mark.parametrize("kind", ["quadratic", "piecewise", "sampled", "pendulum"])
@pytest.mark.parametrize("shape", SHAPES, ids=lambda shape: shape["kind"])
def test_an_obstacle_between_samples_is_found(shape, kind):
    """It is small, crosses a link at one moment, and counts only where it is not ignored."""
    situation, solution = chain()
    arm, curve = chains_of(situation, solution)
    t, small = 0.4321, {"half_extents": [0.02] * 3, "radius": 0.015, "half_length": 0.01}
    spot = geometry.links_of(arm, curve.joints(np.array([t])))[0][2, :, 0].mean(axis=0)
    fly = {"kind": shape["kind"]} | {k: small[k] for k in shape if k != "kind"}
    situation["bodies"].append(body("obstacle", "fly", fly, at_a_moment(spot, t)[kind]))
    assert "fly touch" in words(situation, solution)
    situation["arm"]["ignore"] = [[k, "fly"] for k in range(3)]
    assert words(situation, solution) == ""


@pytest.mark.parametrize("kind", ["quadratic", "pendulum"])
@pytest.mark.parametrize("shape", SHAPES, ids=lambda shape: shape["kind"])
def test_the_clearance_is_that_of_dense_samples(shape, kind, rng):
    for k in range(4):
        situation, solution = spatial(bool(k % 2), thickness=0.0)
        situation["bodies"][1] = body("obstacle", "post", shape, law(rng, kind))
        arm, curve = chains_of(situation, solution)
        found = geometry.lowest_gap(situation, solution["trajectory"], 1e-6)
        t = np.linspace(0.0, 0.7, 4001)
        least = geometry.least_at(situation, arm, t, curve.joints(t))[0]
        assert found <= least + 1e-6 and least <= found + 2e-3


def test_the_clearance_of_planar_arms_is_that_of_dense_samples(rng):
    situation, solution = planar()
    path = {name: np.array(column) for name, column in solution["trajectory"].items()}
    for k in range(6):
        corner = [[0.3, 0.3], [0.9, 0.4], [0.6, 0.8]]  # a polygon beside its centre
        situation["bodies"][2]["shape"]["vertices"] = (np.array(corner) * (0.3 + 0.4 * k)).tolist()
        situation["bodies"][1]["motion"]["position"] = rng.uniform(-2.5, 2.5, 2).tolist()
        situation["bodies"][1]["motion"]["velocity"] = rng.normal(size=2).tolist()
        verdict = examine(situation, solution)
        if verdict.clearance is None or verdict.clearance < 0.0:
            continue
        expected = dense_clearance(situation, path)
        assert verdict.clearance == pytest.approx(expected, abs=1e-3)


def dense_clearance(situation, path):
    """Least distance of points of the limb to all obstacles, less the thickness."""
    record, least = situation_from_json(situation), math.inf
    for t in np.linspace(0.0, 1.0, 1001):
        hand = np.array([[np.interp(t, path["time"], x) for x in path["hand"].T]])
        elbow = elbow_of(record.arm, hand)
        s = np.linspace(0.0, 1.0, 60)[:, None]
        limb = np.concatenate([s * elbow, elbow + s * (hand - elbow)])
        for obstacle in record.obstacles:
            m = obstacle.motion
            a, at = m.angle + m.spin * t, np.array(m.position) + t * np.array(m.velocity)
            turn = np.array([[np.cos(a), -np.sin(a), 0], [np.sin(a), np.cos(a), 0], [0, 0, 1]])
            pose = np.append(at, 0.0), turn
            least = min(least, point_distances(obstacle.shape, pose, limb).min())
    return least - record.arm.thickness


def test_bounds_of_motion_hold(rng):
    """No point of a link gets farther from the middle of an interval than its bound."""
    for situation, solution in (chain(), spatial(True)):
        motion = geometry.motion_of(geometry.arm_of(situation["arm"]), solution["trajectory"])
        for _ in range(20):
            low, high = np.sort(rng.uniform(0.0, 0.7, 2))
            middle = 0.5 * (low + high)
            ways = motion.ways(*(np.array([t]) for t in (low, middle, high)))[0]
            moved = motion.ends(np.linspace(low, high, 201)) - motion.ends(np.array([middle]))
            far = np.linalg.norm(moved, axis=-1).max(axis=(0, 2))
            assert (far <= ways + 1e-12).all()


def test_bounds_of_motion_of_planar_arms_hold(rng):
    """Straight hand paths past the shoulder and along the edges of reach, on both sides."""
    held = 0
    for rho in (0.6, 1.0, 1.4):
        situation, _ = planar()
        situation["arm"] |= {"upper_arm": rho, "elbow": str(rng.choice(["left", "right"]))}
        arm = read_planar(situation)
        for _ in range(40):
            hand = rng.uniform(-1.0, 1.0, (2, 2)) * (1.0 + rho) / math.sqrt(2.0)
            motion = HandMotion(arm, np.array([0.0, 1.0]), hand)
            low, middle, high = (np.array([t]) for t in (0.2, 0.5, 0.8))
            t = np.linspace(0.2, 0.8, 401)
            moved = motion.ends(t) - motion.ends(middle)
            far = np.linalg.norm(moved, axis=-1).max(axis=(0, 2))
            if np.linalg.norm(motion.hands(t), axis=1).min() < max(abs(rho - 1.0), 1e-3):
                continue  # out of reach, or through the shoulder
            held += 1
            assert (far <= motion.ways(low, middle, high)[0] + 1e-9).all()
    assert held > 30
