"""``gcm-learn convert``."""

import shutil
import tarfile

import pytest

from gcm_learn import read_situations
from gcm_learn.cli import main
from gcm_learn.outside import CONVERTERS, MotionBenchMaker
from gcm_learn.planners.registry import get_planner
from tests.judging import judge
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


MOVING = MotionBenchMaker(moving=3).convert([SOURCES["motionbenchmaker"]]).situations


@pytest.mark.parametrize("suite", [*CONVERTERS, "in motion"])
def test_plans_keep_their_promise(suite):
    made = MOVING if suite == "in motion" else CONVERTERS[suite]().convert([SOURCES[suite]])
    for situation in getattr(made, "situations", made):
        plan = get_planner("search").plan(situation)
        assert judge(situation, plan) == []
        assert plan.caught or suite in ("motionbenchmaker", "in motion")


REFUSED = [
    (["hoops", "x"], "suite: 'hoops' is not one of motionbenchmaker, si-rrt, table-tennis"),
    (["si-rrt", SOURCES["si-rrt"], "--moving", "3"], "--moving: is no option of si-rrt"),
    (["table-tennis", SOURCES["table-tennis"], "--within", "1"], "--within: is no option of table"),
    (["si-rrt", SOURCES["si-rrt"], "--arm", "hook"], '"hook" is not the name of an arm'),
    (["si-rrt", SOURCES["si-rrt"], "--horizon", "1"], "--horizon: '1' is no time with a unit"),
    (["motionbenchmaker", SOURCES["motionbenchmaker"], "--within", "9"], "within: must be from 0"),
    (["si-rrt", SOURCES["si-rrt"], "--horizon", "0s"], "--horizon 0s: must be above 0"),
    (["motionbenchmaker", SOURCES["motionbenchmaker"], "--moving", "-1"], "moving: must not be"),
    (["si-rrt"], "SOURCE"),
    (["si-rrt", SOURCES["si-rrt"], "--arm", ""], "--arm: must not be empty"),
    (["si-rrt", "nowhere.json"], "nowhere.json: cannot be read"),
]


def refused(capsys, *arguments):
    """The one line with which `convert` ends."""
    assert main(["convert", *map(str, arguments)]) == 2
    stdout, stderr = capsys.readouterr()
    assert stdout == "" and stderr.count("\n") == 1
    return stderr


@pytest.mark.parametrize(("arguments", "message"), REFUSED)
def test_bad_arguments_are_refused_in_one_line(arguments, message, tmp_path, capsys):
    out = tmp_path / "out.jsonl"
    assert message in refused(capsys, *arguments, "--out", out)
    assert not out.exists()


TEXTS = {suite: path.read_text("utf-8") for suite, path in SOURCES.items() if path.is_file()}


