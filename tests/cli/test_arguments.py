"""Arguments: help that helps, mistakes that end in one line."""

from __future__ import annotations

import subprocess
import sys

import pytest

import gcm_learn
from gcm_learn.cli import main, warm_up
from gcm_learn.cli.arguments import COMMANDS, OLD
from gcm_learn.cli.options import seconds
from gcm_learn.planners import all_planner_names

MISTAKES = [
    ("", "a command is missing: solve, play"),
    ("memory", "a command is missing: memory make, memory embed"),
    ("fly", "command: 'fly' is not one of solve, play"),
    ("slove a.json", "command: 'slove' is not known; did you mean 'solve'?"),
    ("train polcy", "did you mean 'train policy'?"),
    ("animate a.json", "gcm-learn: 'animate' is now 'solve --film'"),
    ("solve", "FILE"),
    ("inspect nothing", "gcm-learn: nothing: cannot be read (No such file or directory)"),
    ("train policy no.yml --out x", "gcm-learn: no.yml: cannot be read"),
    ("memory make nothing --out x", "gcm-learn: nothing: cannot be read"),
    ("solve .", "gcm-learn: .: cannot be read"),
    ("solve nofile.json", "gcm-learn: nofile.json: cannot be read"),
    ("solve a.json --planner layred", "did you mean 'layered'?"),
    ("solve a.json --planner magic", f"'magic' is not one of {', '.join(all_planner_names())}"),
    ("solve a.json --colour red", "--colour"),
    ("solve a.json --planer gcm", "did you mean --planner?"),
    ("solve a.json b.json", "b.json"),
    ("solve a.json --planner", "--planner"),
    ("solve a.json --deadline 20", "--deadline: '20' is no time with a unit, such as 20ms"),
    ("solve a.json --deadline -1ms", "--deadline: '-1ms' is no time with a unit"),
    ("solve a.json --end up", "--end"),
    ("solve a.json --rate 100", "--rate 100: must be at least 125 and at most 1000"),
    ("solve a.json --rate nan", "--rate nan: must be"),
    ("solve a.json --index -1", "--index -1: must be at least 0 (see gcm-learn solve --help)"),
    ("solve a.json --planner straight --deadline 5ms", "planner 'straight' takes no deadline"),
    ("execute a.json --noise abc", ": --noise: no number: 'abc' (see"),
    ("execute a.json --noise -1", "--noise -1: must be at least 0"),
    ("execute a.json --noise nan", "--noise nan: must be"),
    ("play --port 70000", "--port 70000: must be at least 0 and at most 65535"),
    ("arm robot.urdf --tip hand", "--base and --tip: are needed with FILE"),
    ("draw", "FAMILY is missing; gcm-learn draw --list lists them"),
    ("draw gat", "family: 'gat' is not known; did you mean 'gate'?"),
    ("draw hoop --list", "family: 'hoop' is not one of static-clutter"),
    ("draw gate --n 3", "Unrecognized options: --n, 3 (see gcm-learn draw --help)"),
    ("draw gate --count 1e3", ": --count: no whole number: '1e3' (see"),
    ("draw gate --count 0", "--count 0: must be at least 1"),
    ("draw gate --seed -1", "--seed -1: must be at least 0"),
    ("draw gate --arm ur5", "arm: gate is for planar arms, an arm file is a chain"),
    ("draw throw-chain --arm none.json", "model: none.json: cannot be read"),
    ("draw throw-chain --arm pandda", "is not the name of an arm (known: human"),
    ("draw none.json", "none.json: cannot be read"),
    ("cover belt --out c --free 6", "free: 'belt' has 1 to 5 parameters (got 6)"),
    ("cover belt --out c --free 0", "free: 'belt' has 1 to 5 parameters (got 0)"),
    ("cover bellt --out c", "belt-space-varied, held-belt-varied; did you mean 'belt'?"),
    ("cover belt --out c --share 0", "--share 0: must be above 0 and at most 1"),
    ("cover belt --out c --share 1.5", "--share 1.5: must be above 0 and at most 1"),
    ("cover belt --out c --time 0s", "--time 0s: must be above 0"),
    ("cover belt --out c --cells 0", "--cells 0: must be at least 1"),
    ("cover belt --out c --check -1", "--check -1: must be at least 0"),
    ("cover belt --out c --workers 0", "--workers 0: must be at least 1"),
    ("memory embed models/recall --out e.npy", "--out e.npy: the name must end in .npz"),
    ("cluster none --out c", "none: cannot be read"),
    ("cluster none --out c --by traces", "--by"),
    ("cluster none --out c --count 0", "--count 0: must be at least 1"),
    ("demo --count 3", "Unrecognized options: --count, 3 (see gcm-learn demo --help)"),
    ("demo --seed one", "--seed"),
    ("demo --random -1", "--random -1"),
    ("demo --figure fgi8", "fig8-body; did you mean 'fig8'?"),
    ("demo --figure fig4 --out a.doc", "--out a.doc: the name must end in .png"),
    ("demo --figure fig4 --out x/a.png", "x/a.png"),
    ("demo --copy pppo.yml", "did you mean 'ppo.yml'?"),
    ("demo --copy ppo.yml --out no/where.yml", "--out no/where.yml: No such file"),
    ("warm-up --planners layerd", "did you mean 'layered'?"),
    ("warm-up --planners ,", "--planners: names no planner"),
    ("warm-up --workers 0", "--workers 0"),
]


