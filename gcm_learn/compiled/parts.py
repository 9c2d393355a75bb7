"""Numba's compiler in two kinds: for functions that Python calls, and for parts that they link.

Numba optimises a function together with all code below it, and makes machine code of that, once
for each level of calls.  Parts are only simplified and kept as LLVM's bitcode.  A function that
Python calls is optimised together with its parts.  It is optimised once more if counts of
references went that span several blocks: only without them some loops are simple enough.

Numba makes the named tuples that it returns by Python functions.  The handler of a signal, such as
that of Ctrl-C, may raise within one, and numba overlooks that: the process ends by a segmentation
fault.  Here functions in C make them, which run no handlers.
"""

from __future__ import annotations

import contextlib
import gc
from collections.abc import Callable, Iterator
from functools import cache, cached_property, partial
from typing import Any, ClassVar

import llvmlite.binding as llvm
from numba.core import pythonapi, serialize
from numba.core.boxing import box_tuple
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler
from numba.core.registry import CPUDispatcher
from numba.core.types.containers import NamedTuple, NamedUniTuple
from numba.core.types.misc import unliteral

from gcm_learn.compiled.cache import Cache


class _Library(JITCodeLibrary):  # type: ignore[misc]
    """Code of one compiled function."""

    def _run(self, **options: Any) -> None:
        """Run numba's passes over the code."""
        made = self._codegen._module_pass_manager(**options)
        passes, *builder = made if isinstance(made, tuple) else (made,)  # by numba's version
        passes.run(self._final_module, *builder)


def _counts_across_blocks() -> int:
    """Return how many counts of references have gone, in this process, that span several blocks."""
    gone = llvm.dump_refprune_stats()
    return int(gone.diamond + gone.fanout + gone.fanout_raise)


class WholeLibrary(_Library):
    """Machine code of a function that Python calls, together with that of its parts."""

    def _optimize_final_module(self) -> None:
        before = _counts_across_blocks()
        super()._optimize_final_module()
        if _counts_across_blocks() != before:
            self._run()

    def serialize_using_object_code(self) -> Any:
        """Return the machine code with stubs in place of bitcode: callers here link parts."""
        self._ensure_finalized()
        names = [made.name for made in self._final_module.functions if not made.is_declaration]
        stubs = "".join(f'define void @"{name}"() {{ ret void }}\n' for name in names)
        code = self._get_compiled_object(), llvm.parse_assembly(stubs).as_bitcode()
        return self.name, "object", code


class PartLibrary(_Library):
    """Code of one part: other functions link it, Python cannot call it."""

    def _optimize_final_module(self) -> None:
        levels = {"opt": self._codegen._opt_level, "loop_vectorize": self._codegen._loopvect}
        self._run(cost="cheap", slp_vectorize=False, **levels)

    def _finalize_final_module(self) -> None:
        """Finalise without making and loading machine code, as numba would here."""
        self._finalize_dynamic_globals()
        self._verify_declare_only_symbols()
        self._finalized = True

    def get_pointer_to_function(self, name: str) -> int:
        """Return 0: no such function is in memory."""
        return 0

    def serialize_using_object_code(self) -> Any:
        """Return the bitcode, in place of machine code."""
        return self.serialize_using_bitcode()

    @property
    def codegen(self) -> PartLibrary:
        """The library itself: numba takes `set_env` from here."""
        return self

    def set_env(self, name: str, environment: Any) -> None:
        """Do nothing: environments lie in the functions that link the part."""


class WholeCompiler(Compiler):  # type: ignore[misc]
    """Compiler of functions that Python calls."""

    library: ClassVar[type[_Library]] = WholeLibrary

    def define_pipelines(self) -> Any:
        """Return numba's passes; they write to the library that is there."""
        name = self.state.func_id.func_qualname
        self.state.library = self.library(self.state.targetctx.codegen(), name)
        self.state.library.enable_object_caching()
        return super().define_pipelines()


class PartCompiler(WholeCompiler):
    """Compiler of parts."""

    library = PartLibrary


class PartCache(Cache):
    """Kept code of a part."""

    def _rebuilt(self, target_context: Any, data: Any) -> Any:
        codegen = target_context.codegen()
        codegen._library_class, whole = PartLibrary, codegen._library_class
        try:
            return super()._rebuilt(target_context, data)
        finally:
            codegen._library_class = whole


class _Kernel(CPUDispatcher):  # type: ignore[misc]
    """Compiled function in two forms: one for Python, and a part for other compiled functions.

    Each is compiled at its first call.  A function must not call itself.
    """

    @cached_property
    def _part(self) -> CPUDispatcher:
        """The part, without a wrapper for Python."""
        options = self.targetoptions | {"no_cpython_wrapper": True}
        made = CPUDispatcher(self.py_func, targetoptions=options, pipeline_class=PartCompiler)
        made._cache = PartCache(self.py_func, "part-")
        return made

    def get_call_template(self, args: Any, kws: Any) -> Any:
        """Return the types of a call by another function; compile the part for these types.

        Literals lose their own types, or numba would compile a part once more for every number.
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
        made = self.overloads[tuple(getattr(sig, "args", sig))]
        for environment in made._find_referenced_environments():
            made.codegen.set_env(environment.env_name, environment)
        return entry


def kernel(function: Callable[..., Any], options: dict[str, Any]) -> Any:
    """Return `function` as a kernel that is compiled at its first call.

    It has no wrapper for callers in C, which takes a seventh of compiling.
    """
    options = {"nopython": True, "boundscheck": None, "no_cfunc_wrapper": True} | options
    made = _Kernel(function, targetoptions=options, pipeline_class=WholeCompiler)
    made._cache = Cache(function)
    return made


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


def replace_numbas() -> None:
    """Let numba make named tuples and classes by functions in C, in this process."""
    for kind in (NamedTuple, NamedUniTuple):
        pythonapi._boxers.functions[kind] = _box_named_tuple
    if not hasattr(serialize._numba_unpickle, "cache_info"):
        serialize._numba_unpickle = cache(serialize._numba_unpickle)


def _box_named_tuple(typ: Any, val: Any, c: Any) -> Any:
    """Return a pointer to the named tuple of a native value."""
    make = partial(tuple.__new__, typ.instance_class)
    maker = c.pyapi.unserialize(c.pyapi.serialize_object(make))
    items = box_tuple(typ, val, c)
    made = c.pyapi.call_function_objargs(maker, (items,))
    c.pyapi.decref(maker)
    c.pyapi.decref(items)
    return made
