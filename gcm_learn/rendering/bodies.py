"""Arms, bodies and paths as faces, and a camera that sees them well."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import ArrayLike

from gcm_learn.arms import SpatialArm, forward_in_space
from gcm_learn.motion import SpatialTrajectory
from gcm_learn.rendering.camera import Camera, Faces, Window, camera_from, render
from gcm_learn.rendering.colours import ARM, INK, JOINT, body_colour, rgb, time_colours
from gcm_learn.rendering.solids import placed, tube
from gcm_learn.rendering.staging import SpatialSituation
from gcm_learn.scene import pack_bodies, poses_at
from gcm_learn.situation import Capsule, Sphere, arm_frame

THINNEST = 0.022  # of the reach: thinner bones are drawn so thick
BALL, HAND = 1.12, 1.3  # radii of joints and hand, in those of the bones
LINE = 0.007  # of the reach: radius of a path
SAMPLES = 60  # points of a path
SIGHT = 28  # pixels a side of pictures that are tried for what they hide
EYE = 7.0  # [reaches] distance of the eye
ELEVATION = 24.0  # [degrees] of the eye


def body_poses(situation: SpatialSituation, times: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
    """Places and turns of the bodies at some times, in the world.

    Parameters
    ----------
    situation : Situation
        With a spatial arm.
    times : (k,) array_like
        [s]

    Returns
    -------
    centres : (k, m, 3) ndarray
    rotations : (k, m, 3, 3) ndarray
        Columns are the bodies' axes.
    """
    bodies, (axes, origin) = pack_bodies(situation), arm_frame(situation)
    instants = np.atleast_1d(np.asarray(times, dtype=float))
    out = np.zeros((len(instants), len(situation.bodies), 12))
    out[..., 3:] = np.eye(3).ravel()  # spheres leave it so
    for t, poses in zip(instants, out, strict=True):
        poses_at(bodies, t, poses)
    turns = axes.T @ out[..., 3:].reshape(*out.shape[:2], 3, 3)
    return out[..., :3] @ axes + origin, turns


def bone_radius(arm: SpatialArm) -> float:
    """Radius with which the bones are drawn."""
    return max(arm.thickness, THINNEST * arm.reach)


def arm_faces(arm: SpatialArm, joints: ArrayLike, alpha: float = 1.0) -> list[Faces]:
    """The arm as two capsules, with balls for shoulder, elbow and hand.

    Parameters
    ----------
    arm : SpatialArm
    joints : (4,) array_like
        [rad]
    alpha : float
    """
    elbow, hand = forward_in_space(arm, joints)
    return limb_faces(np.array([arm.base.origin, elbow, hand]), bone_radius(arm), alpha)


def limb_faces(points: np.ndarray, radius: float, alpha: float = 1.0) -> list[Faces]:
    """Return a limb through shoulder, elbow and hand (3, 3), with bones of a radius."""
    shoulder, elbow, hand = points
    out = []
    for a, b in ((shoulder, elbow), (elbow, hand)):
        length = float(np.linalg.norm(b - a))
        turn = frame_along((b - a) / length)
        bone = Capsule(radius, length / 2)
        out.append(placed(bone, (a + b) / 2, turn, rgb(ARM), alpha))
    for centre, size, colour in (
        (shoulder, BALL, INK), (elbow, BALL, JOINT), (hand, HAND, ARM),
    ):  # fmt: skip
        ball = Sphere(size * radius)
        out.append(placed(ball, centre, np.eye(3), rgb(colour), alpha))
    return out


def frame_along(z: np.ndarray) -> np.ndarray:
    """A rotation (3, 3) whose third column is a unit vector."""
    x = np.cross(np.eye(3)[np.abs(z).argmin()], z)
    x /= np.linalg.norm(x)
    return np.column_stack([x, np.cross(z, x), z])


def body_faces(
    situation: SpatialSituation, t: float, alpha: float = 1.0, roles: Sequence[str] = ()
) -> Iterator[Faces]:
    """Yield the bodies at time t [s], or those in some roles."""
    centres, turns = body_poses(situation, [t])
    for body, centre, turn in zip(situation.bodies, centres[0], turns[0], strict=True):
        if not roles or body.role in roles:
            colour = rgb(body_colour(body))
            yield placed(body.shape, centre, turn, colour, alpha)  # type: ignore[arg-type]


def view_of(
    situation: SpatialSituation,
    trajectory: SpatialTrajectory | None = None,
    *,
    elevation: float = ELEVATION,
    turn: float = 0.0,
) -> Camera:
    """Return a camera that sees arm and hand's way from the side, and little in front of them.

    Parameters
    ----------
    situation : Situation
        With a spatial arm.
    trajectory : SpatialTrajectory, optional

    Other Parameters
    ----------------
    elevation : float
        Of the eye [degrees].
    turn : float
        The camera is turned about the vertical by so much [degrees].
    """
    arm = situation.arm
    end = situation.horizon if trajectory is None else trajectory.duration
    times = np.linspace(0.0, end, 12)
    joints = np.tile(arm.joints, (12, 1)) if trajectory is None else trajectory.joints_at(times)
    elbow, hand = forward_in_space(arm, joints)
    centres, _ = body_poses(situation, times[-3:])
    target = [body.role == "target" for body in situation.bodies]
    shoulder = np.asarray(arm.base.origin)
    seen = np.concatenate([shoulder[None], elbow, hand, hand, centres[:, target].reshape(-1, 3)])
    centre = 0.5 * (shoulder + hand.mean(axis=0))
    wanted = [*arm_faces(arm, joints[-1]), *body_faces(situation, end, roles=("target",))]
    wanted += [] if trajectory is None else path_faces(situation, trajectory)
    others = list(body_faces(situation, end, roles=("obstacle",)))

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
    """Share of what is wanted in a picture that others leave in sight."""
    red, blue = np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0])
    marked = [thing._replace(colours=red, lit=False) for thing in wanted]
    hiding = [thing._replace(colours=blue, lit=False) for thing in others]
    window = Window(np.zeros(2), reach)
    images = [render(view, window, things, SIGHT) for things in (marked, marked + hiding)]
    whole, rest = ((image[..., 0] > 1.2 * image[..., 2]).sum() for image in images)
    return float(rest / max(whole, 1))


def path_faces(situation: SpatialSituation, trajectory: SpatialTrajectory,
               until: float | None = None) -> Iterator[Faces]:  # fmt: skip
    """Yield the ways of the hand, and of the targets dashed, coloured by time."""
    end = trajectory.duration
    last = end if until is None else until
    times = np.linspace(0.0, last, SAMPLES)
    radius = LINE * situation.arm.reach
    shades = time_colours(0.5 * (times[1:] + times[:-1]) / max(end, 1e-9))
    hand = trajectory.hand_at(times)
    if np.ptp(hand, axis=0).max() > radius:
        yield Faces(tube(hand, radius), np.repeat(shades, 6, axis=0)[:, None])
    centres, _ = body_poses(situation, times)
    for k, body in enumerate(situation.bodies):
        if body.role == "target" and np.ptp(centres[:, k], axis=0).max() > radius:
            path = tube(centres[:, k], 0.8 * radius).reshape(-1, 6, 4, 3)
            dashes = np.arange(len(path)) % 3 != 2
            yield Faces(
                path[dashes].reshape(-1, 4, 3), np.repeat(shades[dashes], 6, axis=0)[:, None]
            )
