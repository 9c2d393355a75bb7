"""Views of a situation: bodies as faces, ways of targets, paths coloured by time."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from gcm_learn.arms import quaternion_of
from gcm_learn.motion import Carry, Movement
from gcm_learn.planners import Plan
from gcm_learn.rendering import staging
from gcm_learn.rendering.camera import Camera, Faces, Window, camera_from, render
from gcm_learn.rendering.shells import COARSE, FACES, shell
from gcm_learn.rendering.solids import arm_faces, arrow, frame_along, limb_along, placed, tube
from gcm_learn.situation import Body, Cloud, Sampled

SMALLEST = 0.018  # of the reach: smaller targets are drawn so large
ARROW = 0.16  # of the reach: length of an approach
SHELL = 0.15  # alpha of margins
CARRY = 60  # samples of a target's motion before the end of its hold, and as many of its carry
BEFORE = 0.012  # of the reach: from the point of an approach to the target


def body_faces(
    situation: staging.JointSituation, t: float, alpha: float = 1.0, roles: Sequence[str] = ()
) -> Iterator[Faces]:
    """Yield the faces of all bodies, or of bodies in some roles, at time t [s], with approaches.

    The ground is not among them: the stage has a floor there. Margins are about opaque bodies.
    """
    (centres, turns), ground = staging.body_poses(situation, [t]), staging.ground_of(situation)
    for body, centre, turn in zip(situation.bodies, centres[0], turns[0], strict=True):
        if (roles and body.role not in roles) or (ground is not None and body is ground.body):
            continue
        yield solid_faces(situation, body, centre, turn, alpha)
        if body.margin is not None and alpha == 1.0 and (wide := margin_at(body, t)) > 0.0:
            about = shell(body.shape, faces_each(situation))  # type: ignore[arg-type]
            corners = centre + (about.start + wide * about.outward) @ turn.T
            yield Faces(corners, staging.rgb(staging.OBSTACLE), SHELL, about.outward @ turn.T)
        if body.approach:
            corners = centre + approach_corners(situation, body) @ turn.T
            yield Faces(corners, staging.rgb(staging.APPROACH), alpha)


def solid_faces(
    situation: staging.JointSituation,
    body: Body,
    centre: np.ndarray,
    turn: np.ndarray,
    alpha: float = 1.0,
) -> Faces:
    """Return the faces of a body with centre (3,) and rotation (3, 3)."""
    colour, scale = staging.rgb(staging.body_colour(body)), drawn_scale(situation, body)
    most = faces_each(situation)
    return placed(body.shape, centre, turn, colour, alpha, scale, most)  # type: ignore[arg-type]


def faces_each(situation: staging.JointSituation, of: int = FACES) -> int:
    """Return the share of each cloud, and of each margin, in so many faces."""
    several = [body for body in situation.bodies if body.margin or isinstance(body.shape, Cloud)]
    return max(COARSE, of // max(1, len(several)))


def margin_at(body: Body, t: ArrayLike) -> Any:
    """Return the distance that links keep from a body at times t [s]."""
    return 0.0 if body.margin is None else body.margin.now + body.margin.rate * np.asarray(t)


def with_carries(situation: staging.JointSituation, plan: Plan | None) -> staging.JointSituation:
    """Return a situation for pictures, in which carried targets follow the hand until placed.

    Their motion is sampled; after that they rest.
    """
    bodies, names = list(situation.bodies), [body.name for body in situation.bodies]
    for one in () if plan is None else plan.catches:
        if "placed" in one:
            assert plan is not None and plan.trajectory is not None
            held, k = one["held_until"], names.index(one["body"])
            first = np.linspace(0.0, held, CARRY, endpoint=False)
            last = np.linspace(held, one["placed"], CARRY)
            places, turns = (part[:, k] for part in staging.body_poses(situation, first))
            there, turned = Carry(situation, k, plan.trajectory, held).poses(last)
            rows = np.concatenate([places, there]), np.concatenate([turns, turned])
            motion = Sampled(
                tuple(np.concatenate([first, last]).tolist()),
                tuple(map(tuple, rows[0].tolist())),
                tuple(map(quaternion_of, rows[1])),
            )
            bodies[k] = replace(bodies[k], motion=motion)
    return replace(situation, bodies=tuple(bodies))


def drawn_scale(situation: staging.JointSituation, body: Body) -> float:
    """Return the factor by which a small target is enlarged to be seen; 1 for other bodies."""
    if body.role != "target":
        return 1.0
    return max(1.0, SMALLEST * situation.arm.reach / body.shape.bounding_radius)


def approach_corners(situation: staging.JointSituation, body: Body) -> np.ndarray:
    """Return the arrows (n, 4, 3) along which a hand catches a target, in the target's frame."""
    reach = situation.arm.reach
    surface = drawn_scale(situation, body) * body.shape.bounding_radius
    pointing = arrow(ARROW * reach, surface + BEFORE * reach)
    axes = [np.asarray(approach.axis) for approach in body.approach]
    return np.concatenate([pointing @ frame_along(axis).T for axis in axes])


