"""Kernels drawn at random from the language do the same as machine code as in Python, to the bit."""

import random

import numpy as np
import pytest
from kernels_from_text import from_text

KERNELS = 12
HEAD = "import math\n\n\n"
FUNCTIONS = ("math.sin", "math.atan", "math.sinh", "abs", "math.floor", "-")


class Drawn:
    """Draws expressions and statements over the real numbers x, y, z and the integers i, n."""

    def __init__(self, seed):
        self.draw = random.Random(seed)

    def real(self, depth):
        draw = self.draw
        if depth == 0:
            return draw.choice(["x", "y", "z", "i", "n", repr(round(draw.uniform(-3.0, 3.0), 3))])
        one, two = self.real(depth - 1), self.real(draw.randrange(depth))
        return draw.choice(
            [
                *(f"({one} {sign} {two})" for sign in "+-*"),
                f"({one} / (1.5 + abs({two})))",
                f"min({one}, {two})",
                f"max({one}, {two})",
                f"({one} if {self.truth(depth - 1)} else {two})",
                f"{draw.choice(FUNCTIONS)}(math.atan({one}))",
                f"math.copysign({one}, {two})",
                f"({self.whole(depth - 1)} + 0.5)",
            ]
        )

    def whole(self, depth):
        draw = self.draw
        if depth == 0:
            return draw.choice(["i", "n", str(draw.randrange(-9, 9))])
        one, two = self.whole(depth - 1), self.whole(draw.randrange(depth))
        divisor = draw.choice([-7, -3, 2, 5])
        return draw.choice([f"({one} + {two})", f"({one} - {two})", f"({one} // {divisor})", f"({one} % {divisor})"])

    def truth(self, depth):
        draw = self.draw
        if depth == 0:
            return f"{self.real(0)} {draw.choice(['<', '<=', '>', '>=', '==', '!='])} {self.real(0)}"
        one, two = self.truth(depth - 1), self.truth(depth - 1)
        return draw.choice([f"({one} and {two})", f"({one} or {two})", f"not ({one})", f"{one}"])

    def statements(self, depth, indent="    ", inner=False):
        draw, lines = self.draw, []
        for _ in range(draw.randrange(1, 4)):
            kind = draw.randrange(6) if depth else draw.randrange(3)
            if kind < 2:
                lines.append(f"{draw.choice('xyz')} {draw.choice(['=', '+=', '-='])} math.atan({self.real(2)})")
            elif kind == 2:
                lines.append(f"i = {self.whole(2)} % 11")
            elif kind == 3:
                lines += [f"if {self.truth(1)}:", *self.statements(depth - 1, "    ", inner)]
                lines += ["else:", *self.statements(depth - 1, "    ", inner)] if draw.random() < 0.5 else []
            elif kind == 4:
                start, stop, step = draw.choice([(0, 4, 1), (3, -1, -1), (-2, 3, 1)])
                lines += [f"for k{depth} in range({start}, {stop}, {step}):", f"    z += 0.25 * k{depth}"]
                lines += self.statements(depth - 1, "    ", True)
            elif inner:
                lines += [f"if {self.truth(0)}:", f"    {draw.choice(['break', 'continue', 'return x, y, z, i'])}"]
        return [indent + line for line in lines or ["z += x"]]

    def kernel(self, name):
        body = "\n".join(self.statements(3))
        return f"def {name}(x, y, n):\n    z = 0.5\n    i = 1\n{body}\n    return x, y, z, i\n\n\n"


@pytest.mark.parametrize("seed", range(4))
def test_kernels_drawn_at_random_are_the_same_as_machine_code(seed, tmp_path, monkeypatch):
    drawn = Drawn(seed)
    names = [f"drawn_{number}" for number in range(KERNELS)]
    calls = ", ".join(f"{name}(x, y, n)" for name in names)
    text = HEAD + "".join(map(drawn.kernel, names)) + f"def kernel(x, y, n):\n    return {calls}\n"
    kernel = from_text(text, tmp_path, monkeypatch)
    for _ in range(25):
        given = (
            drawn.draw.uniform(-4.0, 4.0),
            drawn.draw.choice([0.0, -0.0, 1.0, 1e-9, -2.5]),
            drawn.draw.randrange(-5, 6),
        )
        expected, found = kernel.py_func(*given), kernel(*given)
        for one, other in zip(expected, found, strict=True):
            assert [type(value) for value in other[:3]] == [float] * 3
            assert np.array_equal(other, one)
            assert np.array_equal(np.signbit(other), np.signbit(one))
