"""Kernels are compiled once for all entry points that call them, and for functions that numba alone compiles."""

import numba
from numba.extending import register_jitable

from controllers.compiled import compiled, compiled_in_place


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
    assert numba.njit(lambda number: uppermost(number) - between(number))(3.0) == 6.0


def test_entry_point_calls_a_function_that_numba_has_compiled():
    own = numba.njit(lambda number: uppermost(number) + 0.5)
    assert own(4.0) == 17.5
    assert compiled_in_place(lambda number: own(number) + deepest(number))(4.0) == 25.5
