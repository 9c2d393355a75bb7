"""Film of an arm with mass, and a figure that compares its movement with the plan."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import cycle
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from PIL import Image

from gcm_learn import rendering
from gcm_learn.arms import links_along, rotation_of
from gcm_learn.families import CAPTION_INSTANTS, KAPPA
from gcm_learn.motion import Movement, joint_names
from gcm_learn.plots.figures import film, style
from gcm_learn.plots.figures.scenery import Scenery, key_below
from gcm_learn.scene import gap, pack_bodies

if TYPE_CHECKING:
    from gcm_learn.execution import Execution, PhysicalPlant

WIDTH, HEIGHT = 6.6, 3.95  # [inches] of a film
WIDER = 1.25  # times what shows the arm and its target: it is seen to go
STOP = 8  # frames for which a film stands still at the catch or the contact
RING = 26  # size of the ring of a mark [points]
MET, HIT = style.GOOD, style.EFFECTIVE  # marks of a catch and of a contact
JOINT_COLOURS = (style.ARM, "#dd6b20", style.OBSTACLE, "#2c7a7b")
MILLI = 1e3  # [1/1000]
FINE = 1e-4  # [m] what is less is not told more exactly


def animate_execution(
    situation: rendering.JointSituation,
    done: Execution,
    path: str | Path,
    *,
    frames: int = film.FRAMES,
    views: int = film.ROUND,
) -> None:
    """Write an animated GIF of an execution by an arm with mass, with braking and bouncing targets.

    The film stands still for a moment at the catch or at the contact, and looks around at its end.

    Parameters
    ----------
    situation : Situation
    done : Execution
        Of this situation, and of a plan.
    path : str or Path
        File to write.

    Other Parameters
    ----------------
    frames : int
        Number of instants.
    views : int
        Number of frames of the look around.
    """
    film.write_film(list(_frames(Replay(situation, done), frames, views)), path)


class Mark(NamedTuple):
    """A ring with a colour and a word, shown from a time [s] on."""

    time: float
    place: np.ndarray | int
    """(3,) in the world; the index of a target for a ring that goes with it."""
    colour: str
    word: str


class Replay(Scenery):
    """Scenery of the executed movement of an arm with mass, as a camera sees it.

    Parameters
    ----------
    situation : Situation
    done : Execution
        Of this situation, and of a plan.
    view : Camera, optional
        By default one that sees arm and hand's way from the side.
    turns : bool
        Whether it will be turned.
    """

    def __init__(
        self,
        situation: rendering.JointSituation,
        done: Execution,
        view: rendering.Camera | None = None,
        *,
        turns: bool = True,
    ) -> None:
        assert done.plant is not None
        self.done, self.plant, until = done, done.plant, done.movement
        self.step = self.plant.time / max(self.plant.steps, 1)
        rows = np.arange(self.plant.steps + 1)
        self.moves = Movement(until.arm, rows * self.step, self.plant.joints_log[rows])
        self.marks = _phases(done, [target.name for target in situation.targets])
        """Phases of a hold and a carry, and what the episode ended with, in order."""
        if done.catch_time is not None and done.grip is None:
            told = f"caught at {done.catch_time:.3f} s"
            self.marks.append(Mark(done.catch_time, until.hand[-1], MET, told))
        elif done.contact is not None:
            t, name = done.contact.time, done.contact.name
            known = name in [body.name for body in situation.bodies]  # or it touches itself
            place = until.hand[-1]
            if known:
                place = touched_at(situation, name, t, self.moves.joints_at(t))
            self.marks.append(Mark(t, place, HIT, f"touches {name!r} at {t:.3f} s"))
        super().__init__(
            situation, self.moves, view or rendering.view_of(situation, until), turns=turns
        )
        self.window = rendering.Window(self.window.middle, WIDER * self.window.half)

    def at(self, t: float) -> list[rendering.Faces]:
        """Everything at time t [s], with the ways of hand and target until then."""
        arm = self.situation.arm
        things = list(rendering.body_faces(self.situation, t, roles=("obstacle",)))
        things += [*self._targets(t), *rendering.arm_faces(arm, self.moves.joints_at(t))]
        if t > 0.0:
            times = np.linspace(0.0, t, rendering.SAMPLES)
            things += rendering.tube_faces(
                self.moves.hand_at(times), times / self.end, rendering.LINE * arm.reach
            )
            for way in self.places(times):
                things += rendering.tube_faces(
                    way, times / self.end, 0.8 * rendering.LINE * arm.reach, dashed=True
                )
        return things

    def show(self, ax: Axes, t: float, turn: float = 0.0, pixels: int = 720) -> None:
        """Draw time t [s], from a camera turned by `turn` [degrees], with the mark of the phase."""
        super().show(ax, t, turn, pixels)
        view, mark = rendering.turned_view(self.view, turn), self.mark_at(t)
        if mark is not None:
            place = mark.place
            place = self.places(np.array([t]))[place, 0] if isinstance(place, int) else place
            x, y, _ = view.see(place)
            ax.plot(
                x, y, "o", ms=RING, mfc="none", mec=mark.colour, mew=2.2, zorder=18,
                path_effects=[style.HALO],
            )  # fmt: skip

    def mark_at(self, t: float) -> Mark | None:
        """Return the mark of the phase at time t [s], or None before the first mark."""
        begun = [mark for mark in self.marks if t >= mark.time - 1e-9]
        return begun[-1] if begun else None

    def places(self, times: np.ndarray) -> np.ndarray:
        """Return the centres (m, k, 3) of the targets in the simulation, in the world."""
        return np.swapaxes(logged_targets(self.situation, self.plant, self.step, times)[0], 0, 1)

    def _targets(self, t: float) -> Iterator[rendering.Faces]:
        targets = [body for body in self.situation.bodies if body.role == "target"]
        place, turn = logged_targets(self.situation, self.plant, self.step, np.array([t]))
        caught = () if self.plant.grips else self.done.catches[:-1]
        taken = {catch.body for catch in caught if catch.time < t}
        for k, body in enumerate(targets):
            if body.name in taken:
                continue
            colour = np.array(to_rgb(style.TARGET))
            yield rendering.placed(body.shape, place[0, k], turn[0, k], colour)  # type: ignore[arg-type]


def logged_targets(
    situation: rendering.JointSituation, plant: PhysicalPlant, step: float, times: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Places (k, m, 3) and turns of the targets at the steps nearest to times (k,)."""
    rows = np.clip(np.rint(times / step).astype(int), 0, plant.steps)
    log = plant.targets_log[rows].reshape(len(rows), -1, 7)
    base = situation.arm.base
    turn = rotation_of(base.rotation)
    turns = np.array([[turn @ rotation_of(q) for q in row] for row in log[..., 3:]])
    return log[..., :3] / plant.body.metres @ turn.T + base.origin, turns