@pytest.mark.parametrize("damage", ["", "[]", "{}", "null", '"x"', "3", "a,b\n1,2\n", None])
@pytest.mark.parametrize("suite", TEXTS)
def test_damaged_files_are_refused_by_name(suite, damage, tmp_path, capsys):
    """None stands for the first half of the file."""
    text = TEXTS[suite][: len(TEXTS[suite]) // 2] if damage is None else damage
    source, out = tmp_path / "scene.json", tmp_path / "out.jsonl"
    source.write_text(text, "utf-8")
    assert "scene.json" in refused(capsys, suite, source, "--out", out)
    assert not out.exists()


@pytest.mark.parametrize("name", ["scene0001.yaml", "request0001.yaml"])
@pytest.mark.parametrize("damage", ["", "- 1\n", "a:\n\t- b", "a: &a\n  b: *a\n", None])
def test_damaged_scenes_are_refused_by_name(name, damage, tmp_path, capsys):
    folder, out = tmp_path / "shelf", tmp_path / "out.jsonl"
    shutil.copytree(DATA / "shelf", folder)
    text = (folder / name).read_text("utf-8")
    (folder / name).write_text(text[: len(text) // 2] if damage is None else damage, "utf-8")
    command = ["motionbenchmaker", str(folder), "--out", str(out)]
    assert main(["convert", *command]) == 0
    last = capsys.readouterr().err.splitlines()[-1]
    assert last.startswith("1 of 2 left out: ") and name in last
    assert [s.name for s in read_situations(out)] == ["shelf-0002"]
    for path in folder.glob("*0002.yaml"):
        path.unlink()
    out.unlink()
    assert name in refused(capsys, *command) and not out.exists()


def test_an_archive_goes_on_after_what_it_cannot_take(tmp_path, capsys):
    """Goals of two arms, a posture out of range, and a text that is none."""
    folder, out = tmp_path / "problems", tmp_path / "out.jsonl"
    for name, old, new in (
        ("both_arms", "panda_joint7", "panda_right_joint7"),
        ("far", "-2.356, 0,", "2.356, 0,"), ("farther", "-2.356, 0,", "2.456, 0,"),
        ("binary", "", ""), ("shelf", "", ""), ("edge", "-2.356, 0,", "-3.0718001, 0,"),
    ):  # fmt: skip
        shutil.copytree(DATA / "shelf", folder / name)
        for path in folder.glob(f"{name}/*0002.yaml"):
            path.unlink()
        request = folder / name / "request0001.yaml"
        request.write_text(request.read_text("utf-8").replace(old, new), "utf-8")
    (folder / "binary" / "request0001.yaml").write_bytes(b"\xff\xfe")
    archive = tmp_path / "problems.tar.bz2"
    with tarfile.open(archive, "w:bz2") as tar:
        tar.add(folder, "problems")
    assert main(["convert", "motionbenchmaker", str(archive), "--out", str(out)]) == 0
    *_, last = capsys.readouterr().err.splitlines()
    start, reasons = last.split(" left out: ")
    assert start == "5 of 7"
    assert [s.name for s in read_situations(out)] == ["edge-0001", "shelf-0001"]
    assert read_situations(out)[0].arm.joints[3] == -3.0718
    both, far = (r for r in reasons.split("; ") if "both_arms" in r or "far/" in r)
    assert "joint7" in both and far.endswith("(and 1 like it)")
    assert "posture[3]: 2.356 is outside its range" in far and "is not UTF-8" in reasons


@pytest.mark.parametrize("suite", TEXTS)
def test_a_file_that_cannot_be_read_does_not_stop_the_others(suite, tmp_path, capsys):
    (tmp_path / "a.json").write_text("{", "utf-8")
    (tmp_path / "b.json").write_text(TEXTS[suite], "utf-8")
    (tmp_path / "c.json").write_bytes(b"\xff")
    out = tmp_path / "out.jsonl"
    assert main(["convert", suite, str(tmp_path), "--out", str(out)]) == 0
    last = capsys.readouterr().err.splitlines()[-1]
    assert last.startswith("2 of ") and "a.json" in last and "c.json: is not UTF-8" in last
    assert len(read_situations(out)) > 0


def test_a_ball_without_a_number_is_left_out_alone(balls):
    def spoil(rows):
        rows[0]["pos_x"] = "here"

    whole, (source, *_) = CONVERTERS["table-tennis"](), [balls(spoil)]
    result = whole.convert([source])
    assert len(result.left_out) == 1 and "[0].pos_x: must be a number" in str(result.left_out[0])
    assert list(result.notes())[-1].startswith("1 of ") and result.situations


@pytest.mark.parametrize("suite", CONVERTERS)
def test_folders_without_problems_are_refused(suite, tmp_path, capsys):
    (tmp_path / "empty").mkdir()
    (tmp_path / "junk.tar").write_bytes(b"junk" * 100)
    for source in ("empty", "junk.tar"):
        assert source in refused(capsys, suite, tmp_path / source, "--out", tmp_path / "out.jsonl")
    assert not (tmp_path / "out.jsonl").exists()


def test_places_to_write_to_are_checked(tmp_path, capsys):
    """The input stays as it was, and so does an output of a run that fails."""
    text, source = TEXTS["si-rrt"], tmp_path / "flying.json"
    source.write_text(text, "utf-8")
    old = tmp_path / "old.jsonl"
    old.write_text("old")
    for given, out, message in (
        (source, source, "flying.json: is the file of SOURCE, too"),
        (source, tmp_path / "no" / "x.jsonl", "x.jsonl: No such file or directory"),
        (source, tmp_path, ": is a directory"),
        (tmp_path / "none.json", old, "none.json: cannot be read"),
    ):
        assert message in refused(capsys, "si-rrt", given, "--out", out)
    assert source.read_text("utf-8") == text and old.read_text() == "old"
    assert not (tmp_path / "no").exists()
