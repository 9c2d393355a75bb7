"""The benchmark: frozen suites, one protocol, result files that others can judge again.

>>> from gcm_learn import benchmark
>>> result = benchmark.run("search", ["plane"])  # doctest: +SKIP
>>> benchmark.write_result("search.json", result)  # doctest: +SKIP
"""

from gcm_learn.benchmark.cases import Case, Item, Loaded, load_suite, suite_lines
from gcm_learn.benchmark.judging import Judged, judged
from gcm_learn.benchmark.machine import REFERENCE_MS, factor_of, machine, passes
from gcm_learn.benchmark.results import FORMAT, PROTOCOL, our_results, read_result, write_result
from gcm_learn.benchmark.running import run
from gcm_learn.benchmark.standings import (
    BUDGETS_MS,
    Standing,
    asks_for_several,
    runs_by_suite,
    standings,
)
from gcm_learn.benchmark.suites import OUTSIDE, SUITES, Suite, suite_file, suite_hash, write_suite

__all__ = [
    "BUDGETS_MS",
    "Case",
    "FORMAT",
    "Item",
    "Judged",
    "Loaded",
    "OUTSIDE",
    "PROTOCOL",
    "REFERENCE_MS",
    "SUITES",
    "Standing",
    "Suite",
    "factor_of",
    "judged",
    "load_suite",
    "machine",
    "our_results",
    "passes",
    "read_result",
    "run",
    "runs_by_suite",
    "asks_for_several",
    "standings",
    "suite_file",
    "suite_hash",
    "suite_lines",
    "write_result",
    "write_suite",
]
