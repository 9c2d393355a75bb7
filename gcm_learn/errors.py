"""The package's errors: each is a `GcmError` and also the builtin a caller would expect."""

from __future__ import annotations

import difflib
from collections.abc import Iterable

FEW = 12
"""Names that a message lists beside the nearest one, at most."""


def nearest(name: object, known: Iterable[str]) -> str | None:
    """Return the known name most similar to a wrong name, if any is similar."""
    found = difflib.get_close_matches(str(name).lower(), known, 1)
    return found[0] if found else None


def not_among(name: object, known: Iterable[str]) -> str:
    """Return the message that a name is unknown; suggest the nearest known name.

    The known names are listed if they are few, or if none is near.
    """
    names = list(known)
    near = nearest(name, names)
    if near is None:
        return f"{name!r} is not one of {', '.join(names)}"
    among = f"not one of {', '.join(names)}" if len(names) <= FEW else "not known"
    return f"{name!r} is {among}; did you mean {near!r}?"


def not_known(key: str, known: Iterable[str]) -> str:
    """Return the message that a field is unknown; suggest the nearest, or list the known fields."""
    near = nearest(key, known)
    hint = f"did you mean {near!r}?" if near else f"known: {', '.join(sorted(known))}"
    return f"is not a known field ({hint})"


class GcmError(Exception):
    """Base of every error that this package raises on purpose."""


class FieldError(GcmError, ValueError):
    """A field has a value that is not allowed.

    Parameters
    ----------
    field : str
        Path of the field, e.g. ``"bodies[1].shape.radius"``; empty if it is the whole.
    reason : str
        The rule that is broken, with the value that was given.
    """

    def __init__(self, field: str, reason: str) -> None:
        super().__init__(f"{field}: {reason}" if field else reason)
        self.field = field
        self.reason = reason


class SituationError(FieldError):
    """A situation, or the body of an arm, breaks a rule of the exchange contract."""


class ArmKindError(GcmError, ValueError):
    """A planner or a command does not take arms of this kind; the message names both."""


class FamilyError(FieldError):
    """A family of situations has no such field, or cannot draw within its ranges."""


class SpecError(FieldError):
    """A dataset's specification asks for something that there is not."""


class FileFormatError(GcmError, ValueError):
    """A file is not in the expected format; the message names file, line and field."""


class UnknownNameError(GcmError, ValueError):
    """A name (planner, figure, scene) is not registered; the message suggests others."""

    known: tuple[str, ...] = ()
    """Names that are registered."""

    @classmethod
    def among(cls, what: str, name: object, known: Iterable[str]) -> UnknownNameError:
        """Return the error for an unknown name; `what` says what is named, e.g. ``figure``."""
        names = tuple(known)
        error = cls(f"{what}: {not_among(name, names)}")
        error.known = names
        return error


class RobotError(GcmError, ValueError):
    """A robot's file cannot be made into a chain as requested; names the link or joint."""


class LatticeError(GcmError, ValueError):
    """A lattice or wave parameter is outside the range in which the engine is valid."""


class DatasetError(GcmError, RuntimeError):
    """A folder is not the expected dataset: no shards, another schema, changed bytes."""


class ClusterError(GcmError, RuntimeError):
    """A cluster cannot be reached, has gone away, or would not do the same as this machine."""


class MissingExtraError(GcmError, ImportError):
    """Something needs a library that is installed on request only.

    Parameters
    ----------
    what : str
        Name of the part that needs the library.
    library : str
    extra : str
        Name of the group of libraries that the library belongs to.
    """

    def __init__(self, what: str, library: str, extra: str) -> None:
        super().__init__(f"{what} needs {library}: pip install 'gcm_learn[{extra}]'")


class PlatformError(GcmError, RuntimeError):
    """A part of the package needs a feature that this operating system lacks."""

    def __init__(self, what: str, system: str) -> None:
        super().__init__(f"{what} needs {system}")


class RecallError(GcmError, RuntimeError):
    """A memory is missing, damaged, or was made with another index."""


class CoverError(GcmError, RuntimeError):
    """A cover is missing, damaged, or was made for a family that has changed."""


class ArenaError(GcmError, ValueError):
    """An argument does not fit the arena; the message names the argument."""


class StopError(GcmError, ValueError):
    """A movement ends in motion, and no verified stop was found."""


class PhysicsError(GcmError, RuntimeError):
    """Physics cannot move an arm: no body fits, or motors cannot keep the arm's limits."""


class BodyError(PhysicsError):
    """No body fits an arm, so the arm's movements cannot be executed."""


class PolicyError(GcmError, RuntimeError):
    """A policy is missing or damaged, or its training plan is wrong."""


class EncoderError(GcmError, ValueError):
    """An encoder lacks what a caller needs, or its files are damaged."""


class SuiteError(GcmError, ValueError):
    """A comparison names an unknown part, or its situations have changed."""
