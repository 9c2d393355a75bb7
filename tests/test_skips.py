"""In continuous integration a skip that nobody agreed to is a failure."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.skips import ALLOWED

TESTS = Path(__file__).parent


def report(outcome, why, **more):
    """A report of a test, as pytest makes it."""
    where = ("test_some.py", 1, f"Skipped: {why}")
    return pytest.TestReport("test", ("", 0, ""), {}, outcome, where, "call", **more)


@pytest.mark.parametrize(
    ("given", "becomes"),
    [
        (report("skipped", "nothing to reach"), "skipped"),
        (report("skipped", "could not import 'nothing_of_that_name'"), "failed"),
        (report("skipped", "known", wasxfail="known"), "skipped"),
        (report("passed", ""), "passed"),
        (
            pytest.CollectReport("test", "skipped", ("", 1, "Skipped: nothing like it"), []),
            "failed",
        ),
    ],
)
def test_only_allowed_skips_stay_skips(given, becomes, request, monkeypatch):
    """In continuous integration; elsewhere all do."""
    conftest = request.config.pluginmanager.get_plugin(str(TESTS / "conftest.py"))
    collected = isinstance(given, pytest.CollectReport)
    hook = "pytest_make_collect_report" if collected else "pytest_runtest_makereport"
    for continuous, wanted in ((False, given.outcome), (True, becomes)):
        monkeypatch.setattr(conftest, "CI", continuous)
        made = getattr(conftest, hook)()
        next(made)
        with pytest.raises(StopIteration) as ended:
            made.send(given)
        assert ended.value.value is given and given.outcome == wanted
    assert given.outcome != "failed" or "not allowed here" in given.longrepr


def test_every_allowance_is_used_and_explained():
    sources = "".join(
        path.read_text("utf-8") for path in TESTS.rglob("*.py") if path.name != "skips.py"
    )
    assert [reason for reason in ALLOWED if f'"{reason}"' not in sources] == []
    assert all(len(why) > 10 for why in ALLOWED.values())
