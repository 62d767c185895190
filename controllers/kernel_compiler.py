"""Compilation of an entry point and the kernels that it calls, each of them optimised once.

Numba makes machine code of every function that compiled code calls, although all of it is linked into the caller and
made anew there: with kernels that call kernels, the same code is optimised and emitted once a level. Here kernels stay
as they are lowered until the entry point is complete, which halves the time (``python -m benchmarks.speed``).
"""

from typing import Any

from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler


class _Unchanged:
    """What stands for the code generator of a kernel: a kernel without machine code has no place for an environment."""

    def __init__(self, generator: Any) -> None:
        self._generator = generator

    def set_env(self, name: str, environment: Any) -> None:
        """Leave the environment, which only functions that raise or print use, unset."""

    def __getattr__(self, name: str) -> Any:
        return getattr(self._generator, name)


class KernelLibrary(JITCodeLibrary):
    """Code of a function that only compiled code calls: linked into its callers, never emitted on its own."""

    @property
    def codegen(self) -> Any:
        """The code generator."""
        return _Unchanged(self._codegen)

    def get_pointer_to_function(self, name: str) -> int:
        """Return zero: there is no machine code to point to."""
        self._ensure_finalized()  # type: ignore[no-untyped-call]
        return 0

    def _optimize_functions(self, module: Any) -> None:
        """Leave it to the entry point."""

    def _optimize_final_module(self) -> None:
        """Leave it to the entry point."""

    def _finalize_final_module(self) -> None:
        self._finalize_dynamic_globals()  # type: ignore[no-untyped-call]
        self._verify_declare_only_symbols()  # type: ignore[no-untyped-call]
        self._finalized = True


class EntryCompiler(Compiler):
    """Numba's compiler, for an entry point."""

    def _compile_core(self) -> Any:
        generator = self.state.targetctx.codegen()
        if self.state.library is None:
            self.state.library = JITCodeLibrary(generator, self.state.func_id.func_qualname)  # type: ignore[no-untyped-call]
            self.state.library.enable_object_caching()
        others, generator._library_class = generator._library_class, KernelLibrary
        try:
            return super()._compile_core()  # type: ignore[no-untyped-call]
        finally:
            generator._library_class = others
