"""Compiled kernels and where their code is kept: numba's `njit`, cached by content.

Numba renews a cached function when its own file changes, but not when a function that it calls
does.  It keeps code beside the sources, where an installed package must not write.  Here code lies
in the user's cache folder, under the hash of a module's source and of all modules of this package
that it imports.  A change renews what depends on it, and equal sources share their code.  Each file
holds the code for one list of types of arguments, under a hash of these types and of the sources
behind them.  Code that cannot be read is compiled.
"""

from __future__ import annotations

import contextlib
import gc
import pickle
import re
import sys
import tempfile
import time
import zlib
from collections.abc import Callable, Iterator, Sequence
from functools import cache, cached_property
from pathlib import Path
from typing import Any

from numba import __version__ as NUMBA
from numba.core import config
from numba.core.caching import CompileResultCacheImpl, FunctionCache
from numba.core.registry import CPUDispatcher
from numba.core.serialize import dumps
from numba.core.types.misc import unliteral

from gcm_learn import storage
from gcm_learn.boxing import replace_numbas
from gcm_learn.parts import PartCompiler, WholeCompiler, loading

replace_numbas()

PACKAGE = Path(__file__).parent
STARTED = time.time()
UNCALLED = tuple(
    f"gcm_learn.{name}"
    for name in ("arms.robots", "errors", "late", "motion.as_obstacles", "storage")
)
"""Modules in which no kernel calls anything."""
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
_missed: list[float] = []  # when the first code was not found [s]
_IMPORT = re.compile(
    r"^ *(?:from (gcm_learn[\w.]*) import (\([^)]*\)|[^\n(]*)|import (gcm_learn[\w.]*))", re.M
)


def njit(function: Callable[..., Any] | None = None, **options: Any) -> Any:
    """Compile a function when it is first called, as ``numba.njit(cache=True)`` does.

    Parameters
    ----------
    function : callable
    **options
        Numba's own.
    """
    if function is None:
        return lambda later: njit(later, **options)
    options.setdefault("no_cfunc_wrapper", True)  # for callers in C, and a seventh of compiling
    if config.DISABLE_JIT:
        return function
    options = {"nopython": True, "boundscheck": None} | options
    made = _Kernel(function, targetoptions=options, pipeline_class=WholeCompiler)
    if _is_kept(function):
        made._cache = _Cache(function)
    return made


class _Kernel(CPUDispatcher):  # type: ignore[misc]
    """Compiled function with two codes: one for Python, and a part for functions that call it.

    Each is compiled at its first call.  A function must not call itself.
    """

    @cached_property
    def _part(self) -> CPUDispatcher:
        """The part, without a wrapper for Python."""
        options = self.targetoptions | {"no_cpython_wrapper": True}
        made = CPUDispatcher(self.py_func, targetoptions=options, pipeline_class=PartCompiler)
        if _is_kept(self.py_func):
            made._cache = _PartCache(self.py_func)
        return made

    def get_call_template(self, args: Any, kws: Any) -> Any:
        """Return the types of a call by another function; compile the part for it.

        Numba has a type for every number in a source, for which it would compile a part once more.
        """
        plain = tuple(unliteral(given) for given in args)
        return self._part.get_call_template(plain, kws)

    def get_overload(self, sig: Any) -> Any:
        """Return the key of the part."""
        return self._part.get_overload(sig)

    def compile(self, sig: Any) -> Any:
        """Compile the function for Python, and load the environments of its parts."""
        with _without_collection():
            entry = super().compile(sig)
        made = self.overloads[tuple(_arguments(sig))]
        for environment in made._find_referenced_environments():
            made.codegen.set_env(environment.env_name, environment)
        return entry


@contextlib.contextmanager
def _without_collection() -> Iterator[None]:
    """Pause the collection of garbage, which takes a tenth of compiling and finds little."""
    if not gc.isenabled():
        yield
        return
    gc.disable()
    try:
        yield
    finally:
        gc.enable()