LINE = 0.007  # of the reach: radius of a path
SAMPLES = 60  # points of a path


def path_faces(
    situation: staging.JointSituation, trajectory: Movement, until: float | None = None
) -> Iterator[Faces]:
    """Yield the paths of the hand and, dashed, of the targets, up to a time [s]."""
    end = trajectory.duration
    times = np.linspace(0.0, end if until is None else until, SAMPLES)
    radius = LINE * situation.arm.reach
    yield from tube_faces(trajectory.hand_at(times), times / max(end, 1e-9), radius)
    base, ground = np.asarray(situation.arm.base.origin), staging.ground_of(situation)
    for path in target_paths(situation, times):
        far = np.linalg.norm(path - base, axis=1).max() / situation.arm.reach
        seen = far < staging.LONGEST and (ground is None or path[:, 2].min() > ground.height)
        for faces in tube_faces(path, times / max(end, 1e-9), 0.8 * radius, dashed=True):
            yield faces._replace(kept=bool(seen))


def target_paths(situation: staging.JointSituation, times: np.ndarray) -> np.ndarray:
    """Return the places (m, k, 3) of the targets' centres at times (k,) [s], in the world."""
    targets = [body.role == "target" for body in situation.bodies]
    return np.swapaxes(staging.body_poses(situation, times)[0][:, targets], 0, 1)


def tube_faces(
    path: np.ndarray, shares: np.ndarray, radius: float, *, dashed: bool = False
) -> Iterator[Faces]:
    """Yield a path (k, 3) as a tube, coloured by shares (k,) of the time; nothing if short."""
    if np.ptp(path, axis=0).max() <= radius:
        return
    shades = staging.time_colours(0.5 * (shares[1:] + shares[:-1]))
    shown = np.arange(len(shades)) % 3 != 2 if dashed else np.ones(len(shades), dtype=bool)
    parts = tube(path, radius).reshape(len(shades), 6, 4, 3)[shown]
    yield Faces(parts.reshape(-1, 4, 3), np.repeat(shades[shown], 6, axis=0)[:, None])


FARTHEST = 2.0  # [reaches] from the base: ways from farther away are not whole in a still picture
CUBE = np.array([(x, y, z) for x in (-1, 1) for y, z in ((-1, -1), (1, -1), (1, 1), (-1, 1))])


class TargetWay(NamedTuple):
    """Path of a target until the hand is nearest, as a cube about the target at each instant."""

    times: np.ndarray
    """(k,) float: instants from 0 on [s]."""
    corners: np.ndarray
    """(k, 2, 4, 3) float: two opposite faces of a cube at each instant, in the world."""
    near: int
    """First instant from which on the target is no farther than `FARTHEST` from the base."""

    def faces(self, first: int = 0) -> Faces:
        """Return the cubes from an instant on, to be kept in a picture."""
        return Faces(self.corners[first:].reshape(-1, 4, 3), np.zeros(3), kept=True)

    def reach_seen(self, view: Camera, t: float) -> float:
        """Return how far from the middle of the picture the way from time t [s] on is."""
        first = min(int(np.searchsorted(self.times, t, side="right")) - 1, self.near)
        return float(np.abs(view.see(self.corners[first:])[..., :2]).max())


def target_way(
    situation: staging.JointSituation, times: np.ndarray, places: np.ndarray, hands: np.ndarray
) -> TargetWay:
    """Return the way of the target to which the hand comes nearest.

    Parameters
    ----------
    situation : Situation
        With an arm that moves in its joints.
    times : (k,) ndarray
        Instants of the film [s].
    places : (m, k, 3) ndarray
        Centres of the targets, in the world.
    hands : (k, 3) ndarray
        Hand at these instants.
    """
    apart = np.linalg.norm(places - hands, axis=2)
    which, last = np.unravel_index(apart.argmin(), apart.shape)
    target = situation.targets[which]
    half = drawn_scale(situation, target) * target.shape.bounding_radius
    middles = places[which, : last + 1]
    corners = (middles[:, None] + half * CUBE).reshape(-1, 2, 4, 3)
    away = np.linalg.norm(middles - np.asarray(situation.arm.base.origin), axis=1)
    far = np.flatnonzero(away > FARTHEST * situation.arm.reach)
    near = min(int(far[-1]) + 1, len(middles) - 1) if far.size else 0
    return TargetWay(times[: last + 1], corners, near)


