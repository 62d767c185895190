"""Kernels of all that their language has; each is run as Python and as machine code by the tests."""

import math
from typing import Any, NamedTuple

import numpy as np

from controllers.kernels.language import dispatched, natural

LEVEL = 2.5
"""A level, and a count;"""

FLOOR = -0.5
COUNT: int = 3
"""both are written out."""


class Point(NamedTuple):
    """A record of numbers."""

    x: float
    y: float = 0.5


class Body(NamedTuple):
    """A record of all kinds of values."""

    moving: bool
    at: Point
    count: int
    past: tuple[float, ...]
    row: Any
    table: Any
    last: bool


def arithmetic(a, b, n):
    """Every operator on numbers."""
    return a + b * 2 - a / b + n * 3 - n / 2 + (n - 4) * (n + 1) + a**2 + abs(a) ** b + -a + abs(n - 9)


def mathematics(a):
    first = math.exp(-a) + math.log(a + 2.0) + math.sqrt(a) + math.sin(a) + math.cos(a) + math.tan(a) + math.atan(a)
    second = math.expm1(a) + math.log1p(a) + math.sinh(a) + math.cosh(a) + math.tanh(a) + math.asinh(a)
    third = math.asin(0.5 * a) + math.acos(0.5 * a) + math.atan2(a, -1.0) + math.pow(a, 1.5) + math.fabs(-a)
    return first, second, third + math.copysign(a, -1.0)


def whole_numbers(a, n) -> tuple:
    return math.floor(a), math.ceil(a), int(a), int(n), float(n), int(a > 0.0), abs(n)


def divided(n, m):
    return n // m, n % m, (n + 9) % 4, abs(n) // 3


def choices(a, b, n):
    return max(a, b), min(a, b, LEVEL), max(b, FLOOR), max(n, 2), min(n, 1, 7), max(n, a)


def tests(a, b) -> int:
    bits = 0
    bits += 1 if a < b else 0
    bits += 2 if a <= b else 0
    bits += 4 if a > b else 0
    bits += 8 if a >= b else 0
    bits += 16 if a == b else 0
    bits += 32 if a != b else 0
    bits += 64 if math.isfinite(a) else 0
    bits += 128 if math.isnan(b) else 0
    bits += 256 if not (a < b) else 0
    bits += 512 if np.isfinite(b) and not np.isnan(a) else 0
    return bits


def joined(a, b, flag):
    one = a > 0.0 and b > 0.0 and flag
    two = a > 0.0 or b > 0.0 or flag
    three = True and a > 0.0
    four = (b > 0.0 and False) or flag
    five = -1.0 < a < b <= 2.0
    return one, two, three, four, five, a > 0.0 or True


def first_of(row):
    """Elements are asked for only where they are."""
    return row.size > 5 and row[5] > 0.0


def compared_last(row, a):
    """Only the first comparison of a chain is always made."""
    return 0.0 < a < row[int(a)]


def branches(a, n):
    if a > 1.0:
        kind = 1
        value = a
    elif a > 0.0:
        kind = 2
        value = 2.0 * a
    else:
        kind = 3
        if n > 2:
            return -a
        value = -1.0
    if COUNT == 3:
        value += 1.0
    else:
        value = math.nan
    return value * kind


def nested(a, b, n):
    """Choices within the tests of others, and branches within what another one leaves."""
    found = 1.0 if (a > 0.0 if b > 0.0 else a < b) else (2.0 if n > 1 else a)
    for i in range(n):
        if i > 1 and (b > a or a > 2.0):
            found += a if found > b else -b
        else:
            # comments stand where they stood
            found -= b
            if found < -a:
                found = abs(found) if -(a + b) < a - (b - a) <= n else found * 0.5
        while found > (2.0 if b > 0.0 else 1.0) and found < 1e3:
            found *= 0.25
    return found, -(a - b), not (a > b) or (b > 1.0 and a > 1.0)


def chosen(flag, body):
    point = body.at if flag else Point(1.0, 2.0)
    row = body.row if flag else body.table[0]
    return point.x + row[0] if not flag else point.y - row[1], 1 if flag else 0.5