def _tell_listeners() -> None:
    """Call the listeners once compiling has taken its time."""
    now = time.monotonic()
    _missed[:] = _missed or [now]
    while on_compile and now - _missed[0] >= PATIENCE:
        on_compile.pop()()


def _is_kept(function: Callable[..., Any]) -> bool:
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


@cache
def source_hash(module: str) -> str:
    """Hash of a module's source and of all modules of the package that it imports, and so on."""
    parts: list[str | bytes] = []
    for path in sorted(_sources_of(module)):
        parts += [path.relative_to(PACKAGE).as_posix(), path.read_bytes()]
    return storage.content_hash(*parts)[:16]


@cache
def is_edited(module: str) -> bool:
    """Return whether sources of a module's code have changed while this process ran.

    It may have read them before the change. Then the hash is not that of what it compiles, and code
    kept under it would break other processes: so such code is neither kept nor looked for.
    """
    written = [path.stat().st_mtime for path in _sources_of(module)]
    return any(STARTED < when <= time.time() for when in written)


def sources_hash(folders: Sequence[str]) -> str:
    """Hash of the sources in some folders of the package."""
    parts: list[str | bytes] = []
    for name in folders:
        for path in sorted((PACKAGE / name).rglob("*.py")):
            parts += [path.name, path.read_bytes()]
    return storage.content_hash(*parts)[:16]


@cache
def _sources_of(module: str) -> set[Path]:
    """The file of a module and of all that it imports from the package."""
    found: set[Path] = set()
    waiting = [module]
    while waiting:
        path = _path_of(waiting.pop())
        if path is not None and path not in found:
            found.add(path)
            waiting += _imports_of(path)
    return found


@cache
def _path_of(module: str) -> Path | None:
    """File of a module of the package, None if the name is something else."""
    place = PACKAGE.joinpath(*module.split(".")[1:])
    if place == PACKAGE or module.startswith(UNCALLED):
        return None  # the package's front door imports everything
    for path in (place.with_suffix(".py"), place / "__init__.py"):
        if path.is_file():
            return path
    return None


@cache
def _imports_of(path: Path) -> list[str]:
    """Return modules of the package that a file imports, among other names."""
    found = []
    for parent, names, whole in _IMPORT.findall(path.read_text(encoding="utf-8")):
        found.append(whole or parent)
        found += [f"{parent}.{name}" for name in re.findall(r"\w+", names)]
    return found


class _Locator:
    """Folder of a function's code, as numba asks for it."""

    def __init__(self, py_func: Callable[..., Any], py_file: str) -> None:
        self._py_file = py_file
        self._line = py_func.__code__.co_firstlineno
        self._stamp = source_hash(py_func.__module__)
        self._folder = folder() / f"{py_func.__module__.removeprefix('gcm_learn.')}-{self._stamp}"

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


class _Cache(FunctionCache):
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
        if code is None:
            _tell_listeners()
        return code

    def save_overload(self, sig: Any, data: Any) -> None:
        """Keep the code of a signature; where that cannot be done it is not kept."""
        with contextlib.suppress(Exception):
            if _may_keep(sig):
                super().save_overload(sig, data)

    def _index_key(self, sig: Any, codegen: Any) -> str:
        """Return a hash of types of arguments, of the sources behind them, and of the machine."""
        known = [(module, source_hash(module)) for module in _modules_of(_arguments(sig))]
        types = [str(given) for given in _arguments(sig)]
        _, *machine = super()._index_key(None, codegen)
        return storage.content_hash(repr((types, known, machine, NUMBA)))[:24]


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


class _PartCache(_Cache):
    _impl_class = _PartImpl


def _arguments(sig: Any) -> tuple[Any, ...]:
    """Return the types of a signature's arguments."""
    return tuple(getattr(sig, "args", sig))


def _may_keep(sig: Any) -> bool:
    """Return whether the sources behind all types of arguments are ours, and known."""
    return all(_is_ours(m) and not is_edited(m) for m in set(_modules_of(_arguments(sig))))
