"""Objects from outside of the package: found by a reference, made, and named."""

from __future__ import annotations

import hashlib
import importlib
import importlib.util
import inspect
import sys
import traceback
from collections.abc import Callable
from functools import reduce
from importlib import metadata
from pathlib import Path
from types import ModuleType
from typing import Any

from gcm_learn.errors import GcmError, UnknownNameError

GROUPS = ("gcm_learn.planners", "gcm_learn.policies")
"""Groups of entry points by which installed packages offer planners and policies."""
MODEL = ".zip"
"""Ending of the files of Stable-Baselines3 models."""


def found(reference: str) -> Any:
    """Return the object that a reference names; None for a bare name that has no entry point.

    Parameters
    ----------
    reference : str
        ``module:name``, ``path.py:name``, a path to a ``.zip`` of Stable-Baselines3, or the name
        of an entry point in one of `GROUPS`.

    Raises
    ------
    UnknownNameError
        In one line: the module cannot be imported, or has no such attribute.
    """
    if reference.endswith(MODEL):
        return Path(reference)
    place, colon, name = reference.rpartition(":")
    if colon:
        module = _imported(place, reference)
        try:
            return reduce(getattr, name.split("."), module)
        except AttributeError:
            raise UnknownNameError(f"{reference!r}: {place} has no {name!r}") from None
    if reference.endswith(".py"):
        raise UnknownNameError(f"{reference!r}: needs the name of an object, as in mine.py:Mine")
    for group in GROUPS:
        for entry in metadata.entry_points(group=group, name=reference):
            return _tried(entry.load, reference)
    return None


def absolute(reference: str) -> str:
    """Return a reference that means the same in another folder."""
    place, colon, name = reference.rpartition(":")
    if colon and place.endswith(".py"):
        return f"{Path(place).resolve()}:{name}"
    return str(Path(reference).resolve()) if reference.endswith(MODEL) else reference


def source_of(given: Any) -> str:
    """Return a reference with the hash of its file; for an object, its module and name."""
    if not isinstance(given, str):
        made = given if hasattr(given, "__qualname__") else type(given)
        return f"{made.__module__}.{made.__qualname__}"
    place = given.rpartition(":")[0] or given
    path = Path(place) if place.endswith((".py", MODEL)) else _file_of(place)
    if path is None or not path.is_file():
        return given
    return f"{given} {hashlib.sha256(path.read_bytes()).hexdigest()[:16]}"


def _file_of(module: str) -> Path | None:
    """Return the file of an imported module, if it has one."""
    made = sys.modules.get(module)
    place = getattr(made, "__file__", None)
    return None if place is None else Path(place)


def instance(given: Any, told: str) -> Any:
    """Return an object: a class, or a function without arguments, is called once.

    Parameters
    ----------
    given : object
    told : str
        Name for messages.
    """
    if isinstance(given, type) or (_is_function(given) and not _wants_arguments(given)):
        return _tried(given, told)
    return given


def acts(given: Any) -> bool:
    """Return whether an object is a policy: it has `act` or `predict`, but no `plan`."""
    able = any(callable(getattr(given, name, None)) for name in ("act", "predict"))
    return able and not callable(getattr(given, "plan", None))


def name_of(given: Any) -> str:
    """Return the `name` of an object, a function's name, or the name of the class."""
    for attribute in ("name", "__name__"):
        name = getattr(given, attribute, None)
        if isinstance(name, str) and name.strip():
            return " ".join(name.split())
    return type(given).__name__


def in_words(error: BaseException) -> str:
    """Return an error as one line."""
    text = " ".join(str(error).split())
    return f"{type(error).__name__}: {text}" if text else type(error).__name__


def place_in(error: BaseException, caller: str) -> str:
    """Return the last place of an error outside of the calling file, in brackets."""
    frames = [f for f in traceback.extract_tb(error.__traceback__) if f.filename != caller]
    return f" ({Path(frames[-1].filename).name}:{frames[-1].lineno})" if frames else ""


def _is_function(given: Any) -> bool:
    return inspect.isroutine(given) and not isinstance(given, ModuleType)


def _wants_arguments(function: Callable[..., Any]) -> bool:
    """Return whether a function takes positional arguments; True if its signature is unknown."""
    try:
        parameters = inspect.signature(function).parameters.values()
    except (TypeError, ValueError):
        return True
    return any(p.kind is not p.KEYWORD_ONLY and p.kind is not p.VAR_KEYWORD for p in parameters)


def _tried(call: Callable[[], Any], told: str) -> Any:
    """Call a function from outside; raise its errors as `UnknownNameError`, in one line."""
    try:
        return call()
    except GcmError:
        raise
    except (Exception, SystemExit) as error:
        raise UnknownNameError(f"{told!r}: cannot be made ({in_words(error)})") from error


def _imported(place: str, reference: str) -> ModuleType:
    """Return a module by its name, or by the path of its file."""
    if place.endswith(".py"):
        if not Path(place).is_file():
            raise UnknownNameError(f"{reference!r}: there is no file {place}")
        return _loaded(Path(place).resolve(), reference)
    try:
        return importlib.import_module(place)
    except (Exception, SystemExit) as error:
        hint = f"; a file is {place}.py:..." if Path(f"{place}.py").is_file() else ""
        reason = f"{place} cannot be imported ({in_words(error)}{hint})"
        raise UnknownNameError(f"{reference!r}: {reason}") from error


def _loaded(path: Path, reference: str) -> ModuleType:
    """Return the module of a file, loaded once for each state of the file."""
    key = hashlib.sha256(str(path).encode() + b"\0" + path.read_bytes()).hexdigest()[:16]
    name = f"_{path.stem}_{key}"
    if name in sys.modules:
        return sys.modules[name]
    spec = importlib.util.spec_from_file_location(name, path)
    assert spec is not None and spec.loader is not None  # of a file that ends in .py
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module  # dataclasses look there
    try:
        spec.loader.exec_module(module)
    except BaseException as error:
        del sys.modules[name]
        if not isinstance(error, (Exception, SystemExit)):
            raise
        reason = f"{path.name} cannot be imported ({in_words(error)})"
        raise UnknownNameError(f"{reference!r}: {reason}") from error
    return module
