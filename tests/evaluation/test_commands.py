"""The commands compare and report."""

from __future__ import annotations

import re
import time
from pathlib import Path

import pytest

from gcm_learn.cli import main
from tests.evaluation.worlds import three

ROOT = Path(__file__).parents[2]


def test_the_how_to_runs(suite, tmp_path, monkeypatch, capsys):
    pytest.importorskip("pyarrow")
    text = (ROOT / "docs" / "benchmark.md").read_text("utf-8")
    example, in_python = re.findall(r"^```python\n(.*?)^```", text, re.M | re.S)
    (commands,) = re.findall(r"^```bash\n(.*?)^```", text, re.M | re.S)
    assert len(example.split("def mine(situation):\n")[1].splitlines()) <= 10
    monkeypatch.chdir(tmp_path)
    Path("mine.py").write_text(example, "utf-8")
    for command in commands.replace("--on plane", "--on three.jsonl").splitlines():
        assert main(command.split()[1:]) == 0
    told = capsys.readouterr().out
    assert "| three.jsonl | mine.py:mine | 2 | 100.0 (" in told
    shown = Path("page/index.html").read_text("utf-8")
    assert "<td>mine.py:mine</td>" in shown and 'src="data:image/png;base64' in shown
    assert "sheet.parquet" in {path.name for path in Path("out").iterdir()}
    names: dict = {}
    exec(example, names)
    exec(in_python.replace("count=20", "count=2"), names)
    assert names["sheet"].each("thinking") == ["0 ms", "20 ms"]


@pytest.mark.parametrize(
    ("argv", "line"),
    [
        (["compare", "nobody", "--on", "gate"], "'nobody' is not one of"),
        (["compare", "serch", "--on", "gate"], "did you mean 'search'"),
        (["compare", "search", "--on", "nowhere"], "'nowhere' is not one of"),
        (["compare", "search", "--on", "none.jsonl"], "none.jsonl"),
        (["compare", "search", "--on", "gate", "--thinking", "20"], "is no time with a unit"),
        (["compare", "search", "--on", "gate", "--limit", "60"], "is no time with a unit"),
        (["compare", "search", "--on", "gate", "--noise", "a"], "numbers with commas"),
        (["compare", "search", "--on", "gate", "--noise", "-1"], "must be above 0"),
        (["compare", "search", "--on", "gate", "--count", "0"], "--count 0"),
        (["compare", "search", "--on", "gate", "--reference", "gcm"], "--reference gcm"),
        (["compare", ",", "--on", "gate"], "names at least one"),
        (["report"], "SHEET is missing"),
        (["report", "none.parquet"], "none.parquet: is not there"),
    ],
)
def test_wrong_arguments_are_refused_at_once_in_one_line(argv, line, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    since = time.perf_counter()
    assert main(argv) == 2
    said = capsys.readouterr().err
    assert line in said and said.count("\n") == 1 and not list(tmp_path.iterdir())
    assert time.perf_counter() - since < 5.0


def test_a_stopped_command_goes_on(tmp_path, monkeypatch, capsys):
    pytest.importorskip("pyarrow")
    monkeypatch.chdir(tmp_path)
    three(tmp_path / "three.jsonl")
    Path("mine.py").write_text(
        "from pathlib import Path\nfrom gcm_learn import Plan\n"
        "def plan(situation):\n"
        "    if situation.name == 'far' and not Path('again').exists(): raise KeyboardInterrupt\n"
        "    with open('asked', 'a') as stream: stream.write(situation.name + ' ')\n"
        "    return Plan(situation.name, 'mine', 'unreachable', '', 0.0)\n"
    )
    argv = ["compare", "mine.py:plan", "--on", "three.jsonl", "--out", "out"]
    assert main(argv) == 130 and not Path("out/sheet.parquet").exists()
    Path("again").touch()
    Path("asked").unlink()
    assert main(argv) == 0 and Path("out/sheet.parquet").exists()
    assert Path("asked").read_text().split()[-1] == "far"
    capsys.readouterr()
    Path("asked").unlink()
    assert main(argv) == 0 and not Path("asked").exists()