SIGHT = 28  # pixels a side of pictures that are tried for what they hide
EYE = 7.0  # [reaches] distance of the eye
ELEVATION = 24.0  # [degrees] of the eye
TRIED = 12  # instants of a movement that are sampled


def view_of(
    situation: staging.JointSituation,
    trajectory: Movement | None = None,
    *,
    elevation: float = ELEVATION,
    turn: float = 0.0,
) -> Camera:
    """Return a camera that sees arm and hand's path from the side, and little in front of them.

    Parameters
    ----------
    situation : Situation
        With an arm that moves in its joints.
    trajectory : Movement, optional

    Other Parameters
    ----------------
    elevation : float
        Of the eye [degrees].
    turn : float
        The camera is turned about the vertical by so much [degrees].
    """
    arm = situation.arm
    end = situation.horizon if trajectory is None else trajectory.duration
    times = np.linspace(0.0, end, TRIED)
    rest = np.tile(arm.joints, (TRIED, 1))
    joints = rest if trajectory is None else trajectory.joints_at(times)
    limb, targets = limb_along(arm, joints), target_paths(situation, times[-3:])
    tips = limb.ends[:, :, 1].reshape(-1, 3)
    seen = np.concatenate([limb.base[None], tips, limb.hand, targets.reshape(-1, 3)])
    centre = 0.5 * (limb.base + limb.hand.mean(axis=0))
    wanted = [*arm_faces(arm, joints[-1]), *body_faces(situation, end, roles=("target",))]
    wanted += [] if trajectory is None else path_faces(situation, trajectory)
    bodies = body_faces(situation, end, roles=("obstacle",))
    others = [thing for thing in bodies if thing.alpha == 1.0]  # margins hide little

    def merit(azimuth: float) -> float:
        view = camera_from(azimuth, elevation, centre, EYE * arm.reach)
        flat = view.turned(seen - centre)[:, :2]
        spread = np.sqrt(np.linalg.det(np.cov(flat.T)) + 1e-12) / arm.reach**2
        return float(spread * _share_in_sight(view, arm.reach, wanted, others) ** 2)

    best = max(np.arange(0.0, 360.0, 20.0), key=merit)
    return camera_from(best + turn, elevation, centre, EYE * arm.reach)


def _share_in_sight(
    view: Camera, reach: float, wanted: Sequence[Faces], others: Sequence[Faces]
) -> float:
    """Return the share of the wanted things' pixels that the other things do not hide."""
    red, blue = np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0])
    marked = [thing._replace(colours=red, lit=False) for thing in wanted]
    hiding = [thing._replace(colours=blue, lit=False) for thing in others]
    window = Window(np.zeros(2), reach)
    images = [render(view, window, things, SIGHT) for things in (marked, marked + hiding)]
    whole, rest = ((image[..., 0] > 1.2 * image[..., 2]).sum() for image in images)
    return float(rest / max(whole, 1))


ROOM = 1.3  # half a picture [reaches]: what is nearer to the eye looks larger


class Spectator:
    """A camera that stays at a place from which little is in front of the arm.

    Parameters
    ----------
    situation : Situation
        With an arm that moves in its joints.
    """

    def __init__(self, situation: staging.JointSituation) -> None:
        arm = situation.arm
        self.situation = situation
        self.view = replace(view_of(situation), centre=np.asarray(arm.base.origin))
        self.window = Window(np.zeros(2), ROOM * arm.reach)
        things = [*body_faces(situation, 0.0), *arm_faces(arm, arm.joints)]
        self.floor = staging.floor_of(situation, things)

    def picture(self, way: Movement, pixels: int) -> np.ndarray:
        """Return a picture (pixels, pixels, 3) uint8 of a movement's end, with the paths."""
        situation, end = self.situation, way.duration
        things = [*body_faces(situation, end), *arm_faces(situation.arm, way.joints[-1])]
        if end > 0.0:
            things += path_faces(situation, way)
        image = staging.staged(self.view, self.window, self.floor, things, pixels)
        return np.rint(255.0 * image[::-1]).astype(np.uint8)
