"""A variable is read only where it has a value, by whatever way that place is reached."""

import numpy as np
import pytest
from kernels_from_text import from_text

from controllers.kernels.language import NotTranslatable


def kernel_of(lines, tmp_path, monkeypatch):
    body = "".join(f"    {each}\n" for each in lines.split("\n"))
    head = "import math\nCOUNT = 3\n\n\ndef kernel(x, n, t):\n"
    return from_text(head + body, tmp_path, monkeypatch)


@pytest.mark.parametrize(
    ("lines", "line"),
    [
        ("if x > 0.0:\n    y = x\nreturn y", 8),
        ("if x > 0.0:\n    y = x\nelif x < -1.0:\n    y = -x\nreturn y", 10),
        ("if x > 0.0:\n    y = x\ny += 1.0\nreturn y", 8),
        ("for i in range(n):\n    y = x\nreturn y", 8),
        ("for i in range(n):\n    x += 1.0\nreturn i", 8),
        ("for i in range(3, 3):\n    y = x\nreturn y", 8),
        ("for i in range(3):\n    if i == n:\n        break\n    y = x\nreturn y", 10),
        ("for i in range(3):\n    if i == n:\n        continue\n    y = x\nreturn y", 10),
        ("while x > 0.0:\n    x -= 1.0\n    y = x\nreturn y", 9),
        ("for i in range(3):\n    if i > 0:\n        x += y\n    else:\n        y = x\nreturn x", 8),
        ("while True:\n    if x > 2.0:\n        break\n    y = x\n    x += 1.0\nreturn y", 11),
        ("if n > 0:\n    if x > 0.0:\n        y = x\n    else:\n        return x\nreturn y", 11),
        ("for i in range(3):\n    x += 1.0\nreturn x + i", 8),
    ],
)
def test_a_variable_without_a_value_is_refused(lines, line, tmp_path, monkeypatch):
    with pytest.raises(NotTranslatable, match="has no value here; give it one before the branch or loop") as error:
        kernel_of(lines, tmp_path, monkeypatch)(1.0, 2, np.ones((2, 3)))
    assert f".py:{line}: kernel: " in str(error.value)


@pytest.mark.parametrize(
    "lines",
    [
        "if x > 0.0:\n    y = x\nelse:\n    y = -x\nreturn y",
        "if x > 0.0:\n    y = x\nelse:\n    return -1.0\nreturn y",
        "if x <= 0.0:\n    return -1.0\nelif n > 1:\n    y = 2.0\nelse:\n    y = 3.0\nreturn y",
        "if COUNT == 3:\n    y = x\nreturn y",
        "if x > 0.0:\n    y = x\ny = 2.0\nreturn y",
        "if x > 0.0:\n    y = x\n    x = y + 1.0\nreturn x",
        "for i in range(3):\n    y = x + i\nreturn y",
        "for i in range(COUNT - 1, -1, -1):\n    y = x + i\nreturn y",
        "for i in range(3):\n    y = x\n    if i == n:\n        break\n    x += 1.0\nreturn y",
        "for i in range(3):\n    y = x\n    if i == n:\n        continue\n    x += 1.0\nreturn y",
        "while True:\n    x += 1.0\n    y = 2.0 * x\n    if x > 9.0:\n        break\nreturn y",
        "while True:\n    x = x * 0.5\n    if x < 1.0:\n        return x",
        "while False:\n    x += 1.0\nreturn x",
        "for i in range(n):\n    y = x\n    x += y\nreturn x",
        "y = 0.0\nfor i in range(n):\n    y = x\nreturn y",
    ],
)
def test_a_variable_with_a_value_on_every_way_is_read(lines, tmp_path, monkeypatch):
    kernel = kernel_of(lines, tmp_path, monkeypatch)
    for x, n in ((1.5, 2), (-0.5, 0), (30.0, 7)):
        assert kernel(x, n, np.ones((2, 3))) == kernel.py_func(x, n, np.ones((2, 3)))
