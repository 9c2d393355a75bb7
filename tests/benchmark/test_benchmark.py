"""The benchmark: protocol, result files and standings, on suites of three situations."""

import copy
import gzip
import json
import re
from pathlib import Path

import numpy as np
import pytest

from gcm_learn import Movement, Plan, artifacts, benchmark, solve
from gcm_learn.benchmark.machine import spent
from gcm_learn.cli import main
from gcm_learn.errors import ArmKindError, FileFormatError, SuiteError, UnknownNameError
from gcm_learn.families import draw
from gcm_learn.situation import situation_to_json

ROOT = Path(__file__).parents[2]
FAR = {
    "format": "gcm-learn/situation@1",
    "name": "far",
    "horizon": 1.0,
    "arm": {"hand": [1.5, 0.0], "max_hand_speed": 3.0},
    "bodies": [
        {
            "role": "target",
            "name": "ball",
            "shape": {"kind": "disc", "radius": 0.05},
            "motion": {
                "kind": "quadratic",
                "position": [9.0, 0.0],
                "velocity": [0.0, 0.0],
                "acceleration": [0.0, 0.0],
            },
        }
    ],
}
NEAR = copy.deepcopy(FAR) | {"name": "near"}
NEAR["bodies"][0]["motion"]["position"] = [1.2, 0.6]
LATER = copy.deepcopy(NEAR) | {"name": "later", "horizon": 2.0}
LATER["bodies"][0]["motion"]["velocity"] = [0.0, 0.1]


@pytest.fixture
def suite(tmp_path):
    """A file of a warm-up and three situations, one of them out of reach."""
    lines = [
        {"suite": "three", "family": "", "stratum": stratum, "situation": values}
        for stratum, values in (
            ("warm-up", NEAR | {"name": "before"}), ("L", NEAR), ("L", LATER), ("U", FAR)
        )
    ]  # fmt: skip
    path = tmp_path / "three.jsonl"
    path.write_text("".join(json.dumps(line) + "\n" for line in lines), "utf-8")
    return path


def slow_straight(situation):
    """Go straight to a target at rest as late as may be; spend 30 ms on it."""
    since = spent()
    while spent() - since < 0.03:
        pass
    goal = np.array(situation.targets[0].motion.position)
    if np.linalg.norm(goal) > 2.0:
        return Plan(situation.name, "slow", "unreachable", "", 0.0)
    goal = goal + situation.horizon * np.array(situation.targets[0].motion.velocity)
    time = np.linspace(0.0, situation.horizon, 60)
    moves = Movement.of_hand(situation.arm, time, np.linspace(situation.arm.hand, goal, 60))
    end, target = situation.horizon, situation.targets[0].name
    return Plan(situation.name, "slow", "caught", "", 0.0, end, target, trajectory=moves)


def boasting(situation):
    """Promise a catch by a leap."""
    goal = np.array(situation.targets[0].motion.position)
    goal = goal / max(1.0, np.linalg.norm(goal) / 1.9)
    time = np.array([0.0, 1e-3])
    moves = Movement.of_hand(situation.arm, time, np.array([situation.arm.hand, goal]))
    target = situation.targets[0].name
    return Plan(situation.name, "boasts", "caught", "", 0.0, 1e-3, target, trajectory=moves)


def failing(situation):
    raise RuntimeError("no idea")


def found(methods, path):
    loaded = benchmark.load_suite(str(path))
    results = [benchmark.run(method, [loaded]) for method in methods]
    runs = benchmark.runs_by_suite(results)["three.jsonl"]
    return {one.method: one for one in benchmark.standings(loaded, runs)}


def test_catches_promises_errors_and_refusals_are_counted(suite):
    by_name = found([slow_straight, boasting, failing, "straight"], suite)
    slow, quick = by_name["slow_straight"], by_name["straight"]
    assert (slow.caught.value, quick.caught.value) == (1.0, 1.0)
    assert slow.strata == quick.strata == {"L": (2, 2), "U": (1, 1)}
    assert slow.ratio > quick.ratio == 1.0
    boasts, fails = by_name["boasting"], by_name["failing"]
    assert (boasts.broken, boasts.errors, boasts.caught.value) == (3, 0, 0.0)
    assert boasts.strata["U"] == (0, 1), "a broken promise is no refusal"
    assert (fails.errors, fails.broken, fails.caught.value) == (3, 0, 0.0)
    assert slow.median_ms > 10.0, "thinking is counted, in times of the reference machine"
    assert slow.within[0] == 0.0 and slow.within[-1] == 1.0


