"""Code that compiled functions link: the part of another compiled function.

Numba optimises a function together with all code below it, and makes machine code of that, once
for each level of calls.  Parts are only simplified and kept as LLVM's bitcode.  A function that
Python calls is optimised together with its parts, once.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler


class PartLibrary(JITCodeLibrary):  # type: ignore[misc]
    """Library of one part: others link it, Python cannot call it."""

    def _optimize_final_module(self) -> None:
        made = self._codegen._module_pass_manager(
            loop_vectorize=self._codegen._loopvect,
            slp_vectorize=False,
            opt=self._codegen._opt_level,
            cost="cheap",
        )
        passes, *builder = made if isinstance(made, tuple) else (made,)  # by numba's version
        passes.run(self._final_module, *builder)

    def _finalize_final_module(self) -> None:
        """Leave out what numba does here: make machine code and load it."""
        self._finalize_dynamic_globals()
        self._verify_declare_only_symbols()
        self._finalized = True

    def get_pointer_to_function(self, name: str) -> int:
        """Return 0, which tells numba that there is no such function in memory."""
        return 0

    def serialize_using_object_code(self) -> Any:
        """Return the bitcode, in place of machine code."""
        return self.serialize_using_bitcode()

    @property
    def codegen(self) -> PartLibrary:
        """The library, which is asked for `set_env` only."""
        return self

    def set_env(self, name: str, environment: Any) -> None:
        """Do nothing: environments lie in the functions that link the part."""


class PartCompiler(Compiler):  # type: ignore[misc]
    """Numba's compiler, with a library of parts."""

    def define_pipelines(self) -> Any:
        """Return numba's passes; they write to the library that is there."""
        name = self.state.func_id.func_qualname
        self.state.library = PartLibrary(self.state.targetctx.codegen(), name)
        return super().define_pipelines()


@contextmanager
def loading(target_context: Any) -> Iterator[None]:
    """Let numba load parts in place of functions."""
    codegen = target_context.codegen()
    codegen._library_class, whole = PartLibrary, codegen._library_class
    try:
        yield
    finally:
        codegen._library_class = whole
