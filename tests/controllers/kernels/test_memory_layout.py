"""Nested named tuples in memory: what compiled code reads there and writes there is what Python sees."""

from typing import NamedTuple

import numpy as np
import pytest

from controllers.compiled import compiled
from controllers.kernels.memory import Memory


class Inner(NamedTuple):
    flag: bool
    number: float
    other: bool


class Outer(NamedTuple):
    first: bool
    inner: Inner
    count: int
    line: tuple[float, ...]
    vector: np.ndarray
    again: Inner
    matrix: np.ndarray
    last: bool


def made():
    return Outer(
        True, Inner(False, 1.5, True), -7, (2.0, 3.0), np.arange(3.0), Inner(True, 4.0, False), np.eye(2), True
    )


def read(value):
    value.vector[0] = 9.0
    return (
        value.first,
        value.inner,
        value.count,
        value.line,
        value.vector[2],
        value.matrix[1, 1],
        value.again,
        value.last,
    )


def test_compiled_code_reads_what_was_laid_down():
    value = made()
    found = compiled(read)(value)
    assert found == (value.first, value.inner, value.count, value.line, 2.0, 1.0, value.again, value.last)
    assert value.vector[0] == 9.0


def test_value_comes_back_with_the_same_arrays():
    value = made()
    memory = Memory(value)
    assert memory.value.vector is value.vector
    assert memory.value.matrix is value.matrix
    changed = value._replace(count=8, inner=Inner(True, 2.5, False), vector=np.ones(3))
    memory.value = changed
    assert (memory.value.count, memory.value.inner) == (8, changed.inner)
    assert memory.value.vector is changed.vector


def test_numbers_of_numpy_are_those_that_compiled_code_sees():
    assert Memory(Inner(np.bool_(True), np.float64(2.0), False)).value == (True, 2.0, False)


@pytest.mark.parametrize("value", ["text", None, 1j, np.float32(1.0)])
def test_what_has_no_place_is_refused(value):
    with pytest.raises(TypeError, match="compiled code takes numbers and arrays"):
        Memory(Inner(True, value, False))
