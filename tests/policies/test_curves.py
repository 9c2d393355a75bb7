"""Learning curves: when a run has stopped gaining, and what its card says of it."""

import numpy as np

from gcm_learn.policies import curves


def rows_of(shares):
    """Return rows of a log with these shares of catches."""
    return [
        {"steps": 100 * k, "seconds": 1.0, "processor": 36.0 * k, "caught": s, "touched": 0.1}
        for k, s in enumerate(shares)
    ]


def test_a_run_has_stopped_gaining_once_quarters_of_ten_checks_are_within_a_point():
    flat = [0.5] * 40
    assert curves.stopped_gaining(flat) and not curves.stopped_gaining(flat[:39])
    assert not curves.stopped_gaining(flat, 11) and curves.stopped_gaining(flat + flat[:4], 11)
    rising = list(np.linspace(0.0, 0.8, 40))
    assert not curves.stopped_gaining(rising)
    just = [0.2] * 20 + [0.5] * 10
    assert curves.stopped_gaining(just + [0.509] * 10)
    assert not curves.stopped_gaining(just + [0.511] * 10)
    assert curves.stopped_gaining(just + [0.3] * 10), "falling is not gaining"


def test_a_card_says_how_a_run_ended_and_shows_its_first_and_last_check():
    assert "too few checks (3)" in curves.in_words(rows_of([0.1, 0.2, 0.3]))
    assert curves.in_words(rows_of([0.5] * 40)).startswith("stopped gaining")
    rising = rows_of(np.linspace(0.0, 0.8, 40))
    assert curves.in_words(rising).startswith("was still rising")
    table = curves.table_of(rising)
    assert len(table) == 2 + 12
    assert table[2] == "| 0 | 0.00 | 0.0% | 10.0% |"
    assert table[-1] == "| 3,900 | 0.39 | 80.0% | 10.0% |"
    assert len(curves.table_of(rising[:3])) == 2 + 3
