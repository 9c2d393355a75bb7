"""Hypothesis strategies for valid situations: planar, 3D with a planar arm, and in space."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
from hypothesis import strategies as st

from gcm_learn import arms as limbs, situation
from gcm_learn.referee.rotations import rotations as of_quaternion
from gcm_learn.situation.timed_motion import flown

lengths = st.floats(0.01, 0.5)
angles = st.floats(-math.pi, math.pi)
coordinates = st.floats(-3.0, 3.0)
names = st.text(max_size=8)


def vectors(size, elements=coordinates):
    """Tuples of `size` floats."""
    return st.tuples(*[elements] * size)


@st.composite
def unit_vectors(draw, size=3):
    """Unit vectors; quaternions when `size` is 4."""
    vector = draw(vectors(size, st.integers(-9, 9)).filter(any))
    length = math.hypot(*vector)
    return tuple(x / length for x in vector)


@st.composite
def rotations(draw):
    """Rotation matrices (3, 3), including those by quarter turns."""
    return of_quaternion(draw(unit_vectors(4)))


@st.composite
def polygons(draw, max_vertices=7):
    """Star-shaped polygons around the body's origin, convex or not."""
    count = draw(st.integers(3, max_vertices))
    turn = draw(angles)
    corners = []
    for k in range(count):
        # neighbours stay less than half a turn apart, so the polygon is simple
        angle = turn + (k + draw(st.floats(-0.2, 0.2))) * 2 * math.pi / count
        radius = draw(lengths)
        corners.append((radius * math.cos(angle), radius * math.sin(angle)))
    return situation.Polygon(tuple(corners))


discs = st.builds(situation.Disc, lengths)
planar_shapes = st.one_of(discs, polygons())
spheres = st.builds(situation.Sphere, lengths)
boxes = st.builds(situation.Box, vectors(3, lengths))
capsules = st.builds(situation.Capsule, lengths, lengths)
cylinders = st.builds(situation.Cylinder, lengths, lengths)
solid_shapes = st.one_of(spheres, boxes, capsules, cylinders)

planar_motions = st.builds(
    situation.PlanarQuadratic, position=vectors(2), velocity=vectors(2), acceleration=vectors(2),
    angle=st.just(0.0) | angles, spin=st.just(0.0) | coordinates,
)  # fmt: skip
solid_quadratics = st.builds(
    situation.SolidQuadratic, position=vectors(3), velocity=vectors(3), acceleration=vectors(3),
    orientation=st.just((1.0, 0.0, 0.0, 0.0)) | unit_vectors(4),
    spin=st.just((0.0, 0.0, 0.0)) | vectors(3),
)  # fmt: skip


@st.composite
def frames(draw):
    """Two orthogonal unit vectors."""
    rotation = draw(rotations())
    return tuple(rotation[:, 0].tolist()), tuple(rotation[:, 1].tolist())


@st.composite
def pendulums(draw):
    """Pendulums whose cord is of the arm's scale."""
    axis, down = draw(frames())
    return situation.Pendulum(
        pivot=draw(vectors(3)), axis=axis, down=down, length=draw(st.floats(0.2, 4.0)),
        gravity=draw(st.floats(0.0, 80.0)), angle=draw(angles), rate=draw(coordinates),
        damping=draw(st.just(0.0) | st.floats(0.0, 2.0)),
        hang=draw(st.none() | st.floats(0.0, 4.0)),
    )  # fmt: skip


@st.composite
def planes(draw):
    """Planes of any orientation."""
    x, y = draw(frames())
    return situation.Plane(draw(vectors(3)), x, y)