def touched_at(
    situation: rendering.JointSituation, name: str, t: float, joints: np.ndarray
) -> np.ndarray:
    """The point (3,) of the bones that is nearest to a body at time t [s]."""
    k = [body.name for body in situation.bodies].index(name)
    centres, turns = rendering.body_poses(situation, [t])
    share = np.linspace(0.0, 1.0, 60)[:, None]
    ends, _ = links_along(situation.arm, joints)
    bones = np.concatenate([a + share * (b - a) for a, b in ends[0]])
    bodies, inward = pack_bodies(situation), (bones - centres[0, k]) @ turns[0, k]
    away = np.array([gap(bodies, k, *point) for point in inward.tolist()])
    nearest: np.ndarray = bones[np.maximum(away, 0.0).argmin()]
    return nearest


def _frames(replay: Replay, frames: int, views: int) -> Iterator[Image.Image]:
    figure = style.new_figure(WIDTH, HEIGHT)
    figure.set_dpi(film.FILM_DPI)
    panels = figure.subplots(1, 2)
    above = Replay(replay.situation, replay.done, rendering.from_above(replay.view), turns=False)
    for ax, seen, name in zip(
        panels, (replay, above), ("from the side", "from above"), strict=True
    ):
        style.view_frame(ax, seen.window.extent, name)
    figure.supxlabel(told(replay.done), fontsize=style.SMALL, color=style.INK)
    size = round(WIDTH / 2 * film.FILM_DPI)

    def show(ax: Axes, t: float, turn: float) -> None:
        replay.show(ax, t, turn, size)
        style.note_in_corner(ax, f"t = {t:.2f} s")
        mark = replay.mark_at(t)
        if mark is not None:
            ax.text(
                0.99, 0.99, mark.word, transform=ax.transAxes, ha="right", va="top", zorder=20,
                fontsize=style.LABEL, color=mark.colour, path_effects=[style.HALO],
            )  # fmt: skip

    times = np.linspace(0.0, replay.end, frames)
    moments = [(t, 0.0) for t in times]
    for mark in reversed(replay.marks):
        k = int(np.searchsorted(times, mark.time))
        moments[k:k] = [(mark.time, 0.0)] * STOP
    moments += [(replay.end, turn) for turn in np.linspace(0.0, 360.0, views + 1)[1:]]
    yield from film.painted(
        figure, panels, (show, lambda ax, t, _: above.show(ax, t, 0.0, size)), moments
    )


