"""Assignment to all elements of an array does what numpy does, and reads nothing beyond an end."""

import numpy as np
import pytest
from kernels_from_text import from_text

from controllers.kernels.errors import NotTranslatable

COPY = "def kernel(a, b):\n    a[:] = b\n"


@pytest.fixture(scope="module")
def copy(tmp_path_factory):
    with pytest.MonkeyPatch.context() as patch:
        yield from_text(COPY, tmp_path_factory.mktemp("copy"), patch)


@pytest.mark.parametrize(
    ("shape", "given"),
    [
        ((3,), (3,)),
        ((3,), (1,)),
        ((1,), (1,)),
        ((0,), (1,)),
        ((0,), (0,)),
        ((2, 3), (2, 3)),
        ((2, 3), (1, 3)),
        ((2, 3), (2, 1)),
        ((2, 3), (1, 1)),
        ((2, 3, 4), (2, 1, 4)),
    ],
)
def test_arrays_are_copied_and_repeated_as_numpy_does(shape, given, copy):
    for kind in (np.float64, np.int64, np.bool_):
        other = (np.arange(np.prod(given)).reshape(given) % 5 + 1).astype(kind)
        found, expected = np.zeros(shape, kind), np.zeros(shape, kind)
        copy(found, other)
        copy.py_func(expected, other)
        np.testing.assert_array_equal(found, expected)


def test_of_different_sizes_what_both_have_is_copied(copy):
    longer = np.array([7.0, 8.0, 9.0])
    memory = np.arange(6.0)
    copy(longer, memory[:2])  # the third element of the memory is not read
    assert longer.tolist() == [0.0, 1.0, 9.0]
    copy(memory[:2], np.full(3, -1.0))
    assert memory.tolist() == [-1.0, -1.0, 2.0, 3.0, 4.0, 5.0]
    table = np.zeros((3, 2))
    copy(table, np.array([[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]))
    assert table.tolist() == [[1.0, 2.0], [4.0, 5.0], [0.0, 0.0]]


@pytest.mark.parametrize(("to", "source"), [(slice(0, 4), slice(1, 5)), (slice(1, 5), slice(0, 4))])
def test_arrays_that_overlap_are_copied_as_they_were(to, source, copy):
    found, expected = np.arange(5.0), np.arange(5.0)
    copy(found[to], found[source])
    copy.py_func(expected[to], expected[source])
    np.testing.assert_array_equal(found, expected)


@pytest.mark.parametrize("line", ["row[:] = bump(row)", "row[:] = row[0] + 1.0", "table[place(row)][:] = row[0]"])
def test_the_value_is_computed_before_the_array(line, tmp_path, monkeypatch):
    text = (
        "def bump(row):\n    row[0] += 1.0\n    return row[0]\n\n"
        "def place(row):\n    return 1\n\n"
        f"def kernel(table, row):\n    {line}\n    return row[0]\n"
    )
    kernel = from_text(text, tmp_path, monkeypatch)
    found, expected = np.zeros((2, 2)), np.zeros((2, 2))
    rows = np.ones(3), np.ones(3)
    assert kernel(found, rows[0]) == kernel.py_func(expected, rows[1])
    np.testing.assert_array_equal(found, expected)
    np.testing.assert_array_equal(*rows)


@pytest.mark.parametrize(
    ("line", "advice"),
    [
        ("row[:, :] = 1.0", "row[:, :] has more places than the array has dimensions"),
        ("row[:] = table", "must be given a number or an array like it"),
        ("row[:] = row.size > 1", "is no number"),
    ],
)
def test_what_does_not_fit_is_refused(line, advice, tmp_path, monkeypatch):
    kernel = from_text(f"def kernel(row, table):\n    {line}\n", tmp_path, monkeypatch)
    with pytest.raises(NotTranslatable) as error:
        kernel(np.ones(3), np.ones((2, 2)))
    assert advice in str(error.value)
