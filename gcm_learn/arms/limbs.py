"""The seam between arms and kernels: functions of a limb, chosen by the limb's type.

Kernels call these names with any limb; numba picks the implementation when it compiles, so a
specialised body costs nothing at run time.  A *place* is what `place` returns and holds where the
links are at one posture; a *slack* holds how far their points may travel.  Either may be a tuple of
numbers, or a mere token where a limb keeps them in arrays of its own.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from numba.extending import overload

from gcm_learn.arms import chain_limb, spatial_limb, swivels
from gcm_learn.arms.chain_limb import ChainLimb
from gcm_learn.arms.spatial_limb import SpatialLimb

_TABLES: dict[Callable[..., Any], dict[type | None, Callable[..., Any]]] = {}


def by_limb(stub: Callable[..., Any]) -> Any:
    """Make a function whose first argument is a limb and whose body is chosen by its type.

    Parameters
    ----------
    stub : callable
        Its signature and docstring are the contract; its body is never run.
    """
    table = _TABLES.setdefault(stub, {})

    def body(first: Any, *arguments: Any) -> Callable[..., Any] | None:
        found = table.get(getattr(first, "instance_class", None), table.get(None))
        return None if found is None else _CALLS[len(arguments)](found)

    overload(stub, strict=False, jit_options={"_nrt": False, "no_cfunc_wrapper": True})(body)
    return stub


_CALLS: tuple[Callable[..., Any], ...] = (
    lambda f: lambda a: f(a),
    lambda f: lambda a, b: f(a, b),
    lambda f: lambda a, b, c: f(a, b, c),
    lambda f: lambda a, b, c, d: f(a, b, c, d),
    lambda f: lambda a, b, c, d, e: f(a, b, c, d, e),
    lambda f: lambda a, b, c, d, e, g: f(a, b, c, d, e, g),
    lambda f: lambda a, b, c, d, e, g, h: f(a, b, c, d, e, g, h),
    lambda f: lambda a, b, c, d, e, g, h, i: f(a, b, c, d, e, g, h, i),
    lambda f: lambda a, b, c, d, e, g, h, i, j: f(a, b, c, d, e, g, h, i, j),
)
"""Calls of a compiled function by the number of arguments less one.

A thin call shares the function's code, which is kept on disk; its body would be compiled anew.
"""


def give(stub: Callable[..., Any], limb: type | None, body: Callable[..., Any]) -> None:
    """Give a function of `by_limb` its body for a type of limb; None is any other type.

    Parameters
    ----------
    stub : callable
        Made by `by_limb`.
    limb : type, optional
        NamedTuple of the limb.
    body : callable
        Compiled function of the same arguments.
    """
    _TABLES[stub][limb] = body


def register_limb(limb: type, **bodies: Callable[..., Any]) -> None:
    """Give all functions of this module their bodies for a type of limb.

    Raises
    ------
    TypeError
        If a function is missing or unknown.
    """
    names = {stub.__name__: stub for stub in FUNCTIONS}
    if set(bodies) != set(names):
        wrong = ", ".join(sorted(set(bodies) ^ set(names)))
        raise TypeError(f"{limb.__name__}: missing or unknown functions of a limb: {wrong}")
    for name, body in bodies.items():
        give(names[name], limb, body)


@by_limb
def dof(limb):
    """Number of joints."""


@by_limb
def place(limb, q):
    """Place of the links at a posture (n,)."""


@by_limb
def hand_of(limb, place):
    """Position of the hand, three numbers."""


@by_limb
def axis_of(limb, place):
    """Direction in which the hand reaches, three numbers of length 1."""


@by_limb
def link_count(limb):
    """Number of links."""


@by_limb
def link(limb, place, i):
    """Ends of the axis of link i, six numbers, and its radius beyond the limb's thickness."""


@by_limb
def ignores(limb, i, b):
    """Return whether link i is not checked against body b."""


