"""Kept machine code: numba's cache, by content, and behind it code that was compiled ahead.

Numba renews a cached function when its own file changes, but not when a function that it calls
does.  It keeps code beside the sources, where an installed package must not write.  Here code lies
in the user's cache folder, under the hash of a module's source and of all modules of this package
that it imports.  A change renews what depends on it, and equal sources share their code.  Each file
holds the code for one list of types of arguments, under a hash of these types and of the sources
behind them.  Code that cannot be read is compiled.

Behind that folder lies another one, which is only read: the package `gcm_learn_kernels`. Its code
was compiled ahead for a kind of processor that this one can stand in for.
"""

from __future__ import annotations

import contextlib
import importlib.util
import json
import os
import pickle
import sys
import tempfile
import time
import zlib
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

from llvmlite import binding as llvm
from numba import __version__ as NUMBA
from numba.core import config
from numba.core.caching import CompileResultCacheImpl, FunctionCache
from numba.core.serialize import dumps

from gcm_learn import storage
from gcm_learn.compiled.parts import loading
from gcm_learn.compiled.sources import is_edited, source_hash

PATIENCE = 1.0  # of compiling, after which it is announced [s]
NOTICE = (
    "gcm-learn: compiling for this kind of arm and planner, one or two minutes, once; "
    "another kind or planner compiles again"
)
UNKEPT = (
    "gcm-learn: compiled code cannot be kept in {folder} ({reason}): every run compiles again; "
    "NUMBA_CACHE_DIR names another folder"
)


def say_compiling() -> None:
    """Announce on standard error that code is compiled; a terminal's line of progress is wiped."""
    if sys.stderr is not None:
        wipe = "\r\x1b[K" if sys.stderr.isatty() else ""
        lines = "\n".join([NOTICE, *_unkept()])
        print(f"{wipe}{lines}", file=sys.stderr, flush=True)


def _unkept() -> Iterator[str]:
    """Yield the sentence on a folder in which nothing can be written."""
    place = folder()
    try:
        place.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=place, buffering=0) as stream:
            stream.write(bytes(4096))
    except OSError as error:
        yield UNKEPT.format(folder=place, reason=error.strerror or error)


on_compile: list[Callable[[], object]] = [say_compiling]
"""Called once, and taken out, when compiling takes its time because no code is kept."""
KERNELS = "gcm_learn_kernels"
"""Package with code that was compiled ahead, in its folder ``kernels`` with `MADE_FOR`."""
MADE_FOR = "made_for.json"
_missed: list[float] = []  # when the first code was not found [s]


def _tell_listeners() -> None:
    """Call the listeners once compiling has taken its time."""
    now = time.monotonic()
    _missed[:] = _missed or [now]
    while on_compile and now - _missed[0] >= PATIENCE:
        on_compile.pop()()


def is_kept(function: Callable[..., Any]) -> bool:
    """Return whether a function's code is kept on disk."""
    return _is_ours(function.__module__) and not is_edited(function.__module__)


def _is_ours(module: str) -> bool:
    """Return whether a module is of this package, so that its sources are hashed."""
    return module.partition(".")[0] == "gcm_learn"


def _modules_of(given: Any) -> Iterator[str]:
    """Yield the modules of all named tuples among types of arguments, and within them."""
    made = getattr(given, "instance_class", None)
    if made is not None:
        yield str(made.__module__)
    for part in getattr(given, "types", given if isinstance(given, tuple) else ()):
        yield from _modules_of(part)


def folder() -> Path:
    """Return the folder of compiled code: ``NUMBA_CACHE_DIR`` if set, else the user's cache."""
    return Path(config.CACHE_DIR) if config.CACHE_DIR else storage.user_cache("kernels")


class Ahead(NamedTuple):
    """Code that was compiled ahead."""

    folder: Path
    machine: tuple[str, str, str]
    """Platform, processor and its features, as LLVM names them."""


@cache
def ahead() -> Ahead | None:
    """Return the code that was compiled ahead, if this processor can run it and it is wanted."""
    spec = None if os.environ.get("GCM_LEARN_NATIVE") else importlib.util.find_spec(KERNELS)
    if spec is None or spec.origin is None:
        return None
    place = Path(spec.origin).parent / "kernels"
    try:
        triple, processor, features = json.loads((place / MADE_FOR).read_text("utf-8"))
    except (OSError, ValueError):
        return None
    own = llvm.get_host_cpu_features()
    able = all(own.get(feature[1:]) for feature in features.split(",") if feature.startswith("+"))
    here = able and triple == llvm.get_process_triple()
    return Ahead(place, (triple, processor, features)) if here else None


def folder_of(function: Callable[..., Any]) -> str:
    """Return the name of the folder with the code of a function's module."""
    module = function.__module__
    return f"{module.removeprefix('gcm_learn.')}-{source_hash(module)}"


