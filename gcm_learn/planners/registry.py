"""Planners by name."""

from __future__ import annotations

import pkgutil
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any, TypeVar, cast
from weakref import WeakValueDictionary

from gcm_learn.arms import PLANAR, SPATIAL, ByKind, Kind
from gcm_learn.errors import UnknownNameError
from gcm_learn.planners.names import all_planner_names, is_registered
from gcm_learn.planners.outside import LIMIT, Outside
from gcm_learn.planners.plan import Anytime, Deadline, Plan, Planner, taken
from gcm_learn.planners.references import acts, found, instance, name_of
from gcm_learn.planners.stages import Staged
from gcm_learn.situation import AnySituation

_PLANNERS: dict[str, str | ByKind[str]] = {
    "gcm": "fronts:gcm",
    "layered": "goal_directed:layered",
    "marching": ByKind({PLANAR: "fronts:marching"}, default="joints.marching:HandMarching"),
    "oracle": "oracle.bounds:OraclePlanner",
    "potential": "baselines.potential:PotentialPlanner",
    "search": ByKind(
        {PLANAR: "goal_directed:search", SPATIAL: "joints.tree_search:search_in_space"},
        default="joints.tree_search:TreeSearch",
    ),
    "st-rrt-star": "baselines.st_rrt_star:STRRTStarPlanner",
    "straight": "baselines.straight:StraightPlanner",
    "straight-wait": "baselines.straight:StraightWaitPlanner",
}
"""Factories in this folder, imported when they are needed; of some names one for each kind."""

_ABOVE = {
    "covered": "gcm_learn.cover.planner:covered",
    "hybrid": "gcm_learn.recall.planners:hybrid",
    "recall": "gcm_learn.recall.planners:recall",
    "recall-1": "gcm_learn.recall.planners:first_choice",
    "recall-map": "gcm_learn.recall.planners:recall_map",
    "recall-pca": "gcm_learn.recall.planners:recall_pca",
    "recall-random": "gcm_learn.recall.planners:recall_random",
    "recall-raw": "gcm_learn.recall.planners:recall_raw",
    "splines-random": "gcm_learn.recall.planners:SplinesPlanner",
}
"""Factories in higher folders, imported at the first use."""
WHOLE = ("covered", "oracle", "st-rrt-star")
"""Planners that look at any horizon as a whole."""
_ACTORS = "gcm_learn.policies.actor:tried_out"
_POLICIES = "gcm_learn.policies.outside:planner_of"
Made = TypeVar("Made")
_OURS: WeakValueDictionary[int, Any] = WeakValueDictionary()
"""Planners that were made here, by identity: their plans are verified as they are made."""


def planner_names() -> list[str]:
    """Names of the planners that need only a situation."""
    return sorted(_PLANNERS)


def get_planner(given: str | Any, *, name: str = "", limit: float | None = LIMIT) -> Planner:
    """Return a planner by name, by reference, or from an object.

    Parameters
    ----------
    given : str, planner, policy or callable
        A registered name; ``clone`` or ``clone@20``, a trained actor by name or folder, which is
        tried out so many times; ``module:name`` or ``path.py:name``; the ``.zip`` of a
        Stable-Baselines3 model; an entry point of an installed package; or an object: a planner, a
        function of a situation, a policy, a model, or a class of these.  A policy's most likely
        movement is the plan.
    name : str, optional
        Name of a planner from outside; by default the reference, or the object's name.
    limit : float, optional
        Time on the wall for a plan of a planner from outside [s].

    Returns
    -------
    Planner
        Plans of planners from outside of the package are verified; see `Outside`.

    Raises
    ------
    UnknownNameError
        With the known names, or the reason why a planner cannot be made.
    MissingExtraError
        If the planner needs a library that is not installed.
    """
    if isinstance(given, Outside) or _OURS.get(id(given)) is given:
        return cast(Planner, given)
    if not isinstance(given, str):
        return _outside(given, name or name_of(given), limit)
    if is_registered(given):
        known = _made(given) if given in _PLANNERS else pkgutil.resolve_name(_ABOVE[given])()
        return as_ours(known if given in WHOLE else Staged(known))
    tried_out = pkgutil.resolve_name(_ACTORS)(given)
    if tried_out is not None:
        return as_ours(Staged(tried_out))
    object_named = found(given)
    if object_named is not None:
        return _outside(object_named, name or given, limit)
    raise UnknownNameError.among("planner", given, all_planner_names())


