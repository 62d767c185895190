"""Compilation of an entry point and the kernels that it calls, each of them linked and optimised once.

Numba makes machine code of every function that compiled code calls, although all of it is linked into the caller and
made anew there: with kernels that call kernels, the same code is copied, optimised and emitted once a level. Here
kernels stay as they are lowered, each in a module of its own, until the entry point gathers them
(``python -m benchmarks.speed`` measures the time).
"""

import gc
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from llvmlite.binding import Linkage
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler
from numba.core.compiler_machinery import PassManager
from numba.core.typed_passes import NopythonRewrites
from numba.core.untyped_passes import InlineClosureLikes, WithLifting

from controllers.kernel_sources import KERNEL_PACKAGES


class _Unchanged:
    """What stands for the code generator of a kernel: a kernel without machine code has no place for an environment."""

    def __init__(self, generator: Any) -> None:
        self._generator = generator

    def set_env(self, name: str, environment: Any) -> None:
        """Leave the environment, which only functions that raise or print use, unset."""

    def __getattr__(self, name: str) -> Any:
        return getattr(self._generator, name)


class KernelLibrary(JITCodeLibrary):
    """Code of a function that only compiled code calls: linked into entry points, never emitted on its own."""

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

    def finalize(self) -> None:
        """Leave linking to the entry point: what the kernel calls is not copied into it."""
        self._finalize_dynamic_globals()  # type: ignore[no-untyped-call]
        for function in self._final_module.functions:
            if not function.is_declaration and function.linkage == Linkage.external:
                function.linkage = "linkonce_odr"  # may be linked more than once, and goes where it was inlined
        self._finalized = True

    @property
    def module(self) -> Any:
        """Code of the kernel alone."""
        self._ensure_finalized()  # type: ignore[no-untyped-call]
        return self._final_module

    def _get_module_for_linking(self) -> Any:
        """Return the kernel with all that it calls: what a function wants that numba's own compiler compiles."""
        if self._shared_module is None:
            self._shared_module = self.module.clone()
            _link_with_callees(self._shared_module, self._linking_libraries)
        return self._shared_module


class EntryLibrary(JITCodeLibrary):
    """Code of an entry point: gathers the kernels that it calls, those that they call, and so on, each once."""

    def finalize(self) -> None:
        """Link all kernels, optimise the whole and make machine code of it."""
        for library in _link_with_callees(self._final_module, self._linking_libraries):
            for name in getattr(library, "_reload_init", ()):  # of which older versions of numba know nothing
                self._reload_init.add(name)
        self._linking_libraries = []
        super().finalize()  # type: ignore[no-untyped-call]

    def _optimize_final_module(self) -> None:
        """Optimise once, and leave loops as they are.

        Numba's first, cheaper round serves to prune counted references, which kernels do not have. Loops of kernels go
        over a dozen numbers or end early: made for several at once, they are as slow and more to compile.
        """
        found = self._codegen._module_pass_manager(loop_vectorize=False)  # type: ignore[no-untyped-call]
        manager, *builder = found if isinstance(found, tuple) else (found,)  # older versions of numba have no builder
        manager.run(self._final_module, *builder)


def _link_with_callees(module: Any, libraries: list[Any]) -> set[Any]:
    """Link libraries into a module, and all that the kernels among them call, each once; return them."""
    seen: set[Any] = set()
    waiting = list(reversed(libraries))
    while waiting:
        library = waiting.pop()
        if library in seen:
            continue
        seen.add(library)
        # what was loaded from disk, or linked for numba's own compiler, is complete already
        if isinstance(library, KernelLibrary) and library._shared_module is None:
            module.link_in(library.module, preserve=True)
            waiting.extend(reversed(library._linking_libraries))
        else:
            module.link_in(library._get_module_for_linking(), preserve=True)
    return seen


IDLE_PASSES = (WithLifting, InlineClosureLikes, NopythonRewrites)
"""Passes of numba that go through a function for what kernels do not contain: context managers, functions within it,
expressions of whole arrays."""


def _without(idle: tuple[type, ...], pipeline: Any) -> Any:
    """Return a pipeline without some passes."""
    make: Any = PassManager
    short = make(pipeline.pipeline_name)
    for chosen, description in pipeline.passes:
        if chosen not in idle:
            short.add_pass(chosen, description)
    short.finalize()
    return short


@contextmanager
def without_collection() -> Iterator[None]:
    """Look for no garbage in cycles: what the compiler makes is kept until it ends, and is gone through in vain."""
    collects = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if collects:
            gc.enable()


class EntryCompiler(Compiler):
    """Numba's compiler, for an entry point."""

    def _compile_core(self) -> Any:
        context: Any = type(self.state.targetctx)
        generator = self.state.targetctx.codegen()
        others, make_wrapper = generator._library_class, context.create_cfunc_wrapper
        if self.state.library is None:
            self.state.library = EntryLibrary(generator, self.state.func_id.func_qualname)  # type: ignore[no-untyped-call]
            self.state.library.enable_object_caching()
        own = self.state.library if self.state.flags.no_cpython_wrapper else None

        def wrap(owner: Any, library: Any, *about: Any) -> None:
            """Let C call the entry point, where it is for C: kernels have no use for what lets C call them."""
            if library is own:
                make_wrapper(owner, library, *about)

        define: Any = Compiler.define_pipelines

        def define_short(compiler: Any) -> list[Any]:
            """Leave out the passes for what kernels do not contain."""
            pipelines = define(compiler)
            ours = compiler.state.func_id.modname.partition(".")[0] in KERNEL_PACKAGES
            return [_without(IDLE_PASSES, pipeline) if ours else pipeline for pipeline in pipelines]

        generator._library_class, context.create_cfunc_wrapper = KernelLibrary, wrap
        Compiler.define_pipelines = define_short  # type: ignore[method-assign]
        try:
            with without_collection():
                return super()._compile_core()  # type: ignore[no-untyped-call]
        finally:
            generator._library_class, context.create_cfunc_wrapper = others, make_wrapper
            Compiler.define_pipelines = define  # type: ignore[method-assign]