@pytest.mark.parametrize(("words", "said"), MISTAKES)
def test_a_mistake_is_one_line(words, said, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(words.split()) == 2
    stdout, stderr = capsys.readouterr()
    assert stdout == "" and stderr.count("\n") == 1 and not [*tmp_path.iterdir()]
    assert stderr.startswith("gcm-learn: ") and said in stderr


@pytest.mark.parametrize("command", COMMANDS)
def test_help_names_the_options(command, capsys):
    assert main([*command.split(), "--help"]) == 0
    stdout, stderr = capsys.readouterr()
    assert f"gcm-learn {command}" in stdout and "{None}" not in stdout and stderr == ""


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("--help", "gcm-learn draw gate --count 20 --out gates.jsonl"),
        ("train --help", "gcm-learn train encoder data/mine"),
        ("--version", f"gcm-learn {gcm_learn.__version__}"),
        ("arm", "panda"),
        ("train policy --help", "gcm-learn demo --copy ppo.yml"),
        ("generate --help", "gcm-learn demo --copy train.toml"),
    ],
)
def test_help_has_examples(words, said, capsys):
    assert main(words.split()) == 0
    assert said in " ".join(capsys.readouterr().out.replace("│", " ").split())


def test_former_commands_are_gone_and_what_takes_their_place_is_there():
    assert not set(OLD) & {name.split()[0] for name in COMMANDS}
    assert {new.split(" --")[0] for new in OLD.values()} <= set(COMMANDS)


@pytest.mark.parametrize(
    "words", ["draw x --count 0", "demo --figure x", "inspect x", "train policy x --out y"]
)
def test_a_mistake_is_found_before_anything_heavy_is_loaded(words):
    code = (
        f"import sys; from gcm_learn.cli import main; assert main({words.split()}) == 2\n"
        "sys.exit({'numpy', 'numba', 'matplotlib', 'torch'} & set(sys.modules) != set())"
    )
    subprocess.run([sys.executable, "-c", code], check=True, capture_output=True)


@pytest.mark.parametrize(
    ("text", "time"),
    [("20ms", 0.02), ("0.02s", 0.02), (".5s", 0.5), ("40min", 2400.0), ("2h", 7200.0), ("0", 0.0)],
)
def test_times_have_units(text, time):
    assert seconds(text) == pytest.approx(time)


@pytest.mark.parametrize("text", ["20", "s", "1e3s", "-1s", "1.2.3s", "1 h", "nans", ""])
def test_what_is_no_time_is_refused(text):
    with pytest.raises(ValueError, match="is no time with a unit, such as 20ms"):
        seconds(text)


@pytest.mark.parametrize("whole", [False, pytest.param(True, marks=pytest.mark.slow)])
def test_kernels_are_compiled_for_every_kind_of_arm(whole, capsys, monkeypatch):
    if not whole:
        monkeypatch.setattr(warm_up, "EXAMPLES", warm_up.EXAMPLES[1:3])
        monkeypatch.setattr(warm_up, "ARENAS", warm_up.ARENAS[:1])
    assert main(["warm-up", "--planners", "straight", "--workers", "1"]) == 0
    assert capsys.readouterr() == ("compiled for straight\n", "")
