"""Numba's compiler in two kinds: for functions that Python calls, and for parts that they link.

Numba optimises a function together with all code below it, and makes machine code of that, once
for each level of calls.  Parts are only simplified and kept as LLVM's bitcode.  A function that
Python calls is optimised together with its parts.  It is optimised once more if counts of
references went that span several blocks: only without them some loops are simple enough.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, ClassVar

import llvmlite.binding as llvm
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler


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
    """Code of a function that Python calls, with that of its parts."""

    def _optimize_final_module(self) -> None:
        before = _counts_across_blocks()
        super()._optimize_final_module()
        if _counts_across_blocks() != before:
            self._run()


class PartLibrary(_Library):
    """Code of one part: others link it, Python cannot call it."""

    def _optimize_final_module(self) -> None:
        levels = {"opt": self._codegen._opt_level, "loop_vectorize": self._codegen._loopvect}
        self._run(cost="cheap", slp_vectorize=False, **levels)

    def _finalize_final_module(self) -> None:
        """Leave out what numba does here: make machine code and load it."""
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


@contextmanager
def loading(target_context: Any) -> Iterator[None]:
    """Let numba load parts in place of functions."""
    codegen = target_context.codegen()
    codegen._library_class, whole = PartLibrary, codegen._library_class
    try:
        yield
    finally:
        codegen._library_class = whole
