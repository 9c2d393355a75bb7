"""What others may use of the pictures, and what it takes to import it."""

from __future__ import annotations

import subprocess
import sys

from gcm_learn import plots


def test_the_door_is_complete():
    assert all(hasattr(plots, name) for name in plots.__all__)
    assert plots.__all__ == sorted(plots.__all__)


def test_pictures_need_no_extra():
    code = (
        "import sys, gcm_learn.plots\n"
        "extras = {'torch', 'gymnasium', 'stable_baselines3', 'pyarrow', 'dask', 'faiss'}\n"
        "print(*sorted(extras & set(sys.modules)))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == ""