@st.composite
def arms(draw):
    """Arms whose hand is anywhere in the reachable ring."""
    upper_arm = draw(st.just(1.0) | st.floats(0.3, 2.0))
    inner, outer = abs(upper_arm - 1.0), upper_arm + 1.0
    radius = inner + (outer - inner) * draw(st.floats(0.01, 0.99))
    angle = draw(angles)
    return limbs.Arm(
        hand=(radius * math.cos(angle), radius * math.sin(angle)),
        max_hand_speed=draw(st.floats(0.1, 10.0)),
        upper_arm=upper_arm,
        elbow=draw(st.sampled_from(["left", "right"])),
        max_joint_speed=draw(st.none() | vectors(2, st.floats(0.1, 20.0))),
        thickness=draw(st.just(0.0) | st.floats(0.0, 0.1)),
        grasp=draw(st.floats(0.0, 0.2)),
    )


@st.composite
def bases(draw):
    """Poses of a shoulder."""
    return limbs.Base(draw(vectors(3)), draw(st.just((1.0, 0.0, 0.0, 0.0)) | unit_vectors(4)))


@st.composite
def bones(draw):
    """Vectors along x, as a human's, or with offsets, as a robot's."""
    x = draw(st.floats(0.1, 2.0))
    return (x, *draw(st.just((0.0, 0.0)) | vectors(2, st.floats(-0.3, 0.3))))


@st.composite
def joint_ranges(draw, held=True):
    """Ranges of four joints, some of them more than a turn, some perhaps held."""
    widths = st.floats(0.1, 7.0)
    pairs = []
    for _ in range(4):
        low = draw(st.floats(-4.0, 2.0))
        pairs.append((low, low + draw(st.just(0.0) | widths if held else widths)))
    return tuple(pairs)


@st.composite
def spatial_arms(draw, held=True):
    """Arms in space that stand anywhere in their ranges; some joints may be held."""
    ranges = draw(joint_ranges(held))
    speeds = draw(vectors(4, st.floats(0.1, 20.0)))
    fastest = draw(st.none() | vectors(4, st.floats(0.1, 200.0)))
    rates = None
    if fastest is not None and draw(st.booleans()):
        rates = tuple(draw(st.floats(-most, most)) for most in speeds)
    return limbs.SpatialArm(
        upper_arm=draw(bones()), forearm=draw(bones()),
        joints=tuple(draw(st.floats(low, high)) for low, high in ranges), joint_range=ranges,
        max_joint_speed=speeds, grasp=draw(st.floats(0.0, 0.2)), base=draw(bases()),
        joint_rates=rates, max_hand_speed=draw(st.none() | st.floats(0.1, 10.0)),
        max_joint_acceleration=fastest, thickness=draw(st.just(0.0) | st.floats(0.0, 0.1)),
    )  # fmt: skip


@st.composite
def piecewise(draw):
    """Two to four quadratic motions that meet; velocities and spins jump."""
    law, pieces = draw(solid_quadratics), []
    for _ in range(draw(st.integers(1, 3))):
        start = pieces[-1].start + draw(st.floats(0.05, 1.0)) if pieces else 0.0
        if pieces:
            position, turn = flown(pieces[-1].motion, start - pieces[-1].start)
            law = replace(draw(solid_quadratics), position=position, orientation=turn)
        pieces.append(situation.Piece(start, law))
    return situation.Piecewise(tuple(pieces))


@st.composite
def sampled(draw):
    """Poses at one to five times."""
    count = draw(st.integers(1, 5))
    times = [0.0]
    for _ in range(count - 1):
        times.append(times[-1] + draw(st.floats(0.05, 0.8)))
    rows = tuple(draw(vectors(3)) for _ in times)
    if draw(st.booleans()):
        return situation.Sampled(tuple(times), rows)
    turns = [draw(unit_vectors(4))]
    for _ in times[1:]:
        turns.append(draw(unit_vectors(4).filter(lambda q: abs(np.dot(q, turns[-1])) > 1e-3)))
    return situation.Sampled(tuple(times), rows, tuple(turns))