def _phases(done: Execution, names: Sequence[str]) -> list[Mark]:
    """Return the marks of a hold and a carry, which move with the gripped target."""
    if done.grip is None or done.plant is None:
        return []
    (closed, opened, *_), k = done.grip, names.index(list(done.plant.closed)[-1])  # type: ignore[attr-defined]
    since = min(done.planned or closed, closed)
    marks = [Mark(since, k, style.PATH, f"moves with {names[k]!r}")]
    marks.append(Mark(closed, k, MET, f"gripped at {closed:.3f} s" + ", carries it" * bool(opened)))
    if opened is not None:
        marks.append(Mark(opened, k, MET, f"put down at {opened:.3f} s"))
    return marks


def told(done: Execution) -> str:
    """The outcome, in two lines."""
    planned = "" if done.planned is None else f" (planned {done.planned:.3f} s)"
    several = f"{len(done.catches)} of {len(done.several)} targets " if done.several else ""
    if done.caught and done.grip is not None:
        first = f"{done.name}: {several}gripped at {done.grip.closed:.3f} s"
        if done.grip.off_place is not None:
            first += f", put down {_millimetres(done.grip.off_place)} from its place"
    elif done.caught:
        first = f"{done.name}: {several}caught at {done.catch_time:.3f} s{planned}"
    elif done.contact is not None:
        first = f"{done.name}: touches {done.contact.name!r} at {done.contact.time:.3f} s{planned}"
    else:
        first = f"{done.name}: {several or 'not '}caught{planned}"
    if done.error is None or done.torque is None:
        return first
    _, most, end = (_millimetres(error) for error in done.error)
    when = "at the catch" if done.caught else "at the end"
    return (
        f"{first}\nhand off its plan by at most {most}, {when} {end}; "
        f"motors use up to {100 * done.torque:.0f} % of their torque"
    )


def _millimetres(length: float) -> str:
    return f"{MILLI * length:.1f} mm" if length >= FINE else "under 0.1 mm"


def execution_figure(situation: rendering.JointSituation, done: Execution) -> Figure:
    """Draw an execution: the arm at instants, the hand's actual and planned path, error and torque.

    Parameters
    ----------
    situation : Situation
    done : Execution
        Of this situation, and of a plan.

    Returns
    -------
    Figure
        Instants are those of the paper's Fig. 8 but the last, and the end of the movement.
    """
    replay = Replay(situation, done, turns=False)
    end = done.movement.duration
    figure = style.new_figure(10.2, 8.0)
    figure.suptitle(told(done), fontsize=style.TITLE, color=style.INK)
    grid = figure.add_gridspec(2, 6, height_ratios=(1.0, 0.92))
    instants = [tau * KAPPA for tau in CAPTION_INSTANTS["fig8"][:2]]
    for k, t in enumerate([*instants, end]):
        ax = figure.add_subplot(grid[0, 2 * k : 2 * k + 2])
        replay.show(ax, t)
        style.title(ax, f"t = {t:.2f} s" + (f": {done.status}" if t == end else ""))
    _draw_ways(figure.add_subplot(grid[1, :2]), replay, end)
    _draw_error(figure.add_subplot(grid[1, 2:4]), replay, end)
    _draw_torques(figure.add_subplot(grid[1, 4:]), replay, end)
    key_below(figure, situation)
    return figure


