"""Refusals: the one line that an error says."""

import pytest


def refusal(error, call, *values, **fields):
    """Message of the error that a call raises, which is one line."""
    with pytest.raises(error) as caught:
        call(*values, **fields)
    assert len(str(caught.value).splitlines()) == 1
    return str(caught.value)
