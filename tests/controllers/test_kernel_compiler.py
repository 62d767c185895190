"""Kernels are compiled once for all entry points that call them, and for functions that numba alone compiles."""

import gc
import os
import subprocess
import sys

import numba
import pytest
from numba.core.compiler import Compiler
from numba.core.errors import TypingError
from numba.extending import register_jitable

from controllers.compiled import compiled, compiled_in_place
from controllers.kernel_compiler import IDLE_PASSES, EntryCompiler, _without

uncached = numba.njit(error_model="numpy", pipeline_class=EntryCompiler)
"""Compiles an entry point anew at every run of the tests, whatever is on disk."""


@register_jitable
def deepest(number):
    return 2.0 * number


@register_jitable
def between(number):
    return deepest(number) + 1.0


@register_jitable
def uppermost(number):
    return between(number) + deepest(number)


def test_kernel_of_an_entry_point_serves_another_and_a_function_of_the_user():
    assert compiled_in_place(lambda number: uppermost(number))(3.0) == 13.0
    assert compiled(lambda number: between(number) * uppermost(number))(3.0) == 7.0 * 13.0
    of_the_user = numba.njit(error_model="numpy")  # the same, else kernels would be compiled anew
    assert of_the_user(lambda number: uppermost(number) - between(number))(3.0) == 6.0


def test_no_kernel_and_no_entry_point_is_wrapped_for_c():
    entry = uncached(lambda number: uppermost(number) - 1.0)
    assert entry(3.0) == 12.0
    (code,) = entry.inspect_llvm().values()
    assert "cfunc." not in code


def test_entry_point_calls_a_function_that_numba_has_compiled():
    own = numba.njit(lambda number: uppermost(number) + 0.5)
    assert own(4.0) == 17.5
    assert compiled_in_place(lambda number: own(number) + deepest(number))(4.0) == 25.5


SCRIPT = """
import sys
import numba
from numba.extending import register_jitable
from controllers.compiled import compiled_in_place

@register_jitable
def kernel(number):
    return 2.0 * number

@numba.njit(cache=True)
def callee(number):
    return kernel(number) + 0.5

@compiled_in_place
def entry(number):
    return callee(number) + 1.0

print({"callee": callee, "entry": entry}[sys.argv[1]](4.0))
"""


def test_callee_that_was_loaded_from_disk_is_part_of_what_is_saved(tmp_path):
    script = tmp_path / "script.py"
    script.write_text(SCRIPT)
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path / "cache"), "PYTHONPATH": os.pathsep.join(sys.path)}
    for which, expected in (("callee", "8.5"), ("entry", "9.5"), ("entry", "9.5")):
        done = subprocess.run(
            [sys.executable, str(script), which], env=environment, capture_output=True, text=True, check=False
        )
        assert (done.returncode, done.stdout.strip()) == (0, expected), done.stderr


def test_what_the_compiler_sets_aside_is_back_after_a_function_that_cannot_be_compiled():
    before = Compiler.define_pipelines, gc.isenabled()
    with pytest.raises(TypingError):
        uncached(lambda number: number.nothing)(3.0)
    assert (Compiler.define_pipelines, gc.isenabled()) == before == (before[0], True)


def test_passes_that_kernels_do_not_need_are_left_out_for_those_of_the_packages_alone(monkeypatch):
    made = []

    def note(chosen, pipeline):
        short = _without(chosen, pipeline)
        made.append([[kind for kind, _ in passes.passes] for passes in (pipeline, short)])
        return short

    monkeypatch.setattr("controllers.kernel_compiler._without", note)
    assert uncached(lambda number: sum([each * number for each in (1.0, 2.0)]))(3.0) == 9.0
    assert made == []

    def kernel(number):
        return number + 1.0

    kernel.__module__ = "controllers.kernels"  # a new one, which no other test has had compiled
    register_jitable(kernel)
    assert uncached(lambda number: kernel(number))(3.0) == 4.0
    (long, short), *_ = made
    assert [kind for kind in long if kind not in short] == sorted(IDLE_PASSES, key=long.index)
    assert set(IDLE_PASSES) <= set(long)
