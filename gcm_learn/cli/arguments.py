"""From an argument list to a command record, by tyro."""

from __future__ import annotations

import contextlib
import importlib
import io
import itertools
import re
from collections.abc import Iterable, Sequence
from difflib import SequenceMatcher
from typing import NamedTuple, Protocol

from gcm_learn import __version__
from gcm_learn.cli.failures import CommandFailure
from gcm_learn.errors import UnknownNameError

ALIKE = 0.8  # ratio of options from which on one is suggested for the other
HELP = ("--help", "-h")


class Command(Protocol):
    """Record of a command."""

    def run(self) -> int:
        """Do the work and return the exit code."""


class CommandEntry(NamedTuple):
    """Command by its record's place, an example of its arguments, and its purpose."""

    place: str
    example: str
    purpose: str


COMMANDS = {
    "solve": CommandEntry(
        "solve:Solve", "scenes.jsonl --plot pictures", "plan catches, a line for each"
    ),
    "play": CommandEntry("play:Play", "", "drag a situation in the browser, see its plan"),
    "execute": CommandEntry(
        "execute:Execute", "scene.json --film films", "let an arm with mass do it"
    ),
    "arm": CommandEntry("arm:Arm", "", "arms that ship; or an arm from a robot's file"),
    "draw": CommandEntry("draw:Draw", "gate --count 20 --out gates.jsonl", "random situations"),
    "convert": CommandEntry(
        "convert:Convert", "si-rrt PROBLEMS --out si.jsonl", "problems of others"
    ),
    "generate": CommandEntry(
        "generate:Generate", "train.toml --out data/mine", "a dataset, made on"
    ),
    "inspect": CommandEntry(
        "inspect:Inspect", "data/mine", "what a dataset, a model or an arm holds"
    ),
    "memory make": CommandEntry(
        "memory:Make", "data/mine --out models/recall", "remember its catches"
    ),
    "memory embed": CommandEntry(
        "memory:Embed", "data/mine --out e.npz", "what an encoder makes of them"
    ),
    "cluster": CommandEntry(
        "cluster:Cluster", "data/mine --out clusters", "catches that are alike"
    ),
    "train policy": CommandEntry("train:Policy", "ppo.yml --out models/mine", "learn in the arena"),
    "train encoder": CommandEntry("train:Encoder", "data/mine --out models/e", "learn to recall"),
    "compare": CommandEntry(
        "compare:Compare", "search,mine.py:Mine --on mine.jsonl", "all on the same"
    ),
    "report": CommandEntry(
        "report:Report", "comparison/sheet.parquet", "sheets of answers as a page"
    ),
    "calibrate": CommandEntry(
        "calibrate:Calibrate", "tracks.csv --predictor velocity", "margins from recorded tracks"
    ),
    "cover": CommandEntry("cover:Cover", "belt --out models/belt", "proven catches of a family"),
    "warm-up": CommandEntry("warm_up:WarmUp", "", "compile everything now, not at the first use"),
    "demo": CommandEntry("demo:Demo", "", "a page of results; figures and files to begin with"),
}
OLD = {
    "figure": "demo --figure",
    "animate": "solve --film",
    "arms": "arm",
    "families": "draw --list",
    "example": "demo --copy",
    "gallery": "inspect --pictures",
    "remember": "memory make",
    "train-policy": "train policy",
    "train-encoder": "train encoder",
    "evaluate": "compare",
    "benchmark": "compare",
    "leaderboard": "report",
}
"""Former commands, and what takes their place."""


def parse(argv: Sequence[str]) -> Command | None:
    """Return the command that `argv` asks for, or None when help or version was printed.

    Raises
    ------
    CommandFailure
        When the arguments make no sense; the message is tyro's, brought to one line.
    UnknownNameError
        When there is no such command.
    """
    if list(argv) == ["--version"]:
        print(f"gcm-learn {__version__}")
        return None
    for words in (2, 1):
        name = " ".join(argv[:words])
        if name in COMMANDS:
            return _record(name, argv[words:])
    group = [name for name in COMMANDS if argv and name.split()[0] == argv[0]]
    rest = argv[1:] if group else argv
    if rest and rest[0] in HELP:
        print(_overview(group or COMMANDS))
        return None
    raise _unknown(argv, group)


