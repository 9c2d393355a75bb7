"""The situations of a training run, and the catches that are shown in them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from gcm_learn.errors import PolicyError
from gcm_learn.execution import Pool, situations_of
from gcm_learn.motion import Trajectory
from gcm_learn.planners import Plan, get_planner
from gcm_learn.policies.plan import Share
from gcm_learn.situation import Situation, canonical

PLANNER = "layered"  # whose catches are shown
Told = Callable[[str], object]


@dataclass(frozen=True)
class Lot:
    """Situations, what is known of them, and catches where they were asked for."""

    situations: list[Situation]
    """In their canonical form."""
    groups: list[str]
    """Stratum, or the source where it is not known."""
    paths: list[Trajectory | None]
    """Of the planner's catch, in canonical coordinates; None if there is none."""

    @property
    def pool(self) -> Pool:
        """Packed for the arena."""
        return Pool.of(self.situations)

    def shown(self) -> Lot:
        """Only what has a catch."""
        rows = [i for i, path in enumerate(self.paths) if path is not None]
        return Lot(
            [self.situations[i] for i in rows],
            [self.groups[i] for i in rows],
            [self.paths[i] for i in rows],
        )


def gather(shares: Sequence[Share], *, plans: bool, tell: Told | None = None) -> Lot:
    """Draw or read situations; in all of them the limb starts free.

    Parameters
    ----------
    shares : sequence of Share
    plans : bool
        Whether catches are wanted: those of a dataset's records, or planned now.
    tell : callable, optional
        Called with a sentence for each share.
    """
    lot = Lot([], [], [])
    for share in shares:
        part = _records(share) if Path(share.source).is_dir() else _drawn(share, plans)
        if not part.situations:
            raise PolicyError(f"situations: nothing of {share.source!r} fits")
        for mine, more in zip(_lists(lot), _lists(part), strict=True):
            mine.extend(more)
        if tell is not None:
            tell(f"{len(part.situations)} situations of {share.source}")
    return lot


def _lists(lot: Lot) -> tuple[list, list, list]:
    return lot.situations, lot.groups, lot.paths


def _records(share: Share) -> Lot:
    """Records of a dataset."""
    from gcm_learn import dataset  # needs pyarrow

    found = dataset.open(share.source).where(split=share.split)
    if share.strata:
        found = found.where(stratum=share.strata)
    if share.families:
        found = found.where(family=share.families)
    lot = Lot([], [], [])
    for k in range(min(share.count, len(found))):
        record = found[k]
        plan = record.plans.get(PLANNER)
        lot.situations.append(record.situation)
        lot.groups.append(record.stratum)
        lot.paths.append(_path(plan))
    return lot


def _drawn(share: Share, plans: bool) -> Lot:
    """Situations of a family or file, in canonical form; planned for if need be."""
    lot, planner = Lot([], [], []), get_planner(PLANNER)
    for drawn in situations_of(share.source, share.count, share.seed):
        situation, _ = canonical(drawn)
        plan: Plan | None = None
        if plans or share.reachable:
            plan = planner.plan(situation)
            if share.reachable and not plan.caught:
                continue
        lot.situations.append(situation)
        lot.groups.append(share.source)
        lot.paths.append(_path(plan))
    return lot


def _path(plan: Plan | None) -> Trajectory | None:
    return plan.trajectory if plan is not None and plan.caught else None
