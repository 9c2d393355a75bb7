"""Stage of families for chains: an arm, its floor, and postures to aim at."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from gcm_learn.arms import Chain, Link, hands_along, links_along
from gcm_learn.collision.postures import desk_of, gap_at
from gcm_learn.compiled import njit
from gcm_learn.families.ranges import Range, pick
from gcm_learn.families.solids import solid, triple
from gcm_learn.scene import pack
from gcm_learn.situation import Body, Box, Situation, Sphere


@njit
def clearances(scene, joints, times):
    """Return clearances (k,) of the limb at postures (k, n) and times (k,) [s].

    They are signed distances to obstacles, or of the limb to itself where that is less.
    """
    desk, found = desk_of(scene), np.empty(times.size)
    for k in range(times.size):
        found[k] = gap_at(scene, joints[k], times[k], desk)
    return found


POSTURES = 200  # that a draw chooses its start and its end from
ENOUGH = 0.5  # share of postures above a floor; with fewer there is none
ALONG = np.linspace(0.0, 1.0, 5)  # places on a link at which bodies are aimed
ROOM = 2e-3  # clearance of the end of a way, at least [reaches]
START_ROOM = 0.02  # the same of its start, from which the arm may have to flee
STILL = 0.06  # points of links that stray less from their mean stay where they are [reaches]
INSTANTS = 24  # of the horizon, at which bodies must leave them free
SLIM = 0.04  # radius of hands, for which openings are as wide as families say [reaches]
SPARE = 1.05  # durations of a straight way, after which its end may be met
LATEST = 0.97  # latest meeting [horizons]
WIDE, THICK = 1.05, 0.035  # half the sizes of a floor [reaches]


class Way(NamedTuple):
    """From a start to a posture that catches, in a straight line of the joints."""

    start: np.ndarray
    """Joints (n,)."""
    end: np.ndarray
    when: float
    """Time at which the hand meets a target at its end [s]."""
    meet: np.ndarray
    """Hand (3,) at its end."""
    axis: np.ndarray
    """Unit vector (3,) along which the hand reaches there."""

    def at(self, share: float) -> np.ndarray:
        """Joints (n,) at a share of the way."""
        return self.start + share * (self.end - self.start)


class Stage(NamedTuple):
    """An arm with its horizon and floor; lengths are in the arm's unit."""

    arm: Chain
    """Arm at the middles of its ranges, its base at the origin."""
    horizon: float
    """[s]"""
    gravity: float
    """[lengths/s^2]"""
    floor: tuple[Body, ...]
    """None or one."""
    joints: np.ndarray
    """Postures (k, n) free of floor and self-collision."""
    shell: Chain
    """The same arm without pairs of links that must not overlap."""
    core: Chain | None
    """The shell with balls for links, at points that hardly move between postures, or None."""

    def size(self, rng: np.random.Generator, ends: Range) -> float:
        """Draw a length from a range in reaches."""
        return pick(rng, ends) * self.arm.reach

    def slot(self, rng: np.random.Generator, ends: Range) -> float:
        """Draw half an opening's width from a range in reaches; wider for stout hands."""
        model = self.arm.model
        at_hand = [link.radius for link in model.links if link.joint == model.hand.joint]
        radius = max(at_hand, default=model.links[-1].radius)
        return self.size(rng, ends) + max(radius - SLIM * self.arm.reach, 0.0)

    def hands(self) -> tuple[np.ndarray, np.ndarray]:
        """Hands (k, 3) of the postures, and their axes (k, 3)."""
        return hands_along(self.arm, self.joints)

    def points(self, joints: np.ndarray) -> np.ndarray:
        """Points (k, 5 m, 3) on the axes of the m links at postures (k, n)."""
        ends, _ = links_along(self.arm, joints)
        first, last = ends[:, :, :1], ends[:, :, 1:]
        return (first + ALONG[:, None] * (last - first)).reshape(len(joints), -1, 3)

    def rooms(
        self,
        bodies: Sequence[Body],
        joints: np.ndarray,
        times: Sequence[float] | np.ndarray,
        arm: Chain | None = None,
    ) -> np.ndarray:
        """Return exact clearances from bodies.

        Parameters
        ----------
        bodies : sequence of Body
            Targets do not count.
        joints : (k, n) ndarray
        times : (k,) array_like
            Of the postures [s].
        arm : Chain, optional
            Another arm with the same joints.

        Returns
        -------
        (k,) ndarray
            Of the arm from itself, too.
        """
        mark = solid("target", Sphere(1e-3), (0.0, 0.0, 0.0))
        others = tuple(body for body in bodies if body.role == "obstacle")
        arm = self.arm if arm is None else arm
        names = {body.name for body in others}
        arm = replace(arm, ignore=tuple(pair for pair in arm.ignore if pair[1] in names))
        scene = pack(Situation("", self.horizon, arm, (mark, *others)))
        return clearances(scene, np.ascontiguousarray(joints), np.array(times, dtype=float))

    def fits(self, way: Way, bodies: Sequence[Body]) -> bool:
        """Return whether bodies leave the way's start free at t = 0, and its end at the meeting.

        They also have to leave free the places that the arm fills in every posture, such as the
        base.
        """
        room = ROOM * self.arm.reach
        ends = np.stack([way.start, way.end])
        rooms = self.rooms(bodies, ends, (0.0, way.when), self.shell)
        if rooms[0] <= START_ROOM * self.arm.reach or rooms[1] <= room:
            return False
        if self.core is None:
            return True
        times = np.linspace(0.0, self.horizon, INSTANTS)
        still = np.repeat(ends[:1], INSTANTS, axis=0)
        return bool(self.rooms(bodies, still, times, self.core).min() > room)

    def takes(self, first: np.ndarray, last: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return durations of straight ways of joints [s]: at full speed, and from rest.

        The second keeps limits of acceleration, if there are any; rates at the end are free.
        """
        turns, top = np.abs(last - first), np.array(self.arm.max_joint_speed)
        quick = (turns / top).max(axis=-1)
        if self.arm.max_joint_acceleration is None:
            return quick, quick
        limits = np.array(self.arm.max_joint_acceleration)
        ramped = np.where(
            2.0 * limits * turns <= top**2,
            np.sqrt(2.0 * turns / limits),
            turns / top + 0.5 * top / limits,
        )
        return quick, ramped.max(axis=-1)

    def way(
        self, rng: np.random.Generator, takes: Range, when: Range, ends: np.ndarray | None = None
    ) -> Way:
        """Draw a way between two of the postures.

        Parameters
        ----------
        rng : numpy.random.Generator
        takes : (float, float)
            Range of its duration at full speed [horizons]; the nearest there is, if there is none.
        when : (float, float)
            Range of the time of the meeting [horizons]; later if the way takes longer.
        ends : (k,) ndarray of bool, optional
            Postures that may be the end; all of them if none may.
        """
        first = self.joints[int(rng.integers(len(self.joints)))]
        quick, real = (taken / self.horizon for taken in self.takes(first, self.joints))
        off = np.maximum(np.maximum(takes[0] - quick, quick - takes[1]), 0.0)
        off = np.where(SPARE * real > LATEST, np.inf, off)
        if ends is not None and np.isfinite(off[ends]).any():
            off = np.where(ends, off, np.inf)
        last = int(rng.choice(np.flatnonzero(off <= off.min())))
        hand, axis = hands_along(self.arm, self.joints[last][None])
        time = min(max(pick(rng, when), SPARE * float(real[last])), LATEST) * self.horizon
        return Way(first, self.joints[last], time, hand[0], axis[0])


def stage_of(
    rng: np.random.Generator, arm: Chain, horizon: float, gravity: float, floor: float | None
) -> Stage:
    """Draw a stage: postures of an arm, above a floor at height `floor` if that is given."""
    low, high = np.array(arm.joint_range).T
    joints = low + (high - low) * rng.random((POSTURES, len(low)))
    shell = replace(arm, model=replace(arm.model, self_collision=()), ignore=())
    bare = Stage(arm, horizon, gravity, (), joints, shell, _core(shell, joints))
    if floor is not None:
        grounded = _grounded(bare, floor)
        if grounded is not None:
            return grounded
    return bare._replace(joints=_free(bare))


def _free(stage: Stage) -> np.ndarray:
    """Return the postures that are free of the floor and of self-collision; all if none is."""
    rooms = stage.rooms(stage.floor, stage.joints, np.zeros(len(stage.joints)))
    free = rooms > ROOM * stage.arm.reach
    return stage.joints[free] if free.any() else stage.joints


def _core(arm: Chain, joints: np.ndarray) -> Chain | None:
    """Return the arm with balls at link points that hardly move between postures; None if none."""
    ends, radii = links_along(arm, joints)
    points = ends[:, :, :1] + ALONG[:, None] * (ends[:, :, 1:] - ends[:, :, :1])
    middle = points.mean(axis=0)
    strays = np.linalg.norm(points - middle, axis=-1).max(axis=0)
    links = tuple(
        Link(0, triple(middle[i, k]), triple(middle[i, k]), float(radii[i]))
        for i, k in np.argwhere(strays < STILL * arm.reach)
    )
    if not links:
        return None
    return replace(arm, model=replace(arm.model, links=links))


def _grounded(stage: Stage, height: float) -> Stage | None:
    """Return the stage with a floor at `height`; None if the arm is mostly below that floor.

    Links that touch the floor in every posture, such as a base, are not checked against it.
    """
    reach = stage.arm.reach
    ends, radii = links_along(stage.arm, stage.joints)
    below = ends[..., 2].min(axis=2) - radii < height + ROOM * reach
    stuck = np.flatnonzero(below.all(axis=0))
    free = ~np.delete(below, stuck, axis=1).any(axis=1)
    if len(stuck) == len(radii) or free.mean() < ENOUGH:
        return None
    half = reach * THICK
    shape = Box((reach * WIDE, reach * WIDE, half))
    floor = solid("floor", shape, (0.0, 0.0, height - half))
    arm = replace(stage.arm, ignore=tuple((int(i), "floor") for i in stuck))
    grounded = stage._replace(arm=arm, floor=(floor,))
    return grounded._replace(joints=_free(grounded))