class _Locator:
    """Folder of a function's code, as numba asks for it."""

    def __init__(self, py_func: Callable[..., Any], py_file: str) -> None:
        self._py_file = py_file
        self._line = py_func.__code__.co_firstlineno
        self._stamp = source_hash(py_func.__module__)
        self._folder = folder() / folder_of(py_func)

    @classmethod
    def from_function(cls, py_func: Callable[..., Any], py_file: str) -> _Locator:
        """As numba asks for it."""
        return cls(py_func, py_file)

    def ensure_cache_path(self) -> None:
        """Make the folder; numba asks before it saves."""
        self._folder.mkdir(parents=True, exist_ok=True)

    def get_cache_path(self) -> str:
        """The folder."""
        return str(self._folder)

    def get_source_stamp(self) -> str:
        """Return the stamp that stored code must have."""
        return self._stamp

    def get_disambiguator(self) -> str:
        """Return a text that differs between functions of one name."""
        return str(self._line)


class _CacheImpl(CompileResultCacheImpl):
    _locator_classes = (_Locator,)


class _CacheFile:
    """Files with the code of one function, each with a checksum; numba's have an index beside.

    An index has to be locked while it is written. In numba's there are types that another
    checkout of the package may not know.

    Parameters
    ----------
    path : str
        Folder.
    name : str
        With which names of files begin.
    """

    def __init__(self, path: str, name: str) -> None:
        self._path, self._name = Path(path), name

    def _of(self, key: str) -> Path:
        return self._path / f"{self._name}.{key}.nbc"

    def load(self, key: str) -> Any:
        """Return the data that is kept under a key; None if it is missing or damaged."""
        try:
            data = memoryview(self._of(key).read_bytes())
        except FileNotFoundError:
            return None
        whole = data[:4] == zlib.crc32(data[4:]).to_bytes(4, "little")
        return pickle.loads(data[4:]) if whole else None

    def save(self, key: str, data: Any) -> None:
        """Keep something under a key, in place of what is there."""
        code = dumps(data)
        storage.write_whole(self._of(key), zlib.crc32(code).to_bytes(4, "little") + code)

    def flush(self) -> None:
        """Remove all, as numba asks for before it compiles anew."""
        for path in self._path.glob(f"{self._name}.*.nbc"):
            path.unlink(missing_ok=True)


class Cache(FunctionCache):
    """Numba's cache of a function, in our place, and no reason to fail if that cannot be used.

    Code for limbs of other modules is compiled anew in each process.  The hash lacks the sources of
    these modules, and other processes may be unable to import them.
    """

    _impl_class = _CacheImpl

    def __init__(self, py_func: Callable[..., Any]) -> None:
        super().__init__(py_func)
        self._cache_file = _CacheFile(self._cache_path, self._impl.filename_base)

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Return the code of a signature; None where it has to be compiled."""
        code = None
        with contextlib.suppress(Exception):  # whatever is wrong with what is kept
            if _may_keep(sig):
                code = super().load_overload(sig, target_context)
                code = self._made_ahead(sig, target_context) if code is None else code
        if code is None:
            _tell_listeners()
        return code

    def _made_ahead(self, sig: Any, target_context: Any) -> Any:
        """Return the code of a signature that was compiled ahead, if there is any."""
        made = ahead()
        if made is None:
            return None
        file = _CacheFile(str(made.folder / folder_of(self._py_func)), self._impl.filename_base)
        data = file.load(self._key(sig, target_context.codegen(), made.machine))
        return None if data is None else self._impl.rebuild(target_context, data)

    def save_overload(self, sig: Any, data: Any) -> None:
        """Keep the code of a signature; where that cannot be done it is not kept."""
        with contextlib.suppress(Exception):
            if _may_keep(sig):
                super().save_overload(sig, data)

    def _index_key(self, sig: Any, codegen: Any) -> str:
        """Return a hash of types of arguments, of the sources behind them, and of the machine."""
        return self._key(sig, codegen, codegen.magic_tuple())

    def _key(self, sig: Any, codegen: Any, machine: tuple[str, ...]) -> str:
        """Return the hash for a platform, a processor and its features."""
        known = [(module, source_hash(module)) for module in _modules_of(_arguments(sig))]
        types = [str(given) for given in _arguments(sig)]
        code = super()._index_key(None, codegen)[-1]
        made_of = types, known, machine, code, sys.version_info[:2], NUMBA
        return storage.content_hash(repr(made_of))[:24]


class _PartImpl(_CacheImpl):
    """Parts lie beside the code for Python."""

    def get_filename_base(self, fullname: str, abiflags: str) -> str:
        return f"part-{super().get_filename_base(fullname, abiflags)}"

    def check_cachable(self, cres: Any) -> bool:
        """Return whether a part may be kept, and warn of nothing: what links it may still be."""
        return not cres.library.has_dynamic_globals and super().check_cachable(cres)

    def rebuild(self, target_context: Any, payload: Any) -> Any:
        with loading(target_context):
            return super().rebuild(target_context, payload)


class PartCache(Cache):
    """Numba's cache of a part."""

    _impl_class = _PartImpl


def _arguments(sig: Any) -> tuple[Any, ...]:
    """Return the types of a signature's arguments."""
    return tuple(getattr(sig, "args", sig))


def _may_keep(sig: Any) -> bool:
    """Return whether the sources behind all types of arguments are ours, and known."""
    return all(_is_ours(m) and not is_edited(m) for m in set(_modules_of(_arguments(sig))))