def _draw_ways(ax: Axes, replay: Replay, end: float) -> None:
    """Draw the hand's path over the planned path, and the target's path, also after the end."""
    times, after = (
        np.linspace(0.0, end, rendering.SAMPLES),
        np.linspace(end, replay.end, rendering.SAMPLES),
    )
    plan = replay.done.plan
    assert plan is not None
    for points, colour, width, dash, label in (
        (plan.hand_at(times), style.FAINT, 6.0, "-", "hand, planned"),
        (replay.moves.hand_at(times), style.ARM, 1.8, "-", "hand"),
        (replay.moves.hand_at(after), style.ARM, 1.8, ":", "hand, braking"),
        (replay.places(times)[0], style.TARGET, 1.8, "-", "ball"),
        (replay.places(after)[0], style.TARGET, 1.8, ":", "ball, afterwards"),
    ):
        seen = replay.view.see(points)[:, :2]
        ax.plot(*seen.T, color=colour, lw=width, ls=dash, label=label, solid_capstyle="round")
    hands = np.concatenate([plan.hand_at(times), replay.moves.hand_at(after)])
    seen = replay.view.see(hands)[:, :2]
    middle, half = 0.5 * (seen.min(axis=0) + seen.max(axis=0)), 0.8 * np.ptp(seen, axis=0).max()
    (left, bottom), (right, top) = middle - half, middle + half
    ax.set(xlim=(left, right), ylim=(bottom, top), aspect="equal")
    ax.set_xticks([])
    ax.set_yticks([])
    ax.spines[:].set_visible(False)
    ax.legend(fontsize=style.SMALL, frameon=False, labelcolor=style.INK, loc="best")
    style.title(ax, "ways, in the same view")


def _draw_error(ax: Axes, replay: Replay, end: float) -> None:
    """Draw the distance of the hand from its planned place over time."""
    plan, plant = replay.done.plan, replay.plant
    assert plan is not None
    times = np.arange(plant.steps + 1) * replay.step
    off = np.linalg.norm(replay.moves.hand - plan.hand_at(times), axis=1) * plant.body.metres
    ax.plot(times, MILLI * off, color=style.PATH, lw=1.6)
    ax.set_ylim(bottom=0.0)
    _finish(ax, replay, end, "hand off its plan [mm]")


def _draw_torques(ax: Axes, replay: Replay, end: float) -> None:
    """Draw the torque of each motor over time, as a share of the motor's largest torque."""
    plant = replay.plant
    times = np.arange(plant.steps) * replay.step
    arm, colours = replay.situation.arm, cycle(JOINT_COLOURS)
    for j, (name, colour) in enumerate(zip(joint_names(arm), colours, strict=False)):
        used = 100.0 * np.abs(plant.torques_log[: plant.steps, j]) / plant.strongest[j]
        ax.plot(times, used, color=colour, lw=1.4, label=name, ls="-" if j < 4 else "--")
    ax.axhline(100.0, color=style.FAINT, lw=1.0, ls=(0, (4, 3)))
    ax.set_ylim(0.0, 135.0)
    ax.legend(
        fontsize=style.SMALL, frameon=False, labelcolor=style.INK, ncols=2, loc="upper center"
    )
    _finish(ax, replay, end, "torque, of each motor's most [%]")


def _finish(ax: Axes, replay: Replay, end: float, title: str) -> None:
    style.plain(ax)
    style.title(ax, title)
    ax.set_xlim(0.0, replay.end)
    ax.set_xlabel("t [s]", fontsize=style.LABEL, color=style.INK)
    colour = replay.marks[-1].colour if replay.marks else style.INK
    ax.axvline(end, color=colour, lw=1.2, ls=(0, (4, 3)))
