"""The paper's Figs. 7 and 8, varied: a ball on a cord swings through the arm's plane."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from gcm_learn.arms import Arm
from gcm_learn.families import ranges
from gcm_learn.families.layout import Event
from gcm_learn.families.piece_family import EventFamily, InSpace
from gcm_learn.families.pieces import PlanarPiece, Vector, in_world
from gcm_learn.scene import integrate_swing
from gcm_learn.situation import Body, Capsule, Pendulum, Situation, Sphere

_STEPS = 100  # of the integration back to t = 0; the error of a swing is far below 1e-6 rad


class Swing(NamedTuple):
    """Swing to draw: the ball is at `place` at the time `when`, under `gravity`."""

    place: Vector
    when: float
    gravity: float
    """[forearms/s^2]"""


@dataclass(frozen=True)
class PendulumFamily(InSpace, EventFamily):
    """A target ball on a cord, which is an obstacle; other pendulums swing across the way.

    The arm's plane is vertical, the swing's plane stands at an angle to it. There are no planar
    pendulums; bars on hinges in the family "spinning" are their cousins.
    """

    name = "pendulum"
    summary = "a ball on a cord that swings through the arm's plane, with others in the way"

    obstacles: ranges.Counts = ranges.counts(1, 4, 1)
    """Number of obstacles, the target's cord included."""
    length: ranges.Range = ranges.span(0.8, 2.5, 0.1)
    """From pivot to ball [forearms]."""
    gravity: ranges.Range = ranges.span(0.3, 1.0, 0.01)
    """Acceleration of all bodies of a scene [squared hand speeds per forearm]."""
    amplitude: ranges.Range = ranges.span(0.3, 1.0, 0.01, 1.5)
    """Largest angle of the swing [rad]."""
    phase: ranges.Range = ranges.span(-0.8, 0.8, -0.99, 0.99)
    """Angle at which it meets the plane [amplitudes]."""
    heading: ranges.Range = ranges.span(0.2, 1.57, 0.0, 1.58)
    """Angle between the swing's plane and the arm's [rad]."""
    wait: ranges.Range = ranges.span(1.0, 1.8, 1.0)
    """Time of the meeting, in times that the hand needs for the way there."""
    cord: ranges.Range = ranges.span(0.005, 0.02, 1e-3)
    """Radius of cords [forearms]."""
    swinging: float = ranges.number(0.6)
    """Share of pendulums among the other obstacles, as far as there is space for two bodies each;
    the rest of them are bodies at rest."""

    def sketch(self, rng: np.random.Generator, name: str) -> Situation:
        """Draw once, the limb free or not."""
        arm, horizon = self.arm.draw(rng)
        event, gravity = self.event(rng, arm, horizon), ranges.pick(rng, self.gravity)
        gravity *= arm.max_hand_speed**2
        place, when, size = event.meet, event.when, event.target.size[0]
        bodies = [*self._pair(rng, Swing(place, when, gravity), size, "target", "")]
        left = ranges.pick_count(rng, self.obstacles) - 1
        while left > 0:
            if left >= 2 and rng.random() < self.swinging:
                swing = Swing(*self.aim(rng, arm, event), gravity)
                size, left = ranges.pick(rng, self.sizes.radius), left - 2
                bodies += self._pair(rng, swing, size, "obstacle", f" {left}")
            else:
                (post,) = self.fitting(rng, arm, event, 1)
                left -= 1
                bodies.append(self.body(rng, post._replace(name=f"post {left}"), arm))
        return Situation(name, horizon, arm, tuple(bodies), self.plane)

    def event(self, rng: np.random.Generator, arm: Arm, horizon: float) -> Event:
        """Draw a target ball, and the place and time at which it passes."""
        return self.moving_ball(rng, arm, horizon, (0.0, 0.0), self.wait)

    def obstacle(self, rng: np.random.Generator, arm: Arm, event: Event, k: int) -> PlanarPiece:
        """A body at rest."""
        place, _ = self.aim(rng, arm, event)
        return PlanarPiece(
            "obstacle", "post", self.sizes.any(rng), place, angle=ranges.pick_angle(rng)
        )

    def _pair(
        self, rng: np.random.Generator, swing: Swing, radius: float, role: str, number: str
    ) -> tuple[Body, Body]:
        """Draw a ball on a cord, and the cord as an obstacle."""
        motion = self._motion(rng, swing)
        length = motion.length
        cord = Capsule(ranges.pick(rng, self.cord), 0.5 * length)
        hung = Pendulum(
            motion.pivot, motion.axis, motion.down, length, motion.gravity, motion.angle,
            motion.rate, 0.0, 0.5 * length,
        )  # fmt: skip
        return (
            Body(role, f"ball{number}", Sphere(radius), motion),
            Body("obstacle", f"cord{number}", cord, hung),
        )

    def _motion(self, rng: np.random.Generator, swing: Swing) -> Pendulum:
        """Draw a pendulum that meets the plane as asked, traced back to t = 0 by its energy."""
        length, amplitude = ranges.pick(rng, self.length), ranges.pick(rng, self.amplitude)
        heading = ranges.pick_sign(rng) * ranges.pick(rng, self.heading)
        angle, stiffness = ranges.pick(rng, self.phase) * amplitude, swing.gravity / length
        rate = ranges.pick_sign(rng) * math.sqrt(
            2.0 * stiffness * (math.cos(angle) - math.cos(amplitude))
        )
        along = in_world(math.cos(heading), 0.0, math.sin(heading))
        place = in_world(*swing.place, 0.0)
        return swing_through(place, along, swing.when, swing.gravity, length, (angle, rate))


def swing_through(
    place: tuple[float, float, float],
    along: tuple[float, float, float],
    when: float,
    gravity: float,
    length: float,
    state: Vector,
) -> Pendulum:
    """The swing, from t = 0 on, of a body that is at a place at a time.

    Parameters
    ----------
    place : (3,) tuple of float
        [forearms]
    along : (3,) tuple of float
        Level unit vector: where the swing goes at positive rates.
    when : float
        [s]
    gravity : float
        [forearms/s^2]
    length : float
        From pivot to body [forearms].
    state : (2,) tuple of float
        Angle and rate then [rad, rad/s].
    """
    (x, y, z), (angle, rate) = place, state
    # Without damping, time runs back when the rate is turned round.
    step, stiffness = when / _STEPS, gravity / length
    back = integrate_swing(angle, -rate, stiffness, 0.0, step, _STEPS + 1)[-1]
    s, c = length * math.sin(angle), length * math.cos(angle)
    return Pendulum(
        pivot=(x - s * along[0], y - s * along[1], z + c),
        axis=(along[1], -along[0], 0.0),
        down=(0.0, 0.0, -1.0),
        length=length,
        gravity=gravity,
        angle=float(back[0]),
        rate=-float(back[1]),
    )


def ball_on_cord(
    motion: Pendulum, radius: float, thin: float, name: str, number: str = ""
) -> tuple[Body, Body]:
    """Return a ball and the cord above it; a ball with the name "target" is the target."""
    free = motion.length - radius
    role = "target" if name == "target" else "obstacle"
    return (
        Body(role, f"{name}{number}", Sphere(radius), motion),
        Body(
            "obstacle", f"cord{number}", Capsule(thin, 0.5 * free), replace(motion, hang=0.5 * free)
        ),
    )
