"""Arrays in memory: compiled code finds the elements, rows and shapes that numpy has there."""

from typing import NamedTuple

import numpy as np
import pytest
from numba.core.errors import TypingError

from controllers.memory_arrays import type_in_memory
from tests.helpers.in_memory import run_in_memory


class Tables(NamedTuple):
    line: np.ndarray
    flags: np.ndarray
    counts: np.ndarray
    matrix: np.ndarray
    cube: np.ndarray


def made():
    return Tables(
        np.arange(1.0, 6.0),
        np.array([True, False, True]),
        np.arange(10, 13),
        np.arange(12.0).reshape(3, 4),
        np.arange(24.0).reshape(2, 3, 4),
    )


def elements(tables, i, j):
    return (
        tables.line[2],
        tables.line[i],
        tables.line[-1],
        tables.line[-i],
        tables.counts[i],
        not tables.flags[i],
        1 if tables.flags[2] else 2,
        tables.matrix[1, 2],
        tables.matrix[i, j],
        tables.matrix[-1, -j],
        tables.cube[1, i, j],
    )


def rows(tables, i, j):
    plane, row = tables.cube[i], tables.cube[i, j]
    return tables.matrix[i][j], tables.matrix[-1][-1], plane[j, 3], row[3], row[-2], plane.shape, row.size


def sizes(tables):
    return (
        tables.line.size,
        tables.line.shape,
        tables.matrix.size,
        tables.matrix.shape,
        tables.cube.size,
        tables.cube.shape,
    )


def sum_of_cube(tables):
    total = 0.0
    for i in range(tables.cube.shape[0]):
        for j in range(tables.cube.shape[1]):
            for k in range(tables.cube.shape[2]):
                total += (100 * i + 10 * j + k) * tables.cube[i, j, k]
    return total


@pytest.mark.parametrize(
    ("function", "arguments"), [(elements, (1, 2)), (elements, (2, 3)), (rows, (1, 2)), (rows, (0, 1)), (sizes, ())]
)
def test_compiled_code_finds_what_numpy_finds(function, arguments):
    assert run_in_memory(function, made(), *arguments) == function(made(), *arguments)


def test_every_element_is_found():
    assert run_in_memory(sum_of_cube, made()) == sum_of_cube(made())


def write(tables, i, value):
    tables.line[0] = value
    tables.line[-1] = 2.0 * value
    tables.counts[i] = 7
    tables.flags[0] = tables.line[1] < 0.0
    tables.matrix[i, 3] = 3.0 * value
    tables.cube[1][i][2] = 4.0 * value
    tables.cube[0, i, -1] += 1


def test_what_is_written_stands_in_the_arrays():
    tables, expected = made(), made()
    run_in_memory(write, tables, 2, 0.5)
    write(expected, 2, 0.5)
    for found, wanted in zip(tables, expected, strict=True):
        np.testing.assert_array_equal(found, wanted)
    assert not np.array_equal(expected.line, made().line)


@pytest.mark.parametrize(
    "function",
    [
        lambda tables: tables.line[1:],
        lambda tables: tables.line[0.5],
        lambda tables: tables.line[0, 0],
        lambda tables: tables.matrix[0, 0, 0],
        lambda tables: tables.line.T,
    ],
)
def test_what_is_neither_element_nor_row_is_not_compiled(function):
    with pytest.raises(TypingError):
        run_in_memory(function, made())


def test_row_is_not_written_by_a_number():
    def write_row(tables):
        tables.matrix[0] = 1.0

    with pytest.raises(TypingError):
        run_in_memory(write_row, made())


def test_array_that_must_not_be_written_is_not():
    tables = made()
    tables.line.setflags(write=False)
    assert run_in_memory(elements, tables, 1, 2) == elements(made(), 1, 2)
    with pytest.raises(TypingError):
        run_in_memory(write, tables, 2, 0.5)


@pytest.mark.parametrize(
    "matrix", [np.eye(4)[:, 1:3], np.asfortranarray(np.arange(6.0).reshape(2, 3)), np.arange(8.0)[::2]]
)
def test_array_with_gaps_is_refused(matrix):
    with pytest.raises(ValueError, match=r"array of shape \(.*\) is not allowed: it must be contiguous"):
        type_in_memory(made()._replace(matrix=matrix))