def test_targets_are_counted_where_several_are_wanted(tmp_path):
    path, situations = tmp_path / "several.jsonl", [draw("sequence-space", 9, k) for k in range(2)]
    lines = [json.dumps(situation_to_json(situation)) + "\n" for situation in situations]
    path.write_text("".join(lines), "utf-8")
    loaded = benchmark.load_suite(str(path))
    result = benchmark.run("search", [loaded])
    (standing,) = benchmark.standings(loaded, [(result, result["runs"][0])])
    answers = [answer["solution"] for answer in result["runs"][0]["answers"]]
    got = sum(len(answer["catches"]) for answer in answers)
    wanted = sum(len(situation.targets) for situation in situations)
    assert benchmark.asks_for_several(loaded) and standing.broken == 0
    assert standing.targets == got / wanted and 0.5 < standing.targets <= 1.0
    assert not benchmark.asks_for_several(benchmark.load_suite("plane"))


def first_leg(situation):
    """Catch as `search` does, and stop after the first of several."""
    plan = solve(situation, "search")
    (name, end), *_ = (*plan.on_the_way, (plan.catch_body, plan.catch_time))
    moves, until = plan.trajectory, plan.trajectory.time <= end
    rates = None if moves.rates is None else moves.rates[until]
    moves = Movement(situation.arm, moves.time[until], moves.joints[until], rates)
    return Plan(situation.name, "first", "caught", "", 0.0, end, name, trajectory=moves)


first_leg.takes = lambda kind: True


def test_more_targets_come_before_earlier_catches(tmp_path):
    path = tmp_path / "several.jsonl"
    situations = [situation_to_json(draw("sequence-space", 9, k)) for k in range(2)]
    path.write_text("".join(json.dumps(values) + "\n" for values in situations), "utf-8")
    loaded = benchmark.load_suite(str(path))
    results = [benchmark.run(method, [loaded]) for method in (first_leg, "search")]
    found = benchmark.standings(loaded, [(result, result["runs"][0]) for result in results])
    assert [one.method for one in found] == ["search", "first_leg"]
    assert found[0].caught == found[1].caught and found[0].targets > found[1].targets
    assert np.isnan(found[0].ratio) and np.isnan(found[1].ratio)


def test_a_catch_at_once_has_a_ratio_beside_its_like_only(suite):
    lines = [json.loads(line) for line in suite.read_text("utf-8").splitlines()]
    lines[1]["situation"]["bodies"][0]["motion"]["position"] = [1.5, 0.0]  # in the hand
    suite.write_text("".join(json.dumps(line) + "\n" for line in lines), "utf-8")
    by_name = found([slow_straight, "straight"], suite)
    assert by_name["straight"].ratio == 1.0 < by_name["slow_straight"].ratio < np.inf


def test_another_method_of_the_same_name_is_asked_anew(suite, tmp_path):
    mine, part = tmp_path / "mine.py", tmp_path / "out.json.part"
    lines = (
        "from gcm_learn import Plan",
        "def plan(situation):",
        "    if situation.name == 'far': raise KeyboardInterrupt",
        "    return Plan(situation.name, 'mine', 'unreachable', 'THIS ONE', 0.0)",
    )
    for word in ("first", "second"):
        mine.write_text("\n".join(lines).replace("THIS ONE", word), "utf-8")
        with pytest.raises(KeyboardInterrupt):
            benchmark.run(f"{mine}:plan", [str(suite)], name="mine", part=part)
    said = [json.loads(line) for line in part.read_text("utf-8").splitlines()]
    assert [line["answer"]["message"] for line in said if "answer" in line] == ["second", "second"]


@pytest.mark.parametrize("line", ["5", '{"passes": ["a"]}', '{"sha256": "0", "answer": {}}'])
def test_a_damaged_line_ends_what_is_kept(suite, tmp_path, line):
    part = tmp_path / "out.json.part"
    asked = []

    def refusing(situation):
        asked.append(situation.name)
        if len(asked) == 3:
            raise KeyboardInterrupt
        return Plan(situation.name, "refusing", "unreachable", "", 0.0)

    with pytest.raises(KeyboardInterrupt):
        benchmark.run(refusing, [str(suite)], part=part)
    head, *kept = part.read_text("utf-8").splitlines()
    part.write_text("\n".join([head, line, *kept]) + "\n", "utf-8")
    benchmark.run(refusing, [str(suite)], part=part)
    assert asked[3:] == ["before", "near", "later", "far"]