@by_limb
def self_gap(limb, place, slack, enough):
    """Distance of the nearest pair of links that must not overlap, and the same less slack.

    Distances above `enough`, slack taken off, need not be exact; 1e300 without pairs.
    """


@by_limb
def still(limb):
    """Slack of a limb that rests."""


@by_limb
def swept(limb, curve, s, half, place):
    """Slack from share s of a move to s +- half: bounds how far points of each link travel."""


@by_limb
def slack_of(limb, slack, i):
    """Return the bound of travel of link i."""


@by_limb
def hand_rate(limb, curve, s, q):
    """Way of the hand per share of a move at share s; `q` (n,) gets the joints."""


@by_limb
def hand_travel(limb, q, p):
    """Bound how far the hand travels on the straight move from q to p (n,)."""


@by_limb
def hand_bound(limb, rates):
    """Bound of the hand's speed while the joints' rates are at most `rates` (n,)."""


@by_limb
def axis_bound(limb, rates):
    """Bound of the angular speed of the hand's axis while rates are at most `rates` (n,)."""


@by_limb
def reach_of(limb):
    """Bound of the distance between the base's origin and the hand."""


@by_limb
def lever(limb):
    """Bound of the hand's way for a unit of any joint, at any posture; see `hand_too_fast`."""


@by_limb
def jacobian(limb, q, out):
    """Write the derivative of the hand by the joints (n,) into `out` (3, n)."""


@by_limb
def axis_turns(limb, q, out):
    """Write the derivative of the hand's axis by the joints (n,) into `out` (3, n)."""


@by_limb
def postures_at(limb, x, y, z, k, count, low, high, out):
    """Write postures near which the hand may be at a point into `out` (4, n); their number.

    Parameters
    ----------
    k, count : float, int
        Number k of count: of a circle of postures, or of points spread from low to high.
    low, high : (n,) ndarray
        Postures that are of interest.
    """


FUNCTIONS = (
    dof, place, hand_of, axis_of, link_count, link, ignores, self_gap, still, swept, slack_of,
    hand_rate, hand_travel, hand_bound, axis_bound, reach_of, lever, jacobian, axis_turns,
    postures_at,
)  # fmt: skip

register_limb(
    SpatialLimb,
    dof=spatial_limb.dof,
    place=spatial_limb.limb_at,
    hand_of=spatial_limb.hand_of,
    axis_of=spatial_limb.axis_of,
    link_count=spatial_limb.link_count,
    link=spatial_limb.link,
    ignores=spatial_limb.ignores,
    self_gap=spatial_limb.self_gap,
    still=spatial_limb.still,
    swept=spatial_limb.swept,
    slack_of=spatial_limb.slack_of,
    hand_rate=spatial_limb.hand_rate,
    hand_travel=spatial_limb.hand_travel,
    hand_bound=spatial_limb.hand_bound,
    axis_bound=spatial_limb.axis_bound,
    reach_of=spatial_limb.reach_of,
    lever=spatial_limb.reach_of,
    jacobian=spatial_limb.hand_jacobian,
    axis_turns=spatial_limb.axis_turns,
    postures_at=swivels.postures_at,
)
register_limb(
    ChainLimb,
    dof=chain_limb.dof,
    place=chain_limb.place,
    hand_of=chain_limb.hand_of,
    axis_of=chain_limb.axis_of,
    link_count=chain_limb.link_count,
    link=chain_limb.link,
    ignores=chain_limb.ignores,
    self_gap=chain_limb.self_gap,
    still=chain_limb.still,
    swept=chain_limb.swept,
    slack_of=chain_limb.slack_of,
    hand_rate=chain_limb.hand_rate,
    hand_travel=chain_limb.hand_travel,
    hand_bound=chain_limb.hand_bound,
    axis_bound=chain_limb.axis_bound,
    reach_of=chain_limb.reach_of,
    lever=chain_limb.lever,
    jacobian=chain_limb.jacobian,
    axis_turns=chain_limb.axis_turns,
    postures_at=chain_limb.postures_at,
)
