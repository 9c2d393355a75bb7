"""Errors that end a command with one line on standard error."""

from __future__ import annotations

import importlib
import os
import traceback
from types import ModuleType

from gcm_learn.errors import GcmError

LONGEST_MESSAGE = 500


class CommandFailure(GcmError):
    """Ends a command with one line on standard error.

    Parameters
    ----------
    message : str
        The line, without the program's name.
    exit_code : int
        2 when the user can mend it (arguments, input, places to write to), else 1.
    """

    def __init__(self, message: str, *, exit_code: int = 2) -> None:
        super().__init__(message)
        self.exit_code = exit_code


def one_line(message: str) -> str:
    """Return `message` without line breaks or control characters, cut to a readable length."""
    line = " ".join(message.split())
    line = "".join(c if c.isprintable() else repr(c)[1:-1] for c in line)
    return line if len(line) <= LONGEST_MESSAGE else line[: LONGEST_MESSAGE - 4] + " ..."


def place_of(error: BaseException) -> str:
    """Return the type and message of an unexpected error, and the source line that raised it."""
    frames = traceback.extract_tb(error.__traceback__)
    where = f" ({os.path.basename(frames[-1].filename)}:{frames[-1].lineno})" if frames else ""
    return f"{type(error).__name__}: {error}{where}"


def say(text: str) -> None:
    """Print a step of long work at once."""
    print(text, flush=True)


def why(error: OSError) -> str:
    """Return the reason of an operating-system error, without its number and path."""
    return error.strerror or str(error)


def dataset_package() -> ModuleType:
    """Return the package of datasets; if it cannot be loaded, the error says what to install."""
    try:
        return importlib.import_module("gcm_learn.dataset")
    except ImportError as error:
        raise CommandFailure(str(error)) from None
