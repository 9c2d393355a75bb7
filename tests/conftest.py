"""Fixtures and settings shared by all tests."""

from __future__ import annotations

import os
import shutil
import signal
from collections.abc import Generator, Iterator
from dataclasses import replace
from typing import TypeVar

import numpy as np
import pytest
from hypothesis import settings

from gcm_learn import compiled, seeding
from tests import skips

CI = bool(os.environ.get("CI"))
FLAGS = (
    "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-sync",
    "--disable-background-networking", "--disable-component-update",
)  # fmt: skip
Report = TypeVar("Report", pytest.TestReport, pytest.CollectReport)

# Compilation makes the first example slow, so there is no deadline. Continuous integration
# draws the same examples every time, and fewer: a red run must be about the change.
settings.register_profile("desk", deadline=None)
settings.register_profile("ci", deadline=None, derandomize=True, max_examples=15)
settings.load_profile("ci" if CI else "desk")

compiled.on_compile.clear()  # what tests read of standard error does not depend on the cache


@pytest.hookimpl(wrapper=True, tryfirst=True)
def pytest_runtest_makereport() -> Generator[None, pytest.TestReport, pytest.TestReport]:
    """In continuous integration no test is skipped without an agreement."""
    return _judged((yield))


@pytest.hookimpl(wrapper=True, tryfirst=True)
def pytest_make_collect_report() -> Generator[None, pytest.CollectReport, pytest.CollectReport]:
    """And no module."""
    return _judged((yield))


def _judged(report: Report) -> Report:
    if CI:
        skips.judge(report)
    return report


@pytest.fixture
def rng() -> np.random.Generator:
    """Return the generator of seed 0, fresh for every test."""
    return seeding.rng(0)


@pytest.fixture
def interruptible() -> Iterator[None]:
    """Ctrl-C raises, also where the tests were started in the background, which ignores it."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.fixture(scope="session")
def scheduler():
    """Address of a scheduler with two workers, all within this process."""
    distributed = pytest.importorskip("distributed")
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, processes=False, dashboard_address=None
    ) as made:
        yield made.scheduler_address


@pytest.fixture(scope="session")
def browser():
    """Start the system's Chromium."""
    sync_api = pytest.importorskip("playwright.sync_api")
    found = shutil.which("chromium") or shutil.which("google-chrome")
    if found is None:
        pytest.skip("no Chromium")
    with sync_api.sync_playwright() as playwright:
        chromium = playwright.chromium.launch(executable_path=found, args=list(FLAGS))
        yield chromium
        chromium.close()


@pytest.fixture(scope="session")
def small_folder(tmp_path_factory) -> str:
    """Folder of a dataset of 50 records that no test changes."""
    return _dataset("SMALL", tmp_path_factory, audit=0.1)


@pytest.fixture(scope="session")
def marked_folder(tmp_path_factory) -> str:
    """Folder of a dataset with all kinds of splits, see its specification."""
    return _dataset("MARKED", tmp_path_factory)


def _dataset(name: str, tmp_path_factory, **changes) -> str:
    pytest.importorskip("pyarrow")
    from tests.dataset import conftest

    folder = str(tmp_path_factory.mktemp(name.lower()))
    conftest.make_here(replace(getattr(conftest, name), **changes), folder)
    return folder