def _made(name: str) -> Planner:
    """Return a planner of this folder."""
    place = _PLANNERS[name]
    return _make(place) if isinstance(place, str) else ByArm(name, place, _make)


def _make(place: str) -> Planner:
    """Return the planner that a factory of this folder makes."""
    return cast(Planner, pkgutil.resolve_name(f"gcm_learn.planners.{place}")())


def as_ours(planner: Made) -> Made:
    """Remember a planner of this package by its identity, since it verifies its own plans."""
    _OURS[id(planner)] = planner
    return planner


def _outside(given: Any, name: str, limit: float | None) -> Planner:
    """Wrap an object from outside as a planner; a policy becomes a planner that tries it out."""
    made = instance(given, name)
    if acts(made) or isinstance(made, Path):
        made = pkgutil.resolve_name(_POLICIES)(made, name)
    if not callable(getattr(made, "plan", made)):
        kind = type(made).__name__
        raise UnknownNameError(f"planner {name!r}: a {kind} has no function plan(situation)")
    return Outside(made, name, limit)


def solve(situation: AnySituation, planner: str | Any = "search") -> Plan:
    """Plan a catch and verify it.

    Parameters
    ----------
    situation : Situation
    planner : str or object
        A registered name ("search", "gcm", "straight"), or anything else of `get_planner`.

    Returns
    -------
    Plan
        Its status is "caught" only if the trajectory has been verified.  A planner from outside
        whose catch does not hold gets "broken", one that fails "error".

    Raises
    ------
    ArmKindError
        If the planner does not take the situation's arm.

    Examples
    --------
    >>> from gcm_learn import Arm, Body, Disc, PlanarQuadratic, Situation, solve
    >>> still = PlanarQuadratic((1.2, 0.9), (0, 0), (0, 0))
    >>> ball = Body("target", "ball", Disc(0.08), still)
    >>> solve(Situation("reach", 1.0, Arm((1.1, -0.4), 3.1), (ball,)), "straight").status
    'caught'
    """
    return plan_with(get_planner(planner), situation)


def several(situation: AnySituation) -> bool:
    """Return whether a situation asks for more than one catch."""
    return situation.catch in ("all", "most") and len(situation.targets) > 1


def plan_with(
    planner: Planner, situation: AnySituation, deadline: float | Deadline | None = None
) -> Plan:
    """Let a planner answer a situation, if it takes the arm; deadlines are for `Anytime` planners.

    All plans come in here; `Outside` verifies plans from outside of the package. Planners catch one
    target, so of several they catch one after the other, see `planners.sequences`.

    Raises
    ------
    ArmKindError
    """
    chosen = get_planner(planner)
    given: Any = taken(chosen, situation)
    if several(given) and not isinstance(chosen, Outside):
        from gcm_learn.planners.sequences import caught_in_turn

        return caught_in_turn(chosen, given, deadline)
    if deadline is None:
        return chosen.plan(given)
    return cast(Anytime, chosen).plan(given, deadline=deadline)


class ByArm:
    """Planners under one name; the situation's kind of arm selects the planner.

    Parameters
    ----------
    name : str
        Name under which all are registered.
    places : ByKind of str
        Place of each planner's factory.
    make : callable
        Make the planner of a place; called once for each, when it is needed.
    """

    def __init__(self, name: str, places: ByKind[str], make: Callable[[str], Any]) -> None:
        self.name, self._places, self._make = name, places, cache(make)
        places.who = f"planner {name!r}"

    @property
    def anytime(self) -> bool:
        """True if all planners take a deadline; see `Anytime`."""
        made = map(self._make, self._places.entries())
        return all(getattr(planner, "anytime", False) for planner in made)

    def takes(self, kind: Kind) -> bool:
        """Return whether there is a planner for arms of a kind."""
        return self._places.takes(kind)

    def for_arm(self, situation: Any) -> Any:
        """Return the planner for a situation's kind of arm."""
        return self._make(self._places.of(situation))

    def plan(
        self, situation: Any, bound: float | None = None, deadline: float | Deadline | None = None
    ) -> Plan:
        """Answer a situation; a bound and a deadline are for planners that take them."""
        given = {"bound": bound, "deadline": deadline}
        known = {k: v for k, v in given.items() if v is not None}
        return self.for_arm(situation).plan(situation, **known)
