"""``gcm-learn convert``."""

from __future__ import annotations

import pytest

from gcm_learn import read_situations
from gcm_learn.cli import main
from gcm_learn.outside import CONVERTERS
from tests.outside.conftest import DATA

SOURCES = {
    "motionbenchmaker": DATA / "shelf",
    "si-rrt": DATA / "flying.json",
    "table-tennis": DATA / "balls.json",
}


@pytest.mark.parametrize("suite", CONVERTERS)
def test_every_suite_is_written_as_situations(suite, tmp_path, capsys):
    out = tmp_path / "out.jsonl"
    assert main(["convert", suite, str(SOURCES[suite]), "--out", str(out)]) == 0
    assert read_situations(out) == CONVERTERS[suite]().convert([SOURCES[suite]]).situations
    stdout, stderr = capsys.readouterr()
    assert stdout == "" and "the start is blocked" in stderr


REFUSED = [
    (["hoops", "x"], "suite: 'hoops' is not one of motionbenchmaker, si-rrt, table-tennis"),
    (["si-rrt", SOURCES["si-rrt"], "--moving", "3"], "--moving: is no option of si-rrt"),
    (["table-tennis", SOURCES["table-tennis"], "--within", "1"], "--within: is no option of table"),
    (["si-rrt", SOURCES["si-rrt"], "--arm", "hook"], '"hook" is not the name of an arm'),
    (["si-rrt", SOURCES["si-rrt"], "--horizon", "-1"], "horizon: must be positive"),
    (["motionbenchmaker", SOURCES["motionbenchmaker"], "--within", "9"], "within: must be from 0"),
    (["si-rrt", SOURCES["si-rrt"], "--horizon", "0"], "horizon: must be positive"),
    (["motionbenchmaker", SOURCES["motionbenchmaker"], "--moving", "-1"], "moving: must not be"),
    (["si-rrt"], "SOURCE"),
    (["si-rrt", "nowhere.json"], "nowhere.json: cannot be read"),
]


@pytest.mark.parametrize(("arguments", "message"), REFUSED)
def test_bad_arguments_are_refused_in_one_line(arguments, message, tmp_path, capsys):
    out = tmp_path / "out.jsonl"
    assert main(["convert", *map(str, arguments), "--out", str(out)]) == 2
    stdout, stderr = capsys.readouterr()
    assert stdout == "" and stderr.count("\n") == 1 and message in stderr
    assert not out.exists()
