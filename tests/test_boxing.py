"""Named tuples that compiled functions return, while signals come."""

from __future__ import annotations

import subprocess
import sys
import textwrap

from gcm_learn.compiled import njit
from gcm_learn.planners.sipp_labels import SearchEnd


@njit
def caught(time):
    return SearchEnd(time, 1, 2.0, 3.0, 4.0, 5), 6


def test_named_tuples_keep_their_class_and_fields():
    made, number = caught(0.5)
    assert isinstance(made, SearchEnd) and number == 6
    assert made == SearchEnd(0.5, 1, 2.0, 3.0, 4.0, 5) and made.time == 0.5


INTERRUPTED = """
    import signal, time
    from typing import NamedTuple
    import numpy as np
    from gcm_learn.compiled import njit

    class Inner(NamedTuple):
        values: np.ndarray
        number: float

    class Outer(NamedTuple):
        inner: Inner
        count: int

    @njit
    def made(given, n):
        return Outer(Inner(given.inner.values, given.inner.number + n), n), given.inner

    class Stop(Exception):
        pass

    def stop(number, frame):
        raise Stop

    given, stops = Outer(Inner(np.zeros(3), 1.0), 1), 0
    made(given, 1)
    signal.signal(signal.SIGALRM, stop)
    begun = time.monotonic()
    while time.monotonic() - begun < 1.0:
        try:
            signal.setitimer(signal.ITIMER_REAL, 1e-5 + 2e-4 * np.random.random())
            while True:
                made(given, 1)
        except Stop:
            stops += 1
    print(stops)
"""


def test_a_signal_may_interrupt_a_compiled_function_at_any_time():
    script = textwrap.dedent(INTERRUPTED)
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert int(done.stdout) > 100
