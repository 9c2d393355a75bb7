"""The command line: one file per command, a frozen dataclass each; heavy imports come late."""

from __future__ import annotations

import os
import sys
import traceback
from collections.abc import Sequence

from gcm_learn.cli.arguments import Command, parse
from gcm_learn.cli.failures import CommandFailure, one_line, place_of
from gcm_learn.errors import FileFormatError, GcmError

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
    try:
        command = parse(sys.argv[1:] if argv is None else argv)
        return 0 if command is None else _run(command)
    except KeyboardInterrupt:
        return _complain("gcm-learn: interrupted", INTERRUPTED)
    except BrokenPipeError:
        _silence_stdout()
        return BROKEN_PIPE
    except FileFormatError as error:
        return _complain(str(error), 2)
    except CommandFailure as error:
        return _complain(f"gcm-learn: {error}", error.exit_code)
    except GcmError as error:
        return _complain(f"gcm-learn: {error}", 2)
    except OSError as error:
        _silence_stdout()
        return _complain(f"gcm-learn: {error}", 1)
    except Exception as error:
        return _complain(f"gcm-learn: unexpected error: {place_of(error)}", 1)


def _run(command: Command) -> int:
    code = command.run()
    if sys.stdout is not None:
        sys.stdout.flush()  # a reader that went away is noticed here, not at interpreter exit
    return code


def _complain(message: str, code: int) -> int:
    if os.environ.get("GCM_LEARN_TRACEBACK"):
        traceback.print_exc()
    print(one_line(message), file=sys.stderr)
    return code


def _silence_stdout() -> None:
    """Point standard output at nothing, or the interpreter complains when it flushes at exit."""
    try:
        nothing = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nothing, sys.stdout.fileno())
        os.close(nothing)
    except (OSError, ValueError, AttributeError):
        pass