@st.composite
def chain_models(draw, trees=False):
    """Chains of one to four joints, each of which carries a link or two.

    Trees have up to six joints; some stand on any frame before them, and some follow others.
    """
    count = draw(st.integers(2, 6) if trees else st.integers(1, 4))
    limited = draw(st.booleans())
    joints: list[limbs.ChainJoint] = []
    for k in range(count):
        low = draw(st.floats(-3.0, 1.0))
        made = limbs.ChainJoint(
            axis=draw(unit_vectors()), range=(low, low + draw(st.floats(0.0, 4.0))),
            max_speed=draw(st.floats(0.1, 9.0)),
            type=draw(st.sampled_from(["revolute", "prismatic"])),
            origin=draw(vectors(3, st.floats(-1.0, 1.0))), rotation=draw(unit_vectors(4)),
            max_acceleration=draw(st.floats(0.1, 99.0)) if limited else None, name=f"joint {k}",
        )  # fmt: skip
        joints.append(draw(_in_tree(made, joints)) if trees else made)
    ends = vectors(3, st.floats(-1.0, 1.0))
    named = draw(st.sampled_from([[None] * 7, ["base", None, "arm", "arm", "", None, "b"]]))
    links = tuple(
        limbs.Link(k, draw(ends), draw(ends), draw(lengths), named[k]) for k in range(count + 1)
    )
    pairs = draw(st.sampled_from([(), ((0, count),)]))
    hand = limbs.Hand(draw(st.integers(1, count)), draw(ends), draw(unit_vectors()))
    return limbs.ChainModel(draw(names), tuple(joints), links, hand, pairs, draw(names))


@st.composite
def _in_tree(draw, joint, before):
    """A joint on any frame before it, which may follow one of the joints before."""
    joint = replace(joint, parent=draw(st.none() | st.integers(0, len(before))))
    leaders = [k for k, one in enumerate(before, 1) if one.follows is None]
    if not leaders or draw(st.booleans()):
        return joint
    leader, factor = draw(st.sampled_from(leaders)), draw(st.floats(-2.0, 2.0))
    offset, share = draw(st.floats(-1.0, 1.0)), draw(st.floats(0.9, 2.0))
    ends = np.sort([factor * end + offset for end in before[leader - 1].range])
    middle, half = ends.mean(), share * 0.5 * np.ptp(ends) + 1e-3
    least = draw(st.sampled_from([joint.max_acceleration, None]))
    return replace(
        joint, follows=limbs.Follows(leader, factor, offset), max_acceleration=least,
        range=(float(middle - half), float(middle + half)),
    )  # fmt: skip


@st.composite
def chains(draw, trees=False):
    """Chains anywhere in their ranges."""
    model = draw(chain_models(trees))
    limits: Any = draw(st.sampled_from(["model", None]) | vectors(model.dof, st.floats(0.1, 9.0)))
    return limbs.Chain(
        model=model, joints=tuple(draw(st.floats(*ends)) for ends in model.ranges),
        grasp=draw(st.floats(0.0, 0.2)), base=draw(bases()),
        max_hand_speed=draw(st.none() | st.floats(0.1, 9.0)), max_joint_acceleration=limits,
    )  # fmt: skip


approaches = st.builds(situation.Approach, unit_vectors(), st.floats(0.0, math.pi))
solid_motions = st.one_of(solid_quadratics, pendulums(), piecewise(), sampled())


@st.composite
def third_situations(draw, max_bodies=3):
    """Valid situations of version 3: chains or spatial arms, all motions, several catches."""
    arm = draw(chains() | spatial_arms())
    if isinstance(arm, limbs.SpatialArm):
        arm = replace(arm, joint_rates=None)  # the hand's limit holds at t = 0
    catch, bodies = draw(st.sampled_from(situation.CATCHES)), []
    for k in range(draw(st.integers(1, max_bodies))):
        role = "target" if k == 0 or (catch != "any" and draw(st.booleans())) else "obstacle"
        approach = draw(st.just(()) | st.tuples(approaches)) if role == "target" else None
        bodies.append(
            situation.Body(role, str(k), draw(solid_shapes), draw(solid_motions), approach)
        )
    obstacles = [body.name for body in bodies if body.role == "obstacle"]
    if arm.kind == "chain" and obstacles:
        arm = replace(arm, ignore=((arm.model.links[0].name or 0, obstacles[0]),))
    horizon = draw(st.floats(0.05, 3.0))
    version = "gcm-learn/situation@3"
    return situation.Situation(
        draw(names), horizon, arm, tuple(bodies), catch=catch, format=version
    )


