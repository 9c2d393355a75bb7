"""From an argument list to a command record, by tyro."""

from __future__ import annotations

import contextlib
import io
import itertools
import re
from collections.abc import Callable, Sequence
from difflib import SequenceMatcher
from typing import Protocol

import tyro

from gcm_learn import __version__
from gcm_learn.cli.animate import Animate
from gcm_learn.cli.arm import Arm, Arms
from gcm_learn.cli.benchmark import Benchmark
from gcm_learn.cli.convert import Convert
from gcm_learn.cli.cover import Cover
from gcm_learn.cli.demo import Demo
from gcm_learn.cli.draw import Draw
from gcm_learn.cli.evaluate import Evaluate
from gcm_learn.cli.example import Example
from gcm_learn.cli.execute import Execute
from gcm_learn.cli.failures import CommandFailure
from gcm_learn.cli.families import Families
from gcm_learn.cli.figure import Figure
from gcm_learn.cli.gallery import Gallery
from gcm_learn.cli.generate import Generate
from gcm_learn.cli.inspect import Inspect
from gcm_learn.cli.leaderboard import Leaderboard
from gcm_learn.cli.play import Play
from gcm_learn.cli.remember import Remember
from gcm_learn.cli.solve import Solve
from gcm_learn.cli.train_encoder import TrainEncoder
from gcm_learn.cli.train_policy import TrainPolicy
from gcm_learn.cli.warm_up import WarmUp
from gcm_learn.errors import UnknownNameError

DESCRIPTION = """\
Catching among moving obstacles with generalized cognitive maps.

examples:
  gcm-learn solve scene.json                           one solution on standard output
  gcm-learn solve scenes.jsonl --out solutions.jsonl   one solution a line, in input order
  gcm-learn solve scenes.jsonl --plot pictures         and a picture of each situation
  gcm-learn solve - --planner marching < scenes.jsonl
  gcm-learn play                                       drag a situation in the browser, see its plan
  gcm-learn demo --out demo                            the paper's results as a web page
  gcm-learn figure fig4                                one figure of the paper
  gcm-learn animate scene.json --out scene.gif         the catch as a film
  gcm-learn execute scene.json --film films            and by an arm with mass and motors
  gcm-learn arm robot.urdf --base base --tip hand --out arm.json   an arm from a robot's file
  gcm-learn arms                                       arms that ship
  gcm-learn families                                   what can be drawn at random
  gcm-learn draw gate --count 20 --out gates.jsonl     situations of a family
  gcm-learn convert motionbenchmaker problems.tar.bz2 --out mbm.jsonl   problems of others
  gcm-learn example train.toml                         files to begin with: configurations and more
  gcm-learn generate train.toml --out data/mine        a dataset; again to go on or to enlarge it
  gcm-learn inspect data/mine                          what is in it, in numbers
  gcm-learn gallery data/mine                          and in pictures
  gcm-learn remember data/mine --out models/recall     a memory of its catches
  gcm-learn cover belt --out models/cover-belt         proven catches for a family of situations
  gcm-learn train-policy ppo.yml --out models/mine     a policy that learns in the arena
  gcm-learn train-encoder data/mine --out models/encoder   what recall asks it with
  gcm-learn evaluate --policies layered,straight,clone all on the same situations, with a report
  gcm-learn benchmark mine.py:Mine --out mine.json     your method on frozen suites
  gcm-learn leaderboard mine.json search.json          result files side by side, as a page
  gcm-learn warm-up                                    compile everything now, not at the first use

gcm-learn COMMAND --help explains a command, gcm-learn --version says which version this is."""


ALIKE = 0.8  # ratio of options from which on one is suggested for the other


class Command(Protocol):
    """Record of a command."""

    def run(self) -> int:
        """Do the work and return the exit code."""


COMMANDS: dict[str, Callable[..., Command]] = {
    "solve": Solve,
    "demo": Demo,
    "figure": Figure,
    "animate": Animate,
    "play": Play,
    "execute": Execute,
    "arm": Arm,
    "arms": Arms,
    "families": Families,
    "draw": Draw,
    "convert": Convert,
    "example": Example,
    "generate": Generate,
    "inspect": Inspect,
    "gallery": Gallery,
    "remember": Remember,
    "cover": Cover,
    "train-policy": TrainPolicy,
    "train-encoder": TrainEncoder,
    "evaluate": Evaluate,
    "benchmark": Benchmark,
    "leaderboard": Leaderboard,
    "warm-up": WarmUp,
}


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
    if argv and not argv[0].startswith("-") and argv[0] not in COMMANDS:
        raise UnknownNameError.among("command", argv[0], COMMANDS)
    complaint, name = io.StringIO(), argv[0] if argv and argv[0] in COMMANDS else ""
    prog = f"gcm-learn {name}".strip()
    try:
        with contextlib.redirect_stderr(complaint):
            if name:  # tyro then knows, and suggests, the options of this command only
                return tyro.cli(COMMANDS[name], prog=prog, args=argv[1:])
            tyro.extras.subcommand_cli_from_dict(
                COMMANDS, prog=prog, description=DESCRIPTION, args=argv
            )
    except SystemExit as stop:
        if not stop.code:
            return None
        raise CommandFailure(f"{_summary(complaint.getvalue())} (see {prog} --help)") from None
    return None


def _summary(box: str) -> str:
    """Return the title and first section of tyro's framed complaint, as one line."""
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
    (r"Value error: Error parsing (--[\w-]+)", r"\1"),
)
"""Parts of tyro's complaints, and what takes their place."""


def _has_words(line: str) -> bool:
    """Tell a line of text from a rule or a frame."""
    return re.search(r"\w", line) is not None
