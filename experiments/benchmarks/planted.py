"""Table of situations that hide a known catch among clouds, meshes and margins.

python -m experiments benchmarks/planted >> experiments/benchmarks/world.md

A random movement of the joints comes first, with a target that meets its end. Obstacles are moved
away from it until a small distance is left. The referee confirms that it catches.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from gcm_learn import seeding, solve
from gcm_learn.arms import Chain, ChainModel
from gcm_learn.arms.chain_model import ChainJoint, Hand, Link
from gcm_learn.families.chain.measured import cloud_of, mesh_of
from gcm_learn.families.chain.stage import Stage, stage_of
from gcm_learn.families.solids import axes_along, solid, triple, unit_vector
from gcm_learn.motion import Movement
from gcm_learn.planners import Attempt, JointProblem, checked, get_planner, plan_to_json, plan_with
from gcm_learn.referee import examine
from gcm_learn.situation import (
    Body,
    Box,
    Capsule,
    Margin,
    Mesh,
    Situation,
    Sphere,
    shipped_arm,
    situation_to_json,
)  # fmt: skip

ARMS = ("panda", "ur5", "xarm6", "random chain")
KINDS = ("clouds", "meshes", "margins", "mixed", "crowd")
SEED, COUNT, LIMIT, REST = 2045, 6, 10.0, np.zeros(3)


def random_chain(rng: np.random.Generator) -> ChainModel:
    """Return a chain of four to seven joints, each about another axis than the one before."""
    joints, links, place, axis = [], [], REST, 1
    for k in range(1, int(rng.integers(5, 9))):
        axis = (axis + int(rng.integers(1, 3))) % 3
        turn, top = triple(np.eye(3)[axis]), rng.uniform(1.0, 3.0)
        joints.append(ChainJoint(turn, (-2.5, 2.5), top, origin=triple(place)))
        place = rng.uniform(0.1, 0.35) * np.eye(3)[int(rng.choice((0, 2)))]
        links.append(Link(k, (0.0, 0.0, 0.0), triple(place), rng.uniform(0.03, 0.06)))
    return ChainModel("random", tuple(joints), tuple(links), Hand(len(joints), triple(place)))


def movement_of(rng: np.random.Generator, stage: Stage, arm: Chain) -> Movement:
    """Draw a movement in two pieces, linear or, under limits of acceleration, cubic."""
    start, over, end = rng.choice(stage.joints, 3, replace=False)
    joints = np.stack([start, start + 0.6 * (over - start), start + 0.8 * (end - start)])
    turns, most = np.abs(np.diff(joints, axis=0)), arm.max_joint_acceleration
    takes, rates = (turns / arm.max_joint_speed).max(axis=1), None
    if most is not None:
        ramps, rates = np.sqrt(6.0 * turns / np.array(most)).max(axis=1), np.zeros_like(joints)
        takes = np.maximum(1.5 * takes, ramps)
    return Movement(arm, np.cumsum([0.0, *(takes / rng.uniform(0.3, 0.95, 2))]), joints, rates)


def shaped(rng: np.random.Generator, kind: str, reach: float) -> tuple[Any, Margin | None]:
    """Draw a shape of a kind, and its margin."""
    sizes = rng.uniform(0.02, 0.25, 3) * reach
    solids = Box(tuple(sizes)), Sphere(sizes[0]), Capsule(*sizes[:2])
    shape = solids[int(rng.integers(3))]
    if kind == "margins":
        return shape, Margin(*(rng.uniform(0.0, 0.03, 2) * reach))
    mesh = mesh_of(shape)
    if kind == "clouds":
        count = int(100.0 * 200.0 ** rng.random())
        return cloud_of(rng, mesh, count, rng.uniform(0.004, 0.02) * reach), None
    left = len(mesh.triangles) // (1 + int(rng.integers(2)))  # of half of them some are missing
    return Mesh(mesh.vertices, rng.permutation(mesh.triangles)[:left]), None


def obstacle(rng: np.random.Generator, stage: Stage, way: Movement, kind: str, k: int) -> Body:
    """Draw an obstacle, at rest or not, that comes near to a movement and leaves it free."""
    reach, kind = stage.arm.reach, KINDS[int(rng.integers(3))] if kind in KINDS[3:] else kind
    shape, margin = shaped(rng, kind, reach)
    when, times = rng.uniform(0.0, way.duration), np.linspace(0.0, way.duration, 120)
    place, away = rng.choice(stage.points(way.joints_at(when)[None])[0]), rng.normal(size=3)
    course, spin = rng.uniform(-0.5, 0.5, (2, 3)) * (rng.random() < 0.5)
    joints, axes = way.joints_at(times), axes_along(rng.normal(size=3))
    wanted: Any = rng.uniform(0.005, 0.03) * reach
    if margin:
        wanted += margin.now + margin.rate * times
    while True:
        body = solid(
            f"{kind} {k}", shape, place, axes, when=when, velocity=course * reach, spin=spin
        )
        room = float((stage.rooms([body], joints, times, stage.shell) - wanted).min())
        if room >= -1e-3 * reach:
            return replace(body, margin=margin)
        place = place - room * unit_vector(away)


def planted(arm: str, kind: str, k: int) -> Situation[Any]:
    """Return a situation with a known catch, which the judge and the referee confirm."""
    for tries in range(50):
        rng = seeding.rng(SEED, ARMS.index(arm), KINDS.index(kind), k, tries)
        model = random_chain(rng) if arm == ARMS[-1] else shipped_arm(arm)
        limits = tuple(rng.uniform(8.0, 15.0, model.dof)) if k % 2 else None
        chain = Chain(
            model, tuple(np.mean(model.ranges, axis=1)), 0.0, max_joint_acceleration=limits
        )
        stage = stage_of(rng, chain, 1.0, 0.0, None)
        way, ball = movement_of(rng, stage, chain), Sphere(0.015 * chain.reach)
        chain = replace(chain, joints=tuple(way.joints[0]), grasp=0.028 * chain.reach)
        course = rng.uniform(-0.3, 0.3, 3) * chain.reach
        target = solid("target", ball, way.hand[-1], when=way.duration, velocity=course)
        most = (40, 81) if kind == "crowd" else (6, 21)
        others = [obstacle(rng, stage, way, kind, n) for n in range(int(rng.integers(*most)))]
        made = Situation(
            f"{arm}-{kind}-{k}", way.duration * rng.uniform(1.0, 1.5), chain, (target, *others),
            format="gcm-learn/situation@4", end="rest" if k % 4 == 3 else "free",
        )  # fmt: skip
        plan, _ = checked(JointProblem(made, "known"), Attempt(replace(way, arm=chain), 0))
        if plan and not examine(situation_to_json(made), plan_to_json(plan)).complaints:
            return made
    raise RuntimeError(f"{arm} {kind} {k}: each way that is drawn touches itself")


def asked(arm: str, kind: str, k: int) -> tuple[Any, ...]:
    """Return arm, kind, catches by `straight`, `search` and in more time, ms, a broken promise."""
    made = planted(arm, kind, k)
    plan = last = solve(made)
    if not plan.caught:
        last = plan_with(get_planner("search"), made, LIMIT)
    broken = bool(examine(situation_to_json(made), plan_to_json(last)).complaints)
    straight = solve(made, "straight").caught
    return arm, kind, straight, plan.caught, last.caught, plan.planning_ms, broken


def main() -> None:
    """Ask and print."""
    rows = [asked(arm, kind, k) for arm in ARMS for kind in KINDS for k in range(COUNT)]
    print(f"\nA catch is known in each of these situations (seed {SEED}). They have 6 to 20")
    print("obstacles, a crowd has 40 to 80. Half of the arms have limits of acceleration,")
    print("which `straight` does not keep.\n")
    columns = "situations | straight | search | in 10 s | caught [%] | median [ms] | wrong"
    print(f"| known | {columns} |")
    print("|---|---|---|---|---|---|---|---|")
    few = [row for row in rows if row[1] != "crowd"]
    parts = {arm: [row for row in few if row[0] == arm] for arm in ARMS}
    parts |= {kind: [row for row in few if row[1] == kind] for kind in KINDS[:-1]}
    parts |= {"in sum": few, "crowd": [row for row in rows if row[1] == "crowd"]}
    for name, part in parts.items():
        straight, caught, late, wrong = (sum(row[i] for row in part) for i in (2, 3, 4, 6))
        share, median = 100.0 * late / len(part), np.median([row[5] for row in part])
        counts = f"{name} | {len(part)} | {straight} | {caught} | {late}"
        print(f"| {counts} | {share:.1f} | {median:.0f} | {wrong} |")


if __name__ == "__main__":
    main()
