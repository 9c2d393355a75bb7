"""Interface between arms and kernels: functions of a limb, chosen by the limb's type.

Kernels call these names with any limb; numba picks the implementation when it compiles, so a
specialised body costs nothing at run time.  A *place* is the value that `place` returns: where the
links are at one posture.  A *slack* is the value of `still` and `swept`: how far points of the
links may travel.  Both are handed on to other functions here, and may be tuples of numbers.  A
`ChainLimb` writes links and travels into its own arrays instead, over those of the call before.
The numbers that it returns then mean nothing; they are only passed on.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from typing import Any

from gcm_learn.arms import chain_limb
from gcm_learn.arms.chain_limb import ChainLimb
from gcm_learn.compiled import by_type, register

_FUNCTIONS: dict[str, Any] = {}


def by_limb(contract: Callable[..., Any]) -> Any:
    """Make a function that dispatches on a limb's type, with the contract's own docstring."""
    made = _FUNCTIONS[contract.__name__] = wraps(contract)(by_type({}))
    return made


def register_limb(limb: type, *modules: Any, **others: Callable[..., Any]) -> None:
    """Give all functions of this module their kernels for a type of limb.

    Parameters
    ----------
    limb : type
        NamedTuple of the limb.
    *modules : module
        Kernels are found there by name, in the first module that has one.
    **others : callable
        Kernels with other names.

    Raises
    ------
    TypeError
        If a function is missing or unknown.
    """
    found = {name: vars(m)[name] for m in modules[::-1] for name in _FUNCTIONS if name in vars(m)}
    kernels = found | others
    if set(kernels) != set(_FUNCTIONS):
        wrong = ", ".join(sorted(set(kernels) ^ set(_FUNCTIONS)))
        raise TypeError(f"{limb.__name__}: missing or unknown functions of a limb: {wrong}")
    for name, kernel in kernels.items():
        register(_FUNCTIONS[name], limb, kernel)


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
    """Return the ends of link i's axis, six numbers, and its radius beyond the limb's thickness."""


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
    """Write the derivative of the hand by the joints (n,), after `place`, into `out` (3, n)."""


@by_limb
def direction_of(limb, q, x, y, z):
    """Direction (x, y, z) in the frame of the hand's joint, after `place` of q (n,), turned."""


@by_limb
def spins(limb, q, out):
    """Write the angular velocity of the hand by the joints, after `place`, into `out` (3, n)."""


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


@by_limb
def inverts(limb):
    """Return whether `postures_at` reaches the point exactly; if not, it gives initial guesses."""


register_limb(ChainLimb, chain_limb)