def _record(name: str, argv: Sequence[str]) -> Command | None:
    """Parse a command's arguments into its record; tyro suggests options of this command only."""
    import tyro

    module, record = COMMANDS[name].place.split(":")
    command = getattr(importlib.import_module(f"gcm_learn.cli.{module}"), record)
    complaint, prog = io.StringIO(), f"gcm-learn {name}"
    try:
        with contextlib.redirect_stderr(complaint):
            made: Command = tyro.cli(command, prog=prog, args=argv)
            return made
    except SystemExit as stop:
        if not stop.code:
            return None
        raise CommandFailure(f"{_summary(complaint.getvalue())} (see {prog} --help)") from None


def _unknown(argv: Sequence[str], group: Sequence[str]) -> Exception:
    """Return the error for arguments that name no command."""
    if not argv or (group and not argv[1:]):
        known = ", ".join(group or COMMANDS)
        return CommandFailure(f"a command is missing: {known} (see gcm-learn --help)")
    if argv[0] in OLD:
        return CommandFailure(f"{argv[0]!r} is now {OLD[argv[0]]!r}")
    return UnknownNameError.among("command", " ".join(argv[: 1 + bool(group)]), group or COMMANDS)


def _overview(names: Iterable[str]) -> str:
    """Return a line for each command."""
    lines = [f"gcm-learn {name} {COMMANDS[name].example}".rstrip() for name in names]
    width = max(map(len, lines))
    told = (
        f"  {line:<{width}}  {COMMANDS[name].purpose}"
        for line, name in zip(lines, names, strict=True)
    )
    return "\n".join([
        "Catching among moving obstacles with generalized cognitive maps.", "", *told, "",
        "gcm-learn COMMAND --help explains a command, gcm-learn --version says which version "
        "this is.\nTimes have a unit: 20ms, 0.02s, 5min. An output replaces what was there "
        "once it is whole;\nlong work that was stopped goes on where it was.",
    ])  # fmt: skip


def _summary(box: str) -> str:
    """Return the title and first section of tyro's framed error message as one line."""
    bare = re.sub(r"\x1b\[[0-9;]*m", "", box)
    title, *rest = [line.strip(" ╭╮╰╯│─") for line in bare.splitlines()] or ["bad arguments"]
    section = itertools.takewhile(
        _has_words, itertools.dropwhile(lambda x: not _has_words(x), rest)
    )
    body = " ".join(section)
    message = body if body.startswith(title) else f"{title}: {body}"
    hint = re.search(r"Perhaps you meant:\W+(--[\w-]+)", bare)
    for pattern, plain in _IN_WORDS:
        message = re.sub(pattern, plain, message)
    given = re.search(r"--[\w-]+", message)
    alike = hint and given and SequenceMatcher(None, hint[1][2:], given[0][2:]).ratio() > ALIKE
    return message + (f"; did you mean {hint[1]}?" if hint and alike else "")


_IN_WORDS = (
    (r"no type matching \{None\}\|\w+ could be instantiated from \[('.*')\]\.", r"no number: \1"),
    (r"invalid literal for int\(\) with base 10: ", "no whole number: "),
    (r"could not convert string to float: ", "no number: "),
    (r"Value error: Error parsing (--[\w-]+): (?=\S+: must)", r"\1 "),
    (r"Value error: Error parsing (--[\w-]+)", r"\1"),
)
"""Parts of tyro's complaints, and what takes their place."""


def _has_words(line: str) -> bool:
    """Tell a line of text from a rule or a frame."""
    return re.search(r"\w", line) is not None
