"""Registry of the kinds of arms: the only code that asks of which kind an arm is."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

from gcm_learn.arms.chain import Chain
from gcm_learn.arms.chain_limb import ChainLimb, limb_of_chain
from gcm_learn.arms.planar import Arm
from gcm_learn.arms.planar_limb import PlanarLimb, planar_limb_of
from gcm_learn.arms.spatial import SpatialArm
from gcm_learn.arms.spatial_limb import spatial_limb_of
from gcm_learn.errors import ArmKindError, not_among

Entry = TypeVar("Entry")


@dataclass(frozen=True, eq=False)
class Kind:
    """One kind of arm; equal only to itself, so that look-ups in tables are fast.

    Parameters
    ----------
    name : str
        Short name, e.g. ``"spatial"``; also the `kind` in files and tables.
    plural : str
        Name in messages, e.g. ``"spatial arms"``.
    arm : type
        Record of an arm, which people use.
    limb : type
        NamedTuple of an arm, which kernels use.
    pack : callable
        Limb of an arm and the names of a situation's bodies.
    formats : tuple of str
        Formats of situations that hold such arms, the default first.
    general : Kind, optional
        Kind of which this is a special case; its entries serve where a table has none for this one.
    as_chain : callable, optional
        Chain that stands and moves as an arm does. The referee judges it, where it knows no arms of
        the kind.
    """

    name: str
    plural: str
    arm: type[Any]
    limb: type[Any]
    pack: Callable[[Any, tuple[str, ...]], Any]
    formats: tuple[str, ...]
    general: Kind | None = None
    as_chain: Callable[[Any], Chain] | None = None


PLANAR = Kind(
    "planar",
    "planar arms",
    Arm,
    PlanarLimb,
    lambda arm, bodies: planar_limb_of(arm),
    ("gcm-learn/situation@1",),
)
CHAIN = Kind(
    "chain",
    "chains",
    Chain,
    ChainLimb,
    limb_of_chain,
    ("gcm-learn/situation@3", "gcm-learn/situation@4"),
)
SPATIAL = Kind(
    "spatial",
    "spatial arms",
    SpatialArm,
    ChainLimb,
    spatial_limb_of,
    ("gcm-learn/situation@2", "gcm-learn/situation@3", "gcm-learn/situation@4"),
    general=CHAIN,
)

_BY_ARM: dict[type, Kind] = {}
_BY_TYPE: dict[type, Kind] = {}  # of records and of limbs


def register_kind(kind: Kind) -> None:
    """Register a kind of arm under the types of its record and of its limb."""
    _BY_ARM[kind.arm] = kind
    _BY_TYPE[kind.arm] = _BY_TYPE[kind.limb] = kind


for _kind in (PLANAR, SPATIAL, CHAIN):  # chains last: the kind of their limbs
    register_kind(_kind)


def kinds() -> tuple[Kind, ...]:
    """Return all registered kinds in the order of registration."""
    return tuple(_BY_ARM.values())


def kind_of(subject: Any) -> Kind:
    """Return the kind of an arm or limb, or of the arm in a situation or scene.

    Raises
    ------
    ArmKindError
        If the subject neither is nor has an arm of a registered kind.
    """
    kind = _BY_TYPE.get(type(subject))
    if kind is None:
        kind = _BY_TYPE.get(type(getattr(subject, "limb", None) or getattr(subject, "arm", None)))
    if kind is not None:
        return kind
    if isinstance(subject, Kind):
        return subject
    raise ArmKindError(f"arm: {type(subject).__name__} is not a registered kind of arm")


def kind_named(name: str) -> Kind:
    """Return the kind of a name.

    Raises
    ------
    ArmKindError
        If no kind has the name; lists the known ones.
    """
    for kind in kinds():
        if kind.name == name:
            return kind
    raise ArmKindError(f"kind: {not_among(name, (kind.name for kind in kinds()))}")


def check_kind(subject: Any, kind: Kind, who: str) -> None:
    """Raise ArmKindError if a subject, see `kind_of`, has an arm of another kind."""
    found = kind_of(subject)
    if found is not kind:
        raise _refused(who, found, subject)


def _refused(who: str, kind: Kind, subject: Any) -> ArmKindError:
    asked = hasattr(subject, "bodies") and hasattr(subject, "name")
    where = f" (situation {subject.name!r})" if asked else ""
    return ArmKindError(f"{who} does not take {kind.plural}{where}")


def is_arm(value: object) -> bool:
    """Return whether a value is an arm of a registered kind."""
    return type(value) in _BY_ARM


def solution_format(situation_format: str) -> str:
    """Return the format that answers a situation's format: the same version of solutions."""
    return situation_format.replace("situation@", "solution@")


class ByKind(Generic[Entry]):
    """Table with one entry for each kind of arm; each layer keeps its own tables.

    Parameters
    ----------
    entries : dict of Kind to entry
        Entries of single kinds.
    default : entry, optional
        Entry of all other kinds, such as kernels that are generic over joints.
    who : str
        Subject of the message to a kind without an entry, e.g. ``"planner 'gcm'"``.
    """

    def __init__(
        self, entries: dict[Kind, Entry], default: Entry | None = None, who: str = "this"
    ) -> None:
        self._entries = dict(entries)
        self._default = default
        self.who = who

    def register(self, kind: Kind, entry: Entry) -> None:
        """Add or replace the entry of a kind."""
        self._entries[kind] = entry

    def takes(self, subject: Any) -> bool:
        """Return whether there is an entry for an arm, situation or kind."""
        return self._entry(kind_of(subject)) is not None

    def of(self, subject: Any) -> Entry:
        """Return the entry for a kind, or for the kind of an arm, situation, limb or scene.

        Raises
        ------
        ArmKindError
            If the kind has no entry.
        """
        kind = kind_of(subject)
        entry = self._entry(kind)
        if entry is None:
            raise _refused(self.who, kind, subject)
        return entry

    def _entry(self, kind: Kind) -> Entry | None:
        """Return the entry of a kind, else of its general kind, else the default."""
        known = kind if kind in self._entries or kind.general is None else kind.general
        return self._entries.get(known, self._default)

    def __iter__(self) -> Iterator[Kind]:
        return iter(self._entries)

    def entries(self) -> Iterator[Entry]:
        """Return the entries of single kinds, in the order of registration."""
        return iter(self._entries.values())
