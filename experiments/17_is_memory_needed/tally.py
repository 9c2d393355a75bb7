"""Shares and differences as tables show them."""

from __future__ import annotations

from gcm_learn.evaluation import Interval


def told(found: Interval) -> str:
    """A share with its interval [%]."""
    return "{:.1f} ({:.0f}–{:.0f})".format(*(100 * one for one in found))


def points(found: Interval) -> str:
    """A difference with its interval [points]."""
    return "{:+.1f} ({:+.1f} to {:+.1f})".format(*(100 * one for one in found))
