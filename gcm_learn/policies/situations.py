"""The situations of a training run, and the catches that are shown in them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from gcm_learn.errors import PolicyError
from gcm_learn.execution import AnyPool, Pool, SpatialPool, situations_of, spatial_situations_of
from gcm_learn.planners import AnyPlan, get_planner
from gcm_learn.policies.plan import Share
from gcm_learn.situation import AnySituation, canonical, planar

PLANNER = "layered"  # whose catches are shown
Told = Callable[[str], object]


@dataclass(frozen=True)
class Lot:
    """Situations, what is known of them, and catches where they were asked for."""

    situations: list[Any]
    """In their canonical form; in space as they are."""
    groups: list[str]
    """Stratum, or the source where it is not known."""
    paths: list[Any]
    """Of the planner's catch, in canonical coordinates; None if there is none."""

    @property
    def pool(self) -> AnyPool:
        """Packed for the arena."""
        spatial = self.situations[0].is_spatial
        return SpatialPool.of(self.situations) if spatial else Pool.of(self.situations)

    def shown(self) -> Lot:
        """Only what has a catch."""
        rows = [i for i, path in enumerate(self.paths) if path is not None]
        return Lot(
            [self.situations[i] for i in rows],
            [self.groups[i] for i in rows],
            [self.paths[i] for i in rows],
        )


def gather(
    shares: Sequence[Share], *, plans: bool, space: bool = False, tell: Told | None = None
) -> Lot:
    """Draw or read situations; in all of them the limb starts free.

    Parameters
    ----------
    shares : sequence of Share
    space : bool
        Whether the arms are spatial.
    plans : bool
        Whether catches are wanted: those of a dataset's records, or planned now.
    tell : callable, optional
        Called with a sentence for each share.
    """
    lot = Lot([], [], [])
    for share in shares:
        if Path(share.source).is_dir() and not space:
            part = _records(share)
        else:
            part = _drawn(share, plans, space)
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


def _drawn(share: Share, plans: bool, space: bool) -> Lot:
    """Situations of a family or file, in canonical form; planned for if need be."""
    lot, planner = Lot([], [], []), get_planner(PLANNER)
    found: Sequence[AnySituation] = (spatial_situations_of if space else situations_of)(
        share.source, share.count, share.seed
    )
    for drawn in found:
        situation: Any = drawn if space else canonical(planar(drawn, "training"))[0]
        plan: Any = None
        if plans or share.reachable:
            plan = planner.plan(situation)
            if share.reachable and not plan.caught:
                continue
        lot.situations.append(situation)
        lot.groups.append(share.source)
        lot.paths.append(_path(plan))
    return lot


def _path(plan: AnyPlan | None) -> Any:
    return plan.trajectory if plan is not None and plan.caught else None
