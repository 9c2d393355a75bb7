"""Cache of machine code under hashes of its sources, and code that was compiled ahead.

Numba's cache renews a function when its own file changes, but not when a function that it calls
does.  It keeps code beside the sources, where an installed package must not write.  Here code lies
in the user's cache folder, under the hash of a module's source and of all modules of this package
that it imports.  A change renews what depends on it, and equal sources share their code.  Each file
holds the code for one list of types of arguments, under a hash of these types and of the sources
behind them.  Code that cannot be read is compiled.

If that folder lacks the code, a second one is read: the package `gcm_learn_kernels`. Its code was
compiled ahead, for a kind of processor whose features this processor has.
"""

from __future__ import annotations

import contextlib
import importlib.util
import io
import json
import os
import pickle
import sys
import zlib
from collections.abc import Callable, Iterator
from functools import cache, cached_property
from pathlib import Path
from typing import Any, NamedTuple

from llvmlite import binding as llvm
from numba import __version__ as NUMBA
from numba.core.compiler import CompileResult
from numba.core.environment import Environment, _rebuild_env, lookup_environment
from numba.core.runtime import rtsys
from numba.core.serialize import dumps

from gcm_learn import storage
from gcm_learn.compiled.notice import folder, tell_listeners
from gcm_learn.compiled.sources import folder_of, is_edited, source_hash

KERNELS = "gcm_learn_kernels"
"""Package with code that was compiled ahead, in its folder ``kernels`` with `MADE_FOR`."""
MADE_FOR = "made_for.json"


def _modules_of(given: Any) -> Iterator[str]:
    """Yield the modules of all named tuples among types of arguments, and within them."""
    made = getattr(given, "instance_class", None)
    if made is not None:
        yield str(made.__module__)
    for part in getattr(given, "types", given if isinstance(given, tuple) else ()):
        yield from _modules_of(part)


class Place(NamedTuple):
    """Folder of code, and the machine that the code is for."""

    folder: Path
    machine: tuple[str, str, str]
    """Platform, processor and its features, as LLVM names them."""


@cache
def ahead() -> Place | None:
    """Return the place of code compiled ahead; None if unwanted, missing or for another CPU."""
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
    return Place(place, (triple, processor, features)) if here else None


class Cache:
    """Cache of one function's code, with the methods that numba calls.

    Errors in reading or writing code never reach the caller.

    Code for limbs of other modules is compiled anew in each process.  The hash lacks the sources of
    these modules, and other processes may be unable to import them.  Numba's own cache has one
    index of a function's files, which has to be locked while it is written.

    Parameters
    ----------
    function : callable
    kind : str
        Prefix of the files' names.
    """

    def __init__(self, function: Callable[..., Any], kind: str = "") -> None:
        self._function = function
        name = function.__qualname__.replace("<", "").replace(">", "")
        self._name = f"{kind}{name}-{function.__code__.co_firstlineno}"

    @cached_property
    def _folder(self) -> str:
        """Name of the folder of the function's module."""
        return folder_of(self._function.__module__)

    @property
    def cache_path(self) -> str:
        """The folder."""
        return str(folder() / self._folder)

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Return the kept code of a signature; None if the code has to be compiled."""
        for place in (Place(folder(), _machine(target_context.codegen())), ahead()):
            with contextlib.suppress(Exception):  # whatever is wrong with what is kept
                if place is not None and self._may_keep(sig):
                    return self._rebuilt(target_context, _read(self._file(place, sig)))
        tell_listeners()
        return None

    def _rebuilt(self, target_context: Any, data: Any) -> Any:
        """Return the kept code as a compile result, ready to run.

        Numba's own cache would load the whole compiler, which takes a fifth of a start.
        """
        rtsys.initialize(target_context)
        return CompileResult._rebuild(target_context, *data)

    def save_overload(self, sig: Any, data: Any) -> None:
        """Keep the code of a signature on disk, if that can be done."""
        with contextlib.suppress(Exception):
            if self._may_keep(sig) and not data.library.has_dynamic_globals:
                file = self._file(Place(folder(), _machine(data.codegen)), sig)
                code = dumps(data._reduce())
                file.parent.mkdir(parents=True, exist_ok=True)
                storage.write_whole(file, _checksum(file, code) + code)

    def flush(self) -> None:
        """Remove the function's files, as numba asks before it compiles anew."""
        for path in Path(self.cache_path).glob(f"{self._name}.*.nbc"):
            path.unlink(missing_ok=True)

    def _may_keep(self, sig: Any) -> bool:
        """Return whether the sources of function and argument types are ours and unedited."""
        modules = {self._function.__module__, *_modules_of(_arguments(sig))}
        return all(m.partition(".")[0] == "gcm_learn" and not is_edited(m) for m in modules)

    def _file(self, place: Place, sig: Any) -> Path:
        """Return the file of a signature.

        Its name has a hash of types of arguments, of the sources behind them, and of the machine.
        """
        known = [(module, source_hash(module)) for module in _modules_of(_arguments(sig))]
        types = [str(given) for given in _arguments(sig)]
        made_of = types, known, place.machine, self._code, sys.version_info[:2], NUMBA
        key = storage.content_hash(repr(made_of))[:24]
        return place.folder / self._folder / f"{self._name}.{key}.nbc"

    @cached_property
    def _code(self) -> str:
        """Hash of the function's own bytecode, and of the values in its closure."""
        cells = [cell.cell_contents for cell in self._function.__closure__ or ()]
        return storage.content_hash(self._function.__code__.co_code, dumps(cells))


def _checksum(path: Path, code: bytes | memoryview) -> bytes:
    """Return the checksum of code, bound to the names of its file and folder."""
    place = f"{path.parent.name}/{path.name}".encode()
    return zlib.crc32(code, zlib.crc32(place)).to_bytes(4, "little")


def _read(path: Path) -> Any:
    """Return the data in a file, behind a checksum."""
    code = memoryview(path.read_bytes())
    if code[:4] != _checksum(path, code[4:]):
        raise ValueError("damaged")
    return _Unpickler(io.BytesIO(code[4:])).load()


class _Unpickler(pickle.Unpickler):
    """Unpickler that restores functions' constants without loading the functions' modules."""

    def find_class(self, module: str, name: str, /) -> Any:
        return _environment if name == _rebuild_env.__name__ else super().find_class(module, name)


def _environment(module: str, constants: Any, name: str) -> Any:
    """Return a compiled function's environment of constants, without loading its module."""
    made = lookup_environment(name)
    if made is None:
        made = Environment(vars(sys.modules.get(module, sys)))
        made.consts[:] = constants
        made.env_name = name
        Environment._memo[name] = made
    return made


def _machine(codegen: Any) -> tuple[str, str, str]:
    """Return the machine for which code is made."""
    machine: tuple[str, str, str] = codegen.magic_tuple()
    return machine


def _arguments(sig: Any) -> tuple[Any, ...]:
    """Return the types of a signature's arguments."""
    return tuple(getattr(sig, "args", sig))