def test_each_situation_is_asked_once_after_the_warm_up(suite):
    asked = []

    def counting(situation):
        asked.append(situation.name)
        return Plan(situation.name, "counting", "unreachable", "", 0.0)

    benchmark.run(counting, [str(suite)])
    assert asked == ["before", "near", "later", "far"]


def test_a_run_goes_on_where_it_stopped(suite, tmp_path):
    asked, part = [], tmp_path / "out.json.part"

    def stopping(situation):
        asked.append(situation.name)
        if len(asked) == 3:
            raise KeyboardInterrupt
        return Plan(situation.name, "stopping", "unreachable", "", 0.0)

    with pytest.raises(KeyboardInterrupt):
        benchmark.run(stopping, [str(suite)], part=part)
    with part.open("a", encoding="utf-8") as stream:
        stream.write('{"half of a li')
    result = benchmark.run(stopping, [str(suite)], part=part)
    assert asked == ["before", "near", "later", "before", "later", "far"]
    assert [a["name"] for a in result["runs"][0]["answers"]] == ["near", "later", "far"]
    assert len(result["calibration"]["passes_ms"]) == 15


def test_the_referee_judges_a_sent_file_again(suite):
    loaded = benchmark.load_suite(str(suite))
    result = benchmark.run("straight", [loaded])
    forged = json.loads(json.dumps(result))
    answer = forged["runs"][0]["answers"][0]
    answer["solution"]["trajectory"]["hand"][-1][0] += 0.3
    ours, theirs = [
        benchmark.standings(loaded, benchmark.runs_by_suite([r])["three.jsonl"])[0]
        for r in (result, forged)
    ]
    assert (ours.broken, theirs.broken) == (0, 1)
    assert theirs.caught.value == 0.5


@pytest.mark.parametrize(
    ("change", "line"),
    [
        (lambda run: run.update(sha256="0" * 64), "has hash 0000000000000000, and the others have"),
        (lambda run: run["answers"].pop(0), "the answer to near is missing"),
        (lambda run: run["answers"].pop(), "the answer to the last ones is missing"),
    ],
)
def test_answers_to_other_situations_are_refused_in_one_line(suite, change, line):
    loaded = benchmark.load_suite(str(suite))
    result = benchmark.run(failing, [loaded])
    change(result["runs"][0])
    with pytest.raises(SuiteError, match=line):
        benchmark.standings(loaded, [(result, result["runs"][0])])


@pytest.mark.parametrize(
    ("change", "line"),
    [
        (lambda r: r.pop("method"), "method: is missing"),
        (lambda r: r["calibration"].update(factor=0), "calibration.factor: must be above 0"),
        (lambda r: r["runs"][0]["answers"][1].update(ms="1"), r"answers\[1\].ms: is a str"),
        (lambda r: r["runs"][0]["answers"][1].update(ms=-1), r"answers\[1\].ms: must be from 0"),
        (lambda r: r["calibration"].update(factor=10**400), "calibration.factor: must be above 0"),
        (lambda r: r["runs"].clear(), "runs: must have at least one"),
        (
            lambda r: r["runs"][0]["answers"][1].update(nodes=-5),
            r"\[1\].nodes: must be from",
        ),
        (lambda r: r["runs"][0]["answers"][1].update(ms=10**400), r"\[1\].ms: must be from"),
        (lambda r: r["runs"][0]["answers"][1].update(fault="no"), r"answers\[1\].fault: must be"),
        (lambda r: r.update(protocol=2), "protocol: must be 1"),
        (lambda r: r.update(limit_s=61), "limit_s: must be at most 60"),
        (lambda r: r.update(format="other"), "format: is not 'gcm-learn/benchmark-result@1'"),
    ],
)
def test_files_are_checked_and_name_the_field(suite, tmp_path, change, line):
    result = benchmark.run(failing, [str(suite)])
    for name in ("good.json", "good.json.gz"):
        benchmark.write_result(tmp_path / name, result)
        assert benchmark.read_result(tmp_path / name) == json.loads(json.dumps(result))
    change(result)
    benchmark.write_result(tmp_path / "bad.json", result)
    with pytest.raises(FileFormatError, match=line):
        benchmark.read_result(tmp_path / "bad.json")


def test_arms_that_a_method_does_not_take_are_refused_before_it_is_asked(tmp_path):
    path = tmp_path / "space.jsonl"
    path.write_text(json.dumps(situation_to_json(draw("falling-space", 1, 0))) + "\n", "utf-8")
    with pytest.raises(ArmKindError, match="failing"):
        benchmark.run(failing, [str(path)])


