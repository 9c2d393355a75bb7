"""The command line: each command a frozen dataclass; heavy imports come late."""

from __future__ import annotations

import atexit
import os
import re
import sys
import traceback
from collections.abc import Sequence
from typing import TYPE_CHECKING

from gcm_learn.cli.failures import CommandFailure, one_line, place_of
from gcm_learn.cli.interrupts import Interrupts
from gcm_learn.errors import FileFormatError, GcmError

if TYPE_CHECKING:
    from gcm_learn.cli.arguments import Command

__all__ = ["main"]

INTERRUPTED = 130
BROKEN_PIPE = 141


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command and return its exit code.

    Whatever goes wrong is said in one line on standard error. With the environment variable
    ``GCM_LEARN_TRACEBACK`` set, the traceback precedes it.

    Parameters
    ----------
    argv : sequence of str, optional
        Arguments without the program's name. Default: those of the process.

    Returns
    -------
    int
        0 when the command did all it was asked for, 2 for bad arguments or bad input, 1 when
        it failed on the way, 130 after Ctrl-C, 141 when the reader of its output went away.
    """
    with Interrupts() as interrupts:
        if argv is None:  # before libraries come, so that theirs is done before
            atexit.register(interrupts.leave, INTERRUPTED)
        try:
            from gcm_learn.cli.arguments import parse

            command = parse(sys.argv[1:] if argv is None else argv)
            return 0 if command is None else _run(command)
        except (Exception, KeyboardInterrupt) as error:
            return _complain(KeyboardInterrupt() if interrupts.caused(error) else error)


def _run(command: Command) -> int:
    code = command.run()
    if sys.stdout is not None:
        sys.stdout.flush()  # a reader that went away is noticed here, not at interpreter exit
    return code


def _complain(error: BaseException) -> int:
    """Print an error, but no broken pipe, as one line on standard error; return the exit code."""
    if os.environ.get("GCM_LEARN_TRACEBACK"):
        traceback.print_exc()
    if isinstance(error, OSError):
        _silence_stdout()
    if isinstance(error, BrokenPipeError):
        return BROKEN_PIPE
    message, code = _verdict(error)
    print(one_line(message), file=sys.stderr)
    return code


def _verdict(error: BaseException) -> tuple[str, int]:
    """Return the message and the exit code of an error."""
    match error:
        case KeyboardInterrupt():
            return "gcm-learn: interrupted", INTERRUPTED
        case FileFormatError() if re.match(r".*?:\d+: ", str(error)):
            return str(error), 2  # it begins with file and line, as an editor expects
        case CommandFailure():
            return f"gcm-learn: {error}", error.exit_code
        case GcmError():
            return f"gcm-learn: {error}", 2
        case OSError():
            return f"gcm-learn: {error}", 1
    return f"gcm-learn: unexpected error: {place_of(error)}", 1


def _silence_stdout() -> None:
    """Redirect standard output to the null device, so that flushing it at exit raises no error."""
    try:
        nothing = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nothing, sys.stdout.fileno())
        os.close(nothing)
    except (OSError, ValueError, AttributeError):
        pass