def sums(row, table):
    total = 0.0
    for i in range(table.shape[0]):
        for j in range(1, table.shape[1]):
            if i == j:
                continue
            total += table[i, j] * row[j]
    for i in range(row.size - 1, -1, -1):
        if row[i] < 0.0:
            break
        total -= row[i]
    for _ in range(COUNT):
        total *= 1.5
    return total


def waiting(a):
    count = 0
    while a > 1.0 and count < 100:
        a *= 0.5
        if a < 0.001:
            break
        count += 1
    return count, a


def from_the_end(row, table, n):
    past = (row[0], row[1], row[2])
    return row[-1], row[n], table[-1, n], table[n][-2], past[n], past[-3], table[-2][natural(1)]


def changed(row, table, a):
    row[0] = a
    row[1] += 2.0
    row[-1] *= a
    table[1, 0] = row[0] + row[1]
    line = table[0]
    line[1] = -a
    table[2][1] = 7
    kept = row.size
    for i in range(row.size):
        row[i] = a if kept > 2 else 0.0
    return table[0, 1] + row[2] + table.size


def exchanged(a, b, body):
    a, b = b, a
    one, two = body.at, Point(a, b)
    for _ in range(3):
        one, two = two, Point(one.x + 1.0, two.y)
    x, y = two
    return a, b, one, x - y


def kept_from_a_loop(row):
    """A record of one turn of a loop, after the next ones."""
    found = Point(0.0, 0.0)
    for i in range(row.size):
        point = Point(row[i], i)
        if row[i] > 1.0:
            found = point
    return found


def made(body, a):
    point = Point(*body.past[1:])
    again = Point(y=a, x=1.0)
    past = (*body.past[1:], a)
    count = Body(not body.moving, again, body.count + 1, past, body.row, body.table, body.last)
    return count, Point(a), point, (point, again)


def scaled(point, factor=2.0, *, lift=0.0) -> Point:
    return Point(point.x * factor, point.y * factor + lift)


def length(point) -> float:
    """Give a number, once an integer."""
    if point.x == 0.0 and point.y == 0.0:
        return 0
    return math.sqrt(point.x**2 + point.y**2)


def is_far(point) -> bool:
    return length(point) > LEVEL


def fill(row, a):
    if a >= 0.0:
        for i in range(row.size):
            row[i] = a


def calls(point, row, a):
    fill(row, a)
    fill(row, -1.0)
    near = scaled(scaled(point, lift=a), factor=0.5)
    return near, length(near), is_far(near), is_far(Point(0.0, 0.0)), length(Point(0.0, 0.0)), row[0]


def items(body):
    return body[1].x, body.past[0], body.table.shape[1], body.at[-1], math.pi


def shadowed(a):
    """An argument that gets other values, among them an integer."""
    if a > 2.0:
        a = 2
    a -= 0.5
    return a


SHAPES: dict = {}


class Circle(NamedTuple):
    """A class that has a kernel of its own."""

    radius: float


class Square(NamedTuple):
    """Another one."""

    side: float


def _circle(shape, factor):
    return factor * shape.radius


def _square(shape, factor):
    return factor * shape.side**2


SHAPES[Circle], SHAPES[Square] = _circle, _square


def _measure(shape, factor):
    return SHAPES[type(shape)](shape, factor)


measure = dispatched(SHAPES, _measure)


def both(circle, square, a):
    return measure(circle, a) + measure(square, factor=a)


def commented(a, n):
    """Give a sum and its negative.

    Returns
    -------
    above, below : float
        The sum, and its negative.
    """
    # comments may stand above a statement,
    # in several lines
    total = (
        a  # beside one part of it
        + 1.0  # and another
    )
    for i in range(n):  # beside the head of a loop
        # within it
        total += i  # beside a statement

    if total > LEVEL:  # beside that of a branch
        total = LEVEL
    # before the end
    return total, -total  # and at it


def on_its_own(a):
    """A string and nothing else stand for no statement."""
    pass
    return a