@pytest.mark.parametrize("name", benchmark.SUITES)
def test_shipped_suites_are_as_they_were_frozen(name):
    suite = benchmark.SUITES[name]
    loaded = benchmark.load_suite(name)
    names = [case.name for case in loaded.cases]
    assert len(names) == len(set(names)) == suite.count
    assert loaded.warm_up.name not in names
    assert {case.item.stratum for case in loaded.cases} <= {"L", "W", "Q", "U", "open", ""}
    assert suite.licence and suite.card
    assert f"| `{name}` |" in (ROOT / "docs" / "benchmark.md").read_text("utf-8")


def test_a_changed_suite_is_refused(tmp_path, monkeypatch):
    suite = benchmark.SUITES["plane"]
    content = gzip.decompress(benchmark.suite_file(suite).read_bytes())
    place = tmp_path / suite.file
    place.parent.mkdir()
    place.write_bytes(gzip.compress(content.replace(b'"L"', b'"W"', 1)))
    monkeypatch.setenv(artifacts.VARIABLES["data"], str(tmp_path))
    with pytest.raises(SuiteError, match="was frozen as"):
        benchmark.load_suite("plane")


def test_unknown_suites_and_those_of_others_are_told_apart():
    with pytest.raises(UnknownNameError, match="panda-easy"):
        benchmark.load_suite("panda-esy")
    with pytest.raises(SuiteError, match="gcm-learn convert si-rrt"):
        benchmark.load_suite("si-rrt")


def test_suites_are_small():
    sizes = [benchmark.suite_file(s).stat().st_size for s in benchmark.SUITES.values()]
    assert sum(sizes) < 1.5e6


def test_the_how_to_runs(suite, tmp_path, monkeypatch, capsys):
    text = (ROOT / "docs" / "benchmark.md").read_text("utf-8")
    (example,) = re.findall(r"^```python\n(.*?)^```", text, re.M | re.S)
    (commands,) = re.findall(r"^```bash\n(.*?)^```", text, re.M | re.S)
    body = example.split("def mine(situation):\n")[1]
    assert len(body.splitlines()) <= 10
    monkeypatch.chdir(tmp_path)
    Path("mine.py").write_text(example, "utf-8")
    asked, ours, page = commands.replace("--suite plane", "--suite three.jsonl").splitlines()
    for command in (asked, ours, f"{page} --suite three.jsonl"):
        assert main(command.split()[1:]) == 0
    told = capsys.readouterr().out
    assert "three.jsonl: caught 100.0 %" in told and "broken promises: 0, errors: 0" in told
    assert not list(tmp_path.glob("*.part"))
    shown = Path("leaderboard.html").read_text("utf-8")
    assert "<td>mine</td>" in shown and "<td>search</td>" in shown
    assert 'src="data:image/png;base64' in shown


def test_the_command_refuses_in_one_line(suite, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    for asked, line in [
        (["benchmark", "nobody", "--suite", str(suite)], "nobody"),
        (["benchmark", "straight", "--suite", "nowhere"], "nowhere"),
        (["benchmark", "straight", "--suite", "three.jsonl", "--out", "three.jsonl"], "--suite"),
        (["benchmark", "straight", "--suite", str(suite), "--limit", "0"], "--limit"),
        (["leaderboard", "none.json"], "none.json: is no result file"),
    ]:
        assert main(asked) == 2
        (told,) = capsys.readouterr().err.splitlines()
        assert line in told
    assert [path.name for path in tmp_path.iterdir()] == ["three.jsonl"]


def test_our_results_are_of_the_suites_that_ship_and_may_be_taken_in_part():
    results = benchmark.our_results()
    assert {r["method"] for r in results} >= {"search", "straight", "recall"}
    for result in results:
        for run in result["runs"]:
            suite = benchmark.SUITES[run["suite"]]
            assert (run["sha256"], len(run["answers"])) == (suite.sha256, suite.count)
    some = benchmark.our_results(["plane"])
    assert {run["suite"] for result in some for run in result["runs"]} == {"plane"}


def test_without_the_folder_of_our_results_one_line_tells_where_it_was_looked_for(
    tmp_path, monkeypatch
):
    monkeypatch.setattr(artifacts, "folders", lambda kind: [tmp_path])
    with pytest.raises(SuiteError, match="no folder 'benchmark-results' in"):
        benchmark.our_results()