def _situations(shapes, motions, planes, max_bodies, arms):
    """Situations whose first body is a target and whose bodies are called 0, 1, ..."""
    parts = st.tuples(st.sampled_from(["target", "obstacle"]), shapes, motions)

    def bodies(drawn):
        return tuple(
            situation.Body("target" if k == 0 else role, str(k), shape, motion)
            for k, (role, shape, motion) in enumerate(drawn)
        )

    return st.builds(
        situation.Situation, name=names, horizon=st.floats(0.05, 3.0), arm=arms,
        bodies=st.lists(parts, min_size=1, max_size=max_bodies).map(bodies), plane=planes,
    )  # fmt: skip


def planar_situations(max_bodies=3):
    """Valid planar situations."""
    return _situations(planar_shapes, planar_motions, st.none(), max_bodies, arms())


def solid_situations(max_bodies=3):
    """Valid 3D situations."""
    motions = st.one_of(solid_quadratics, pendulums())
    return _situations(solid_shapes, motions, planes(), max_bodies, arms())


def spatial_situations(max_bodies=3):
    """Valid situations with a spatial arm."""
    motions = st.one_of(solid_quadratics, pendulums())
    return _situations(solid_shapes, motions, st.none(), max_bodies, spatial_arms())


def situations(max_bodies=3):
    """Valid situations with a planar arm, of either kind."""
    return planar_situations(max_bodies) | solid_situations(max_bodies)


@st.composite
def fourth_situations(draw, max_bodies=3):
    """Valid situations of version 4: those of version 3 with all that it adds."""
    third = draw(third_situations(max_bodies))
    arm, limited = third.arm, third.arm.max_joint_acceleration is not None
    if limited and draw(st.booleans()):
        arm = replace(
            arm, max_joint_jerk=draw(vectors(len(arm.joints), st.floats(1.0, 1e4))),
            joint_accelerations=tuple(draw(st.floats(-a, a)) for a in arm.max_joint_acceleration),
        )  # fmt: skip
    names = tuple(body.name for body in third.obstacles)
    bodies = [draw(_asked(body, limited, names)) for body in third.bodies]
    end = draw(st.sampled_from(situation.ENDS)) if limited else "free"
    end_by = draw(st.none() | st.floats(0.0, 9.0))
    form = "gcm-learn/situation@4"
    return replace(third, arm=arm, bodies=bodies, end=end, end_by=end_by, format=form)


@st.composite
def _asked(draw, body, limited, names):
    """A body with a margin, or with approaches, a hold and a place."""
    if body.role == "obstacle":
        margins = st.builds(situation.Margin, lengths, lengths)
        return replace(body, margin=draw(st.none() | margins))
    first = situation.Approach(draw(unit_vectors()), abs(draw(angles)), draw(unit_vectors()))
    second = situation.Approach(draw(unit_vectors()), math.pi)
    approach = draw(st.sampled_from([(), (first,), (first, second)]))
    body = replace(body, approach=approach)
    if not limited:
        return body
    held = replace(body, hold=situation.Hold(draw(lengths), draw(lengths)))
    placed = replace(held, place=situation.Place(draw(vectors(3)), draw(lengths)))
    carried = replace(placed, ignore=names, ignore_for=draw(lengths) if names else None)
    return draw(st.sampled_from([body, held, placed, carried]))


def any_situations(max_bodies=3):
    """Valid situations with any arm."""
    older = situations(max_bodies) | spatial_situations(max_bodies)
    return older | third_situations(max_bodies) | fourth_situations(max_bodies)
