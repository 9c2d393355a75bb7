"""Machines, and the factor by which their processor times are compared."""

from __future__ import annotations

import os
import platform
import subprocess
import sys
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np

from gcm_learn.errors import SuiteError

REFERENCE_MS = 60.0
"""Processor time of a pass on the reference machine [ms]."""
PASSES = 5  # at the start and at the end of a run
SCRIPT = Path(__file__).with_name("products.py")
THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "VECLIB_MAXIMUM_THREADS")


def passes(count: int = PASSES) -> list[float]:
    """Return the processor times [ms] of passes on one thread, measured in a separate process.

    Raises
    ------
    SuiteError
        If the process fails.
    """
    alone = os.environ | dict.fromkeys(THREADS, "1")
    asked = [sys.executable, str(SCRIPT), str(count)]
    done = subprocess.run(asked, env=alone, capture_output=True, text=True, check=False)
    if done.returncode:
        raise SuiteError(f"calibration: {(done.stderr.strip() or 'no output').splitlines()[-1]}")
    return [float(line) for line in done.stdout.split()]


def factor_of(measured: Sequence[float]) -> float:
    """Return the factor by which processor times are multiplied."""
    return REFERENCE_MS / median(measured)


def machine() -> Mapping[str, Any]:
    """Return the machine's entry in result files: processor, system, Python and NumPy."""
    return {
        "processor": _processor(),
        "system": f"{platform.system()} {platform.machine()}",
        "python": platform.python_version(),
        "numpy": np.__version__,
    }


def _processor() -> str:
    """Return the name of the processor."""
    try:
        lines = Path("/proc/cpuinfo").read_text("utf-8").splitlines()
    except OSError:
        lines = []
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.processor() or platform.machine()


def spent() -> float:
    """Return the processor time [s] of this process and of its finished child processes."""
    try:
        import resource
    except ImportError:  # not on Windows
        return time.process_time()
    children = resource.getrusage(resource.RUSAGE_CHILDREN)
    return time.process_time() + children.ru_utime + children.ru_stime
