"""The situations of a training run, and the catches that are shown in them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from gcm_learn import execution
from gcm_learn.arms import PLANAR, ByKind
from gcm_learn.errors import PolicyError
from gcm_learn.planners import Plan, get_planner
from gcm_learn.policies.plan import Share

if TYPE_CHECKING:
    from gcm_learn.dataset import Record

PLANNER = "search"  # what it catches can be caught
RECORDED = "layered"  # of records its catches are shown
Told = Callable[[str], object]


@dataclass(frozen=True)
class Lot:
    """Situations with their groups, and with catches if these are wanted."""

    situations: list[Any]
    """In their canonical form; in space as they are."""
    groups: list[str]
    """Stratum, or the source where it is not known."""
    paths: list[Any]
    """Of the planner's catch, in the arena's coordinates, or None."""
    settings: execution.ArenaSettings
    """Of the arms."""

    @property
    def pool(self) -> execution.Pool:
        """Situations packed for the arena."""
        return execution.pool_for(self.settings, self.situations)

    def shown(self) -> Lot:
        """Return the situations that have a catch."""
        rows = [i for i, path in enumerate(self.paths) if path is not None]
        return Lot(
            [self.situations[i] for i in rows],
            [self.groups[i] for i in rows],
            [self.paths[i] for i in rows],
            self.settings,
        )


def gather(
    shares: Sequence[Share],
    settings: execution.ArenaSettings = execution.Settings(),  # noqa: B008 -- frozen
    *,
    plans: bool,
    tell: Told | None = None,
) -> Lot:
    """Draw or read situations; in all of them the limb starts free.

    Parameters
    ----------
    shares : sequence of Share
    settings : ArenaSettings
        Of the arms.
    plans : bool
        Whether catches are wanted: those of a dataset's records, or planned now.
    tell : callable, optional
        Called with a sentence for each share.
    """
    lot = Lot([], [], [], settings)
    for share in shares:
        read = _READERS.of(settings.kind) if Path(share.source).is_dir() else _drawn
        part = read(share, plans, settings)
        if not part.situations:
            raise PolicyError(f"situations: nothing of {share.source!r} fits")
        for mine, more in zip(_lists(lot), _lists(part), strict=True):
            mine.extend(more)
        if tell is not None:
            tell(f"{len(part.situations)} situations of {share.source}")
    return lot


def _lists(lot: Lot) -> tuple[list, list, list]:
    return lot.situations, lot.groups, lot.paths


def _records(share: Share, plans: bool, settings: execution.ArenaSettings) -> Lot:
    """Records of a dataset."""
    lot = Lot([], [], [], settings)
    for record in _wanted(share):
        plan = record.plans.get(RECORDED)
        lot.situations.append(record.situation)
        lot.groups.append(record.stratum)
        lot.paths.append(_path(plan))
    return lot


def _drawn(share: Share, plans: bool, settings: execution.ArenaSettings) -> Lot:
    """Situations of a family or file, in canonical form; planned for if need be."""
    lot = Lot([], [], [], settings)
    names = [PLANNER if share.reachable else "", share.caught_by]
    judges = {name: get_planner(name) for name in names if name}
    shows = get_planner(share.shown_by)
    source: Any = share.source
    if Path(source).is_dir():
        source = [record.situation for record in _wanted(share)]
    for drawn in execution.situations_of(source, share.count, share.seed, settings):
        situation: Any = execution.placed(drawn)[0]
        made = {name: judge.plan(situation) for name, judge in judges.items()}
        if not all(plan.caught for plan in made.values()):
            continue
        plan: Any = None
        if plans:
            plan = made.get(share.shown_by) or shows.plan(situation)
        lot.situations.append(situation)
        lot.groups.append(share.source)
        lot.paths.append(_path(plan))
    return lot


def _wanted(share: Share) -> list[Record]:
    """Return the wanted records of a dataset."""
    from gcm_learn import dataset  # needs pyarrow

    found = dataset.open(share.source).where(split=share.split)
    if share.strata:
        found = found.where(stratum=share.strata)
    if share.families:
        found = found.where(family=share.families)
    return [found[k] for k in range(min(share.count, len(found)))]


def _path(plan: Plan | None) -> Any:
    return plan.trajectory if plan is not None and plan.caught else None


_READERS: ByKind[Callable[[Share, bool, execution.ArenaSettings], Lot]] = ByKind(
    {PLANAR: _records}, default=_drawn
)
"""Readers of datasets' folders: plans of records count only for planar arms."""
